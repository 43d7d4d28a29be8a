//! The attachments of the fleet's render pass: depth, and the multisampled colours where there are
//! any.

use glam::{UVec2, Vec4};
use wgpu::{
    Color, CommandEncoder, LoadOp, Operations, RenderPass, RenderPassColorAttachment, StoreOp,
    TextureUsages, TextureView,
};

use super::device::Gpu;
use super::pipeline::{DEPTH_FORMAT, TargetConfig};
use super::resources::{far_depth, stored, texture, view_of};
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
        let (samples, usage) = (target.samples, TextureUsages::RENDER_ATTACHMENT);
        let colours =
            (samples > 1).then(|| view_of(&texture(gpu, size, target.format, samples, usage)));
        Self {
            size,
            depth: view_of(&texture(gpu, size, DEPTH_FORMAT, samples, usage)),
            samples: colours,
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
        let load = LoadOp::Clear(Color { r, g, b, a });
        let colours = match &self.samples {
            Some(samples) => RenderPassColorAttachment {
                resolve_target: Some(target),
                ops: Operations { load, store: StoreOp::Discard },
                ..stored(samples, load)
            },
            None => stored(target, load),
        };
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("fleet"),
            color_attachments: &[Some(colours)],
            depth_stencil_attachment: Some(far_depth(&self.depth)),
            timestamp_writes: timer.map(Timer::end),
            ..wgpu::RenderPassDescriptor::default()
        })
    }
}
