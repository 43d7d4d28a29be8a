//! Copies of pictures, pixel by pixel.

use glam::UVec2;
use wgpu::{
    BindGroup, BindGroupEntry, BindGroupLayout, BindingResource, PrimitiveTopology, RenderPass,
    RenderPipeline, Sampler, ShaderStages, TextureUsages, TextureView,
};

use super::bindings::{Binding, bind_group_layout};
use super::device::Gpu;
use super::pipeline::{DepthMode, PipelineDescriptor, TargetConfig, render_pipeline};
use super::resources::{texture, view_of};
use super::shaders::shader;

/// Copies pictures into the viewport of a render pass.
#[derive(Debug)]
pub struct Copier {
    target: TargetConfig,
    pipeline: RenderPipeline,
    layout: BindGroupLayout,
    sampler: Sampler,
}

/// A picture that is drawn into, and copied from.
#[derive(Debug)]
pub struct Original {
    /// What is drawn into.
    pub view: TextureView,
    group: BindGroup,
}

impl Copier {
    /// Creates the pipeline for passes with this target.
    pub fn new(gpu: &Gpu, target: TargetConfig, depth: DepthMode) -> Self {
        let layout = bind_group_layout(
            gpu,
            "copy",
            ShaderStages::FRAGMENT,
            &[Binding::Texture, Binding::Sampler],
        );
        let descriptor = PipelineDescriptor {
            module: &shader(gpu, "copy"),
            vertex: "place",
            fragment: "copied",
            groups: &[&layout],
            buffers: &[],
            topology: PrimitiveTopology::TriangleList,
            depth,
            blend: false,
        };
        let pipeline = render_pipeline(gpu, target, &descriptor);
        Self {
            target,
            pipeline,
            layout,
            sampler: gpu.device.create_sampler(&wgpu::SamplerDescriptor::default()),
        }
    }

    /// Creates a picture of `size` pixels.
    pub fn original(&self, gpu: &Gpu, size: UVec2) -> Original {
        let usage = TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING;
        let view = view_of(&texture(gpu, size, self.target.format, 1, usage));
        let entries = [
            BindGroupEntry { binding: 0, resource: BindingResource::TextureView(&view) },
            BindGroupEntry { binding: 1, resource: BindingResource::Sampler(&self.sampler) },
        ];
        let descriptor = wgpu::BindGroupDescriptor {
            label: Some("copy"),
            layout: &self.layout,
            entries: &entries,
        };
        Original { group: gpu.device.create_bind_group(&descriptor), view }
    }

    /// Copies a picture, which has the size of the viewport. Bind group 0 is then another one.
    pub fn copy(&self, pass: &mut RenderPass<'_>, original: &Original) {
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &original.group, &[]);
        pass.draw(0..3, 0..1);
    }
}
