//! The ground as a picture of its own: while the camera stands still, the floor and the graph are
//! the same in every picture, and a copy of them is cheaper than drawing them again.

use bytemuck::Zeroable;
use glam::UVec2;
use regatta_scene::Layers;
use wgpu::{CommandEncoder, RenderPass};

use super::attachments::Attachments;
use super::copy::{Copier, Original};
use super::device::Gpu;
use super::pipeline::{DepthMode, TargetConfig};
use super::view::ViewUniform;

/// What the ground looks like in a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Look {
    /// The view, without what is about robots.
    view: ViewUniform,
    /// Whether edges, arrows and nodes are shown.
    layers: [bool; 3],
}

/// How the ground gets into a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// It is drawn: it looks different from the last picture.
    Drawn,
    /// It is drawn into the copy first: it looks as in the last picture, for the first time.
    DrawnToKeep,
    /// The copy is up to date.
    Kept,
}

/// Keeps a copy of the ground.
#[derive(Debug)]
pub struct Ground {
    target: TargetConfig,
    copier: Copier,
    /// How the ground looked in the last picture; `None` if it has changed since.
    last: Option<Look>,
    /// Whether the copy shows it.
    is_kept: bool,
    kept: Option<(Attachments, Original)>,
}

impl Ground {
    pub fn new(gpu: &Gpu, target: TargetConfig) -> Self {
        let copier = Copier::new(gpu, target, DepthMode::Ignored);
        Self { target, copier, last: None, is_kept: false, kept: None }
    }

    /// Forgets how the ground looked: the graph, the heat map or the floor's picture has changed.
    pub fn forget(&mut self) {
        self.last = None;
    }

    /// Decides where the ground of a picture of `size` pixels comes from, and makes room for the
    /// copy.
    pub fn source(&mut self, gpu: &Gpu, view: &ViewUniform, layers: Layers, size: UVec2) -> Source {
        let look = Look {
            view: without_robots(view),
            layers: [layers.edges, layers.arrows, layers.nodes],
        };
        if self.last != Some(look) {
            (self.last, self.is_kept) = (Some(look), false);
            return Source::Drawn;
        }
        if self.is_kept {
            return Source::Kept;
        }
        if self.kept.as_ref().is_none_or(|(attachments, _)| attachments.size() != size) {
            self.kept = None;
            let create =
                || (Attachments::new(gpu, self.target, size), self.copier.original(gpu, size));
            self.kept = gpu.allocate(create);
        }
        self.is_kept = self.kept.is_some();
        if self.is_kept { Source::DrawnToKeep } else { Source::Drawn }
    }

    /// Begins the pass that draws the copy, if there is one.
    pub fn begin_pass<'a>(
        &self,
        encoder: &'a mut CommandEncoder,
        view: &ViewUniform,
    ) -> Option<RenderPass<'a>> {
        let (attachments, original) = self.kept.as_ref()?;
        Some(attachments.begin_pass(encoder, &original.view, view.sky, None))
    }

    /// Draws the copy. Bind group 0 is then another one.
    pub fn draw(&self, pass: &mut RenderPass<'_>) {
        if let Some((_, original)) = &self.kept {
            self.copier.copy(pass, original);
        }
    }
}

/// Returns a view without what is about robots, which changes from picture to picture.
fn without_robots(view: &ViewUniform) -> ViewUniform {
    ViewUniform {
        clip_from_local: view.clip_from_local,
        eye: view.eye,
        forward: view.forward,
        right: view.right,
        up: view.up,
        viewport: view.viewport,
        crop: view.crop,
        origin: view.origin,
        sky: view.sky,
        floor: view.floor,
        grid: view.grid,
        spacing: view.spacing,
        floor_bounds: view.floor_bounds,
        edge: view.edge,
        two_way: view.two_way,
        node: view.node,
        heated: view.heated,
        lights: view.lights,
        ..Zeroable::zeroed()
    }
}
