//! Draws the interface over the fleet.

use egui::{ClippedPrimitive, TexturesDelta};
use egui_wgpu::{Renderer, RendererOptions, ScreenDescriptor};
use glam::UVec2;
use wgpu::{CommandBuffer, CommandEncoder, LoadOp, Operations, StoreOp, TextureFormat, TextureView};

use crate::gpu::device::Gpu;

/// What draws egui's triangles.
pub struct Painter {
    renderer: Renderer,
}

/// One picture of the interface.
pub struct Drawing {
    /// Triangles, in points.
    pub triangles: Vec<ClippedPrimitive>,
    /// Pixels of a point.
    pub pixels_per_point: f32,
    /// Pixels of the surface.
    pub size: UVec2,
}

impl Painter {
    /// Prepares for a surface.
    pub fn new(gpu: &Gpu, format: TextureFormat) -> Self {
        Self { renderer: Renderer::new(&gpu.device, format, RendererOptions::default()) }
    }

    /// Takes what changed of the textures. To be done even where nothing is drawn: changes come once.
    pub fn upload(&mut self, gpu: &Gpu, changes: &TexturesDelta) {
        for (id, changes) in &changes.set {
            for change in changes {
                self.renderer.update_texture(&gpu.device, &gpu.queue, *id, change);
            }
        }
    }

    /// Draws, and gives what is to be submitted before the encoder.
    pub fn draw(
        &mut self,
        gpu: &Gpu,
        encoder: &mut CommandEncoder,
        target: &TextureView,
        drawing: &Drawing,
    ) -> Vec<CommandBuffer> {
        let screen =
            ScreenDescriptor { size_in_pixels: drawing.size.to_array(), pixels_per_point: drawing.pixels_per_point };
        let before = self.renderer.update_buffers(&gpu.device, &gpu.queue, encoder, &drawing.triangles, &screen);
        let pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("interface"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: target,
                depth_slice: None,
                resolve_target: None,
                ops: Operations { load: LoadOp::Load, store: StoreOp::Store },
            })],
            ..wgpu::RenderPassDescriptor::default()
        });
        self.renderer.render(&mut pass.forget_lifetime(), &drawing.triangles, &screen);
        before
    }

    /// Forgets textures, after what drew with them was submitted.
    pub fn free(&mut self, changes: &TexturesDelta) {
        for id in &changes.free {
            self.renderer.free_texture(id);
        }
    }
}

impl std::fmt::Debug for Painter {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Painter").finish_non_exhaustive()
    }
}
