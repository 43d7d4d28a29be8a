//! The drawing of the fleet and the interface on the window's surface.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use egui::{Rect, ViewportId};
use glam::{UVec2, Vec2};
use image::RgbaImage;
use regatta_gpu::painter::Drawing;
use regatta_plugin::Result;
use wgpu::CommandEncoder;

use super::{ViewerWindow, size_of};
use crate::picture::write_png;
use crate::window::surface::{Canvas, NoCanvas, WindowSurface, create_surface};

/// Changes of textures that are forgotten if winit panics because the display has gone. egui's own
/// type would panic again, which ends the process (in builds with debug assertions).
struct TextureChanges(egui::TexturesDelta);

impl Drop for TextureChanges {
    fn drop(&mut self) {
        self.0.clear();
    }
}

impl ViewerWindow {
    /// Draws the fleet and the interface. Returns how long it has waited for the screen.
    pub(super) fn paint(
        &mut self,
        picture: Rect,
        mut output: egui::FullOutput,
        now: Instant,
    ) -> Result<Duration> {
        let mut changes = TextureChanges(std::mem::take(&mut output.textures_delta));
        self.input
            .handle_platform_output(&self.window, std::mem::take(&mut output.platform_output));
        self.painter.upload(&self.gpu, &changes.0);
        let before = Instant::now();
        let is_settled = self.is_settled(&output);
        let canvas = match self.picture_request.take(now, is_settled) {
            true => self.surface.to_be_read(&self.gpu),
            false => self.surface.acquire(&self.gpu),
        };
        let mut waited = before.elapsed();
        match canvas {
            Ok(canvas) => {
                let scale = output.pixels_per_point;
                let triangles = self.context.tessellate(std::mem::take(&mut output.shapes), scale);
                let mut encoder = self.gpu.encoder();
                self.draw_fleet(&mut encoder, &canvas, picture, scale, now);
                let drawing = Drawing { triangles, pixels_per_point: scale, size: canvas.size };
                self.painter.draw(&self.gpu, &mut encoder, &canvas.interface, &drawing);
                let before = Instant::now();
                if let Some(picture) = canvas.finish(&self.gpu, encoder) {
                    self.write_picture(&picture, now);
                }
                waited += before.elapsed();
                if let Some(seconds) = self.stage.renderer.poll_gpu_seconds() {
                    self.timing.push_gpu(seconds as f32);
                }
            }
            Err(NoCanvas::Hidden) => {}
            Err(NoCanvas::Later) => self.frame_pacing.schedule(now + Duration::from_millis(5)),
            Err(NoCanvas::Lost) => self.recreate_surface()?,
        }
        self.painter.free(std::mem::take(&mut changes.0));
        Ok(waited)
    }

    /// Draws the picture of the fleet; of levels side by side, the pictures of all of them.
    fn draw_fleet(
        &mut self,
        encoder: &mut CommandEncoder,
        canvas: &Canvas,
        picture: Rect,
        scale: f32,
        now: Instant,
    ) {
        let (camera, alpha) = (self.interface.shown_camera(), self.stage.alpha(now));
        let (parts, shown) = (self.interface.parts(), self.stage.scene.level.clone());
        // A level that was clicked just now is the scene's from the next picture on.
        let (current, beside): (Vec<_>, Vec<_>) =
            parts.iter().partition(|(level, _)| Some(level) == shown.as_ref());
        let (at, size) =
            pixels(current.first().map_or(picture, |(_, part)| *part), scale, canvas.size);
        self.stage.draw_within(
            encoder,
            &canvas.fleet,
            Some((at, canvas.size)),
            &camera,
            size,
            alpha,
        );
        if beside.is_empty() {
            return;
        }
        let corners = beside.iter().map(|(_, part)| pixels(*part, scale, canvas.size).0);
        let places: Vec<_> = corners.map(|corner| corner.min(canvas.size - size)).collect();
        for ((level, _), view) in beside.iter().zip(self.insets.make_room(beside.len(), size)) {
            self.stage.draw_beside(encoder, view, level, &camera, size, alpha);
        }
        self.insets.copy(encoder, &canvas.fleet, &places);
    }

    /// Writes a picture of the window into the current folder, and shows its path.
    fn write_picture(&mut self, picture: &RgbaImage, now: Instant) {
        let path = PathBuf::from(self.file_name("png"));
        let text = match write_whole(picture, &path) {
            Ok(()) => format!("the picture is in {}", path.display()),
            Err(message) => message,
        };
        self.picture_message = Some(text.clone());
        self.interface.notify(text);
        // The screen hasn't got a picture this time.
        self.frame_pacing.schedule(now);
    }

    /// Whether scene and panels show the same, and go on to do so: nothing flies, no panel opens,
    /// and a followed robot is in the middle.
    fn is_settled(&self, output: &egui::FullOutput) -> bool {
        let delay =
            output.viewport_output.get(&ViewportId::ROOT).map(|viewport| viewport.repaint_delay);
        let camera = &self.interface.camera_controller;
        let followed = camera.followed().map(|(robot, _)| robot);
        let known = self.fleet_state.followed.map(|(robot, _)| robot);
        delay.is_none_or(|delay| !delay.is_zero())
            && !camera.is_flying()
            && (followed.is_none() || known == followed)
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

/// Writes a picture so that a program that waits for the file never sees a part of it.
fn write_whole(picture: &RgbaImage, path: &Path) -> Result<(), String> {
    let unfinished = path.with_extension("png.part");
    write_png(picture, &unfinished).map_err(|error| error.to_string())?;
    std::fs::rename(&unfinished, path)
        .map_err(|error| format!("can't write {}: {error}", path.display()))
}

/// Returns position and size of the picture on the canvas in pixels: at least one pixel, and within
/// the canvas.
fn pixels(picture: Rect, scale: f32, canvas: UVec2) -> (UVec2, UVec2) {
    let corner =
        |at: egui::Pos2| (Vec2::new(at.x, at.y) * scale).round().max(Vec2::ZERO).as_uvec2();
    let low = corner(picture.min).min(canvas - 1);
    let high = corner(picture.max).min(canvas).max(low + 1);
    (low, high - low)
}
