//! The drawing of the fleet and the interface on the window's surface.

use std::time::{Duration, Instant};

use egui::Rect;
use glam::{UVec2, Vec2};
use regatta_plugin::Result;

use super::{ViewerWindow, size_of};
use crate::gpu::painter::Drawing;
use crate::window::surface::{NoCanvas, WindowSurface, create_surface};

impl ViewerWindow {
    /// Draws the fleet and the interface. Returns how long it has waited for the screen.
    pub(super) fn paint(&mut self, picture: Rect, mut output: egui::FullOutput, now: Instant) -> Result<Duration> {
        self.input.handle_platform_output(&self.window, std::mem::take(&mut output.platform_output));
        let changes = std::mem::take(&mut output.textures_delta);
        self.painter.upload(&self.gpu, &changes);
        let before = Instant::now();
        let canvas = self.surface.acquire(&self.gpu);
        let mut waited = before.elapsed();
        match canvas {
            Ok(canvas) => {
                let scale = output.pixels_per_point;
                let triangles = self.context.tessellate(std::mem::take(&mut output.shapes), scale);
                let mut encoder = self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
                let (at, size) = pixels(picture, scale, canvas.size);
                let (camera, alpha) = (self.interface.camera_controller.camera(), self.stage.alpha(now));
                self.stage.draw_within(&mut encoder, &canvas.fleet, Some((at, canvas.size)), &camera, size, alpha);
                let drawing = Drawing { triangles, pixels_per_point: scale, size: canvas.size };
                self.painter.draw(&self.gpu, &mut encoder, &canvas.interface, &drawing);
                self.gpu.queue.submit([encoder.finish()]);
                let before = Instant::now();
                canvas.present(&self.gpu);
                waited += before.elapsed();
                if let Some(seconds) = self.stage.renderer.poll_gpu_seconds() {
                    self.timing.push_gpu(seconds as f32);
                }
            }
            Err(NoCanvas::Hidden) => {}
            Err(NoCanvas::Later) => self.frame_pacing.schedule(now + Duration::from_millis(5)),
            Err(NoCanvas::Lost) => self.recreate_surface()?,
        }
        self.painter.free(changes);
        Ok(waited)
    }

    /// Replaces a lost surface.
    fn recreate_surface(&mut self) -> Result {
        tracing::info!("the window's surface was lost; creating another one");
        if self.gpu.lost().is_none() {
            let surface = create_surface(&self.instance, &self.window)?;
            self.surface = WindowSurface::new(surface, &self.gpu, size_of(&self.window))?;
        }
        self.frame_pacing.schedule(Instant::now());
        Ok(())
    }
}

/// Returns position and size of the picture on the canvas in pixels: at least one pixel, and within the canvas.
fn pixels(picture: Rect, scale: f32, canvas: UVec2) -> (UVec2, UVec2) {
    let corner = |at: egui::Pos2| (Vec2::new(at.x, at.y) * scale).round().max(Vec2::ZERO).as_uvec2();
    let low = corner(picture.min).min(canvas - 1);
    let high = corner(picture.max).min(canvas).max(low + 1);
    (low, high - low)
}
