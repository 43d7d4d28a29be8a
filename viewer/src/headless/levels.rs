//! All levels of a plant in one picture, side by side.

use std::time::Instant;

use glam::UVec2;
use image::{Rgba, RgbaImage, imageops};
use regatta_base::parts::columns;
use regatta_gpu::TargetConfig;
use regatta_interface::labels::{Labels, levels};
use regatta_interface::legend;
use regatta_plugin::{Error, Result};
use regatta_scene::camera::Camera;

use super::{HeadlessViewer, legend_width};
use crate::caption::{Annotations, Caption};
use crate::feed::News;
use crate::picture::{FORMAT, Offscreen};

/// A part of a picture.
pub(super) struct Part {
    /// The level that it shows.
    pub level: String,
    /// Whether it has coordinates, a scale and the direction to the north, in a plan.
    pub has_scale: bool,
}

impl HeadlessViewer<'_> {
    /// Draws each level into a part of the picture, from the upper left corner on, in the order of
    /// their names. All have the same camera, so that places above each other are at the same
    /// position of each part. The legend is to the left of them, or left out if there is no room.
    pub(super) fn render_levels(&mut self, samples: u32) -> Result<RgbaImage> {
        let names = self.stage.feed.world().map(|world| levels(&world)).unwrap_or_default();
        if names.len() < 2 {
            return Err(Error::new(
                "this world has no two levels to show side by side; leave --levels out",
            ));
        }
        let (size, parts, bounds) =
            (self.options.picture_size(), names.len() as u32, self.stage.bounds());
        let room = if self.no_legend { 0 } else { legend_width(size) };
        if room == 0 && !self.no_legend {
            self.leave_out(&[legend::LEGEND]);
        }
        let rest = UVec2::new(size.x - room, size.y);
        let columns = columns(parts, rest.as_vec2(), bounds.high - bounds.low);
        let part = rest / UVec2::new(columns, parts.div_ceil(columns));
        let target = TargetConfig::new(&self.gpu, FORMAT, samples);
        self.offscreen = Offscreen::new(&self.gpu, part, target)?;
        let [_, r, g, b] = self.stage.scene.theme.colours().sky.0.to_be_bytes();
        let mut picture = RgbaImage::from_pixel(size.x, size.y, Rgba([r, g, b, 255]));
        for (number, name) in (0..).zip(names) {
            self.show_level(&name)?;
            self.part = Some(Part { level: name, has_scale: number == 0 });
            let drawn = self.render(1.0)?;
            let at = part * UVec2::new(number % columns, number / columns) + UVec2::new(room, 0);
            imageops::replace(&mut picture, &drawn, at.x.into(), at.y.into());
        }
        if room > 0 {
            let density = self.stage.shown_density(&self.camera(), part);
            self.offscreen = Offscreen::new(&self.gpu, UVec2::new(room, size.y), target)?;
            let (legend, left_out) = self.render_legend(density)?;
            if self.leave_out(&left_out) {
                return self.render_levels(samples);
            }
            imageops::replace(&mut picture, &legend, 0, 0);
        }
        Ok(picture)
    }

    fn show_level(&mut self, name: &str) -> Result {
        self.stage.scene.level = Some(name.to_owned());
        self.stage.apply(News::default(), Instant::now())?;
        // Another name has another width, so the previous layout is dropped.
        self.caption = Caption::new(&self.gpu);
        if let Some(world) = self.stage.feed.world() {
            self.caption.labels = Labels::new(&world, Some(name));
        }
        Ok(())
    }

    /// Draws the legend alone. `density` is as in [`Annotations`]. Also returns the parts for which
    /// there is no room.
    fn render_legend(&mut self, density: Option<f32>) -> Result<(RgbaImage, Vec<&'static str>)> {
        let mut encoder = self.gpu.encoder();
        let (legend, scene) = (self.stage.legend(), &self.stage.scene);
        self.offscreen.fill(&mut encoder, scene.theme.colours().sky);
        let (camera, title) = (Camera::default(), self.title());
        let legend = Some(&legend);
        let annotations = Annotations { legend, density, ..self.stage.annotations(&camera, title) };
        self.caption = Caption::new(&self.gpu);
        let target = (&self.offscreen.overlay, self.size());
        let left_out = self.caption.draw(&self.gpu, &mut encoder, target, &annotations);
        Ok((self.offscreen.read(encoder)?, left_out))
    }
}
