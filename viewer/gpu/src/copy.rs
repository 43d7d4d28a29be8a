//! Pictures that are drawn by themselves and then copied, pixel by pixel: the ground while the
//! camera stands still, and pictures within a picture.

use bytemuck::Zeroable;
use glam::{UVec2, Vec4};
use regatta_scene::Layers;
use wgpu::{
    BindGroup, BindGroupLayout, CommandEncoder, LoadOp, PrimitiveTopology, RenderPass,
    RenderPipeline, Sampler, ShaderStages, TextureFormat, TextureUsages, TextureView,
};

use super::attachments::Attachments;
use super::bindings::{Binding, bind_group_layout, bind_texture};
use super::device::Gpu;
use super::pipeline::{DepthMode, PipelineDescriptor, TargetConfig, render_pipeline, shader};
use super::resources::{begin_pass, texture, view_of};
use super::view::ViewUniform;

/// Copies pictures into the viewport of a render pass.
#[derive(Debug)]
struct Copier {
    target: TargetConfig,
    pipeline: RenderPipeline,
    layout: BindGroupLayout,
    sampler: Sampler,
}

/// A picture that is drawn into, and copied from.
#[derive(Debug)]
struct Original {
    view: TextureView,
    group: BindGroup,
}

impl Copier {
    /// Creates the pipeline for passes with this target.
    fn new(gpu: &Gpu, target: TargetConfig, depth: DepthMode) -> Self {
        let bindings = [Binding::Texture, Binding::Sampler];
        let layout = bind_group_layout(gpu, "copy", ShaderStages::FRAGMENT, &bindings);
        let (module, groups) = (shader(gpu, "copy"), [&layout]);
        let descriptor = PipelineDescriptor {
            topology: PrimitiveTopology::TriangleList,
            depth,
            blend: None,
            ..PipelineDescriptor::new(&module, "place", "copied", &groups)
        };
        let pipeline = render_pipeline(gpu, target, &descriptor);
        let sampler = gpu.device.create_sampler(&wgpu::SamplerDescriptor::default());
        Self { target, pipeline, layout, sampler }
    }

    /// Creates a picture of `size` pixels.
    fn original(&self, gpu: &Gpu, size: UVec2) -> Original {
        let usage = TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING;
        let view = view_of(&texture(gpu, size, self.target.format, 1, usage));
        Original { group: bind_texture(gpu, &self.layout, &view, &self.sampler), view }
    }

    /// Copies a picture, which has the size of the viewport. Bind group 0 is then another one.
    fn copy(&self, pass: &mut RenderPass<'_>, original: &Original) {
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &original.group, &[]);
        pass.draw(0..3, 0..1);
    }
}

/// Pictures of one size, to be copied into parts of another one.
#[derive(Debug)]
pub struct Insets {
    gpu: Gpu,
    copier: Copier,
    size: UVec2,
    originals: Vec<Original>,
}

impl Insets {
    /// Creates the pipeline for targets of a format.
    pub fn new(gpu: &Gpu, format: TextureFormat) -> Self {
        let target = TargetConfig::new(gpu, format, 1);
        let copier = Copier::new(gpu, target, DepthMode::Absent);
        Self { gpu: gpu.clone(), copier, size: UVec2::ZERO, originals: Vec::new() }
    }

    /// Makes room for so many pictures of `size` pixels, and returns their views to draw into.
    pub fn make_room(&mut self, number: usize, size: UVec2) -> impl Iterator<Item = &TextureView> {
        if self.size != size {
            (self.size, self.originals) = (size, Vec::new());
        }
        self.originals.resize_with(number, || self.copier.original(&self.gpu, size));
        self.originals.iter().map(|original| &original.view)
    }

    /// Copies the pictures into a target. `places` are their top left corners in it; all of them
    /// lie within the target.
    pub fn copy(&self, encoder: &mut CommandEncoder, target: &TextureView, places: &[UVec2]) {
        let mut pass = begin_pass(encoder, "insets", target, LoadOp::Load);
        for (original, at) in self.originals.iter().zip(places) {
            let (at, size) = (at.as_vec2(), self.size.as_vec2());
            pass.set_viewport(at.x, at.y, size.x, size.y, 0.0, 1.0);
            self.copier.copy(&mut pass, original);
        }
    }
}

/// The look of the ground in a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Look {
    /// The view, without its values for robots.
    view: ViewUniform,
    edges: bool,
    arrows: bool,
    nodes: bool,
}

/// The source of the ground in a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// It is drawn: it looks different from the last picture.
    Drawn,
    /// It is drawn into the copy first: it looks as in the last picture, for the first time.
    DrawnToKeep,
    /// The copy is up to date.
    Kept,
}

/// Keeps a copy of the floor and the graph: while the camera stands still, they are the same in
/// every picture, and a copy is cheaper than drawing them again.
#[derive(Debug)]
pub struct Ground {
    target: TargetConfig,
    copier: Copier,
    /// The look in the last picture; `None` if the ground has changed since.
    last: Option<Look>,
    /// Whether the copy shows it.
    is_kept: bool,
    kept: Option<(Attachments, Original)>,
}

impl Ground {
    /// Creates the pipeline that copies the ground.
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
        let Layers { edges, arrows, nodes, .. } = layers;
        let look = Look { view: without_robots(view), edges, arrows, nodes };
        if self.last != Some(look) {
            (self.last, self.is_kept) = (Some(look), false);
            return Source::Drawn;
        }
        if self.is_kept {
            return Source::Kept;
        }
        if self.kept.as_ref().is_none_or(|(attachments, _)| attachments.size() != size) {
            self.kept = None;
            self.kept = gpu.allocate(|| {
                (Attachments::new(gpu, self.target, size), self.copier.original(gpu, size))
            });
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

/// Returns a view without the values for robots, which change from picture to picture.
fn without_robots(view: &ViewUniform) -> ViewUniform {
    ViewUniform {
        alpha: 0.0,
        teleport_distance: 0.0,
        robots: 0,
        previous_robots: 0,
        source: 0,
        low: 0.0,
        per_span: 0.0,
        categories: 0,
        detail: Vec4::ZERO,
        density: Vec4::ZERO,
        filtered: 0,
        palette: Zeroable::zeroed(),
        ..*view
    }
}
