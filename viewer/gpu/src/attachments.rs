//! The attachments of the fleet's render pass: depth, and the multisampled colours where there are
//! any.

use glam::{UVec2, Vec4};
use wgpu::{
    Color, CommandEncoder, LoadOp, Operations, RenderPass, StoreOp, TextureUsages, TextureView,
};

use super::device::Gpu;
use super::pipeline::{DEPTH_FORMAT, TargetConfig};
use super::resources::{texture, view_of};
use super::timer::Timer;

/// Textures of the target's size that the render pass needs beside the target.
#[derive(Debug)]
pub struct Attachments {
    size: UVec2,
    depth: TextureView,
    /// The multisampled colours, which are resolved into the target; `None` with one sample per
    /// pixel.
    samples: Option<TextureView>,
}

impl Attachments {
    /// Creates the attachments for a target of `size` pixels.
    pub fn new(gpu: &Gpu, target: TargetConfig, size: UVec2) -> Self {
        let make =
            |format, samples| texture(gpu, size, format, samples, TextureUsages::RENDER_ATTACHMENT);
        let samples = target.samples;
        Self {
            size,
            depth: view_of(&make(DEPTH_FORMAT, samples)),
            samples: (samples > 1).then(|| view_of(&make(target.format, samples))),
        }
    }

    /// The target's width and height in pixels.
    pub fn size(&self) -> UVec2 {
        self.size
    }

    /// Begins the render pass of a picture, cleared to the colour of the sky.
    pub fn begin_pass<'a>(
        &self,
        encoder: &'a mut CommandEncoder,
        target: &TextureView,
        sky: Vec4,
        timer: Option<&Timer>,
    ) -> RenderPass<'a> {
        let [r, g, b, a] = sky.to_array().map(f64::from);
        let (view, resolve_target, store) = match &self.samples {
            Some(samples) => (samples, Some(target), StoreOp::Discard),
            None => (target, None, StoreOp::Store),
        };
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("fleet"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view,
                depth_slice: None,
                resolve_target,
                ops: Operations { load: LoadOp::Clear(Color { r, g, b, a }), store },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &self.depth,
                depth_ops: Some(Operations { load: LoadOp::Clear(0.0), store: StoreOp::Discard }),
                stencil_ops: None,
            }),
            timestamp_writes: timer.map(Timer::end),
            ..wgpu::RenderPassDescriptor::default()
        })
    }
}
