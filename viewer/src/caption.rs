//! What is written over a picture without a window: the legend, and the ids of what is near.

use egui::{Context, FullOutput, RawInput, Rect, pos2, vec2};
use glam::{UVec2, Vec2};
use wgpu::{CommandEncoder, TextureView};

use crate::camera::Camera;
use crate::gpu::device::Gpu;
use crate::gpu::painter::{Drawing, Painter};
use crate::interface::labels::Labels;
use crate::interface::{overlay, style};
use crate::palette::Legend;
use crate::picture::OVERLAY_FORMAT;
use crate::scene::Scene;

/// Pictures up to this height have letters of the usual size; larger ones have larger letters.
const USUAL_HEIGHT: f32 = 1080.0;

/// Writes over pictures.
pub struct Caption {
    context: Context,
    painter: Painter,
    styled: bool,
    /// The ids of what there is.
    pub labels: Labels,
}

/// What is written over.
pub struct Shown<'a> {
    /// From where it is seen.
    pub camera: &'a Camera,
    /// What is seen.
    pub scene: &'a Scene,
    /// What the colours mean, if that is to be told.
    pub legend: Option<&'a Legend>,
    /// Robots to be named, and where they are.
    pub robots: Vec<(u32, Vec2)>,
}

impl Caption {
    /// For pictures that are read back.
    pub fn new(gpu: &Gpu) -> Self {
        Self {
            context: Context::default(),
            painter: Painter::new(gpu, OVERLAY_FORMAT),
            styled: false,
            labels: Labels::default(),
        }
    }

    /// Writes over what is drawn.
    pub fn draw(&mut self, gpu: &Gpu, encoder: &mut CommandEncoder, target: (&TextureView, UVec2), shown: &Shown<'_>) {
        let (view, size) = target;
        let pixels_per_point = (size.y as f32 / USUAL_HEIGHT).max(1.0);
        if !self.styled {
            self.styled = true;
            style::apply(&self.context, shown.scene.theme);
            // What is shown anew only finds its size at first, then its place.
            for _ in 0..2 {
                let output = self.write(size, pixels_per_point, shown);
                self.painter.upload(gpu, &output.textures_delta);
                self.painter.free(output.textures_delta);
            }
        }
        let mut output = self.write(size, pixels_per_point, shown);
        let changes = std::mem::take(&mut output.textures_delta);
        self.painter.upload(gpu, &changes);
        let triangles = self.context.tessellate(output.shapes, pixels_per_point);
        self.painter.draw(gpu, encoder, view, &Drawing { triangles, pixels_per_point, size });
        self.painter.free(changes);
    }

    fn write(&self, size: UVec2, scale: f32, shown: &Shown<'_>) -> FullOutput {
        let Shown { camera, scene, legend, robots } = shown;
        let picture = Rect::from_min_size(pos2(0.0, 0.0), vec2(size.x as f32, size.y as f32) / scale);
        let mut input = RawInput { screen_rect: Some(picture), ..RawInput::default() };
        input.viewports.entry(egui::ViewportId::ROOT).or_default().native_pixels_per_point = Some(scale);
        self.context.run_ui(input, |ui| {
            if scene.layers.ids {
                self.labels.draw(ui.ctx(), picture, camera, scene.offset, scene.theme);
            }
            Labels::draw_robots(ui.ctx(), picture, camera, scene.theme, robots.iter().copied());
            if let Some(legend) = legend {
                overlay::legend(ui.ctx(), picture, scene.theme, legend);
            }
        })
    }
}
