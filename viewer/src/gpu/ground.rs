//! The ground as a picture of its own: while the camera stands still, the floor and the graph are the same in every picture,
//! and a copy of them is cheaper than drawing them again.

use bytemuck::Zeroable;
use glam::UVec2;
use wgpu::{
    BindGroup, BindGroupEntry, BindGroupLayout, BindingResource, CommandEncoder, PrimitiveTopology, RenderPass,
    RenderPipeline, Sampler, ShaderStages, TextureUsages, TextureView,
};

use super::attachments::Attachments;
use super::bindings::{Binding, bind_group_layout};
use super::device::Gpu;
use super::pipeline::{DepthMode, PipelineDescriptor, TargetConfig, render_pipeline};
use super::resources::{texture, view_of};
use super::shaders::shader;
use super::view::ViewUniform;
use crate::scene::Layers;

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
    copy: RenderPipeline,
    layout: BindGroupLayout,
    sampler: Sampler,
    /// How the ground looked in the last picture; `None` if it has changed since.
    last: Option<Look>,
    /// Whether the copy shows it.
    is_kept: bool,
    kept: Option<Kept>,
}

/// The copy.
#[derive(Debug)]
struct Kept {
    attachments: Attachments,
    view: TextureView,
    group: BindGroup,
}

impl Ground {
    pub fn new(gpu: &Gpu, target: TargetConfig, view: &BindGroupLayout) -> Self {
        let bindings = [Binding::Texture, Binding::Sampler];
        let layout = bind_group_layout(gpu, "ground", ShaderStages::FRAGMENT, &bindings);
        let descriptor = PipelineDescriptor {
            module: &shader(gpu, "ground"),
            vertex: "place",
            fragment: "copied",
            groups: &[view, &layout],
            buffers: &[],
            topology: PrimitiveTopology::TriangleList,
            depth: DepthMode::Ignored,
            blend: false,
        };
        Self {
            target,
            copy: render_pipeline(gpu, target, &descriptor),
            sampler: gpu.device.create_sampler(&wgpu::SamplerDescriptor::default()),
            layout,
            last: None,
            is_kept: false,
            kept: None,
        }
    }

    /// Forgets how the ground looked: the graph, the heat map or the floor's picture has changed.
    pub fn forget(&mut self) {
        self.last = None;
    }

    /// Decides where the ground of a picture of `size` pixels comes from, and makes room for the copy.
    pub fn source(&mut self, gpu: &Gpu, view: &ViewUniform, layers: Layers, size: UVec2) -> Source {
        let look = Look { view: without_robots(view), layers: [layers.edges, layers.arrows, layers.nodes] };
        if self.last != Some(look) {
            (self.last, self.is_kept) = (Some(look), false);
            return Source::Drawn;
        }
        if self.is_kept {
            return Source::Kept;
        }
        if self.kept.as_ref().is_none_or(|kept| kept.attachments.size() != size) {
            self.kept = None;
            self.kept = gpu.allocate(|| self.create(gpu, size));
        }
        self.is_kept = self.kept.is_some();
        if self.is_kept { Source::DrawnToKeep } else { Source::Drawn }
    }

    fn create(&self, gpu: &Gpu, size: UVec2) -> Kept {
        let usage = TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING;
        let view = view_of(&texture(gpu, size, self.target.format, 1, usage));
        let entries = [
            BindGroupEntry { binding: 0, resource: BindingResource::TextureView(&view) },
            BindGroupEntry { binding: 1, resource: BindingResource::Sampler(&self.sampler) },
        ];
        let descriptor = wgpu::BindGroupDescriptor { label: Some("ground"), layout: &self.layout, entries: &entries };
        let group = gpu.device.create_bind_group(&descriptor);
        Kept { attachments: Attachments::new(gpu, self.target, size), view, group }
    }

    /// Begins the pass that draws the copy, if there is one.
    pub fn begin_pass<'a>(&self, encoder: &'a mut CommandEncoder, view: &ViewUniform) -> Option<RenderPass<'a>> {
        let kept = self.kept.as_ref()?;
        Some(kept.attachments.begin_pass(encoder, &kept.view, view.sky, None))
    }

    /// Draws the copy.
    pub fn draw(&self, pass: &mut RenderPass<'_>) {
        let Some(kept) = &self.kept else { return };
        pass.set_pipeline(&self.copy);
        pass.set_bind_group(1, &kept.group, &[]);
        pass.draw(0..3, 0..1);
    }
}

/// Returns a view without what is about robots, which changes from picture to picture.
fn without_robots(view: &ViewUniform) -> ViewUniform {
    let ViewUniform { clip_from_local, eye, forward, right, up, viewport, crop, origin, .. } = *view;
    let ViewUniform { sky, floor, grid, spacing, floor_bounds, edge, two_way, node, heated, lights, .. } = *view;
    let camera = ViewUniform { clip_from_local, eye, forward, right, up, viewport, crop, origin, ..Zeroable::zeroed() };
    ViewUniform { sky, floor, grid, spacing, floor_bounds, edge, two_way, node, heated, lights, ..camera }
}
