//! The uniforms of a picture, and its variants of shaders.

use glam::Vec4;
use regatta_scene::Scene;

use super::{Picture, Renderer};
use crate::columns::RobotTypeUniform;
use crate::density::{CROWDED, FADE};
use crate::robots::{Dense, Variant};
use crate::view::ViewUniform;

/// The bit of `view.filtered` for pictures with a heat map, over which robots are dimmed.
const OVER_HEAT: u32 = 4;

impl Renderer {
    /// The density of half the strength, in robots per square metre: the mean over the ground.
    pub fn mean_density(&self) -> Option<f32> {
        self.ground.map(|ground| self.columns.robots() as f32 / ground.max(1.0))
    }

    /// Returns the density of half the strength, in robots per hectare, if robots around the
    /// camera's target are drawn as their density.
    pub fn shown_density(&self, picture: &Picture<'_>) -> Option<f32> {
        let camera = picture.camera;
        let pixels_per_metre = camera.pixels_per_radian(picture.size.y as f32) / camera.distance;
        let density = self.density(picture);
        // Nearer than that, marks are stronger than the field.
        let is_shown = picture.scene.layers.robots
            && density.w * pixels_per_metre < 0.5 * (FADE.start + FADE.end);
        (is_shown && density.z > 0.0).then_some(self.mean_density()? * 1e4)
    }

    pub(super) fn view_uniform(&self, picture: &Picture<'_>) -> ViewUniform {
        let mut view =
            ViewUniform::new(picture.camera, picture.scene, picture.legend, picture.size);
        view.robots = self.columns.robots();
        view.previous_robots = self.columns.previous_robots();
        view.alpha = picture.alpha;
        view.teleport_distance = self.columns.teleport_distance();
        view.density = self.density(picture);
        // A small fleet leaves room for larger marks.
        let pixels = picture.size.as_vec2().element_product();
        let room = (pixels / view.robots.max(1) as f32).sqrt() * 0.25;
        if !picture.camera.is_plan() {
            view.detail.z = room.clamp(view.detail.z, view.detail.z * 3.2);
        }
        view.heated = u32::from(picture.scene.heat.is_some());
        view.detail.w = self.columns.values() as f32;
        view.filtered = self.columns.filtered() | (view.heated * OVER_HEAT);
        view
    }

    /// Returns the variant of the sorting shader for a picture.
    pub(super) fn variant(&self, view: &ViewUniform, scene: &Scene) -> Variant {
        let mut sizes = self.robot_types.iter().map(|record| {
            let uniform = RobotTypeUniform::new(record);
            uniform.length.max(uniform.width)
        });
        let first = sizes.next().unwrap_or(RobotTypeUniform::default().length);
        let (smallest, largest) =
            sizes.fold((first, first), |(low, high), size| (low.min(size), high.max(size)));
        // The greatest and the least length of a robot in the picture. A body may lean into it
        // whose middle is outside.
        let (near, far) = view.ground_distances();
        let (pixels, least) = (1.1 * largest * view.eye.w / near, smallest * view.eye.w / far);
        let dense = match scene.layers.robots && view.density.z > 0.0 && least < view.density.y {
            false => Dense::None,
            true if pixels < view.density.x => Dense::All,
            true => Dense::Small,
        };
        let bodies = pixels >= view.detail.y.max(view.detail.z);
        Variant { splats: false, dense, source: view.source, filtered: view.filtered, bodies }
    }

    /// The ends of the fade in pixels, the reciprocal of the density of half the strength (0 if all
    /// robots are marked), and the length of robots in metres.
    fn density(&self, picture: &Picture<'_>) -> Vec4 {
        let lengths = self.robot_types.iter().map(|record| RobotTypeUniform::new(record).length);
        let length = lengths.reduce(f32::max).unwrap_or(RobotTypeUniform::default().length);
        let robots = self.columns.robots() as f32;
        let is_crowded = robots > picture.size.as_vec2().element_product() * CROWDED;
        let mean = self
            .mean_density()
            .filter(|mean| picture.scene.layers.density && is_crowded && *mean > 0.0);
        Vec4::new(FADE.start, FADE.end, mean.map_or(0.0, f32::recip), length)
    }
}
