//! All levels of a plant in one picture, side by side.

use std::time::Instant;

use glam::UVec2;
use image::{RgbaImage, imageops};
use regatta_plugin::{Error, Result};

use super::HeadlessViewer;
use crate::caption::Caption;
use crate::feed::News;
use crate::gpu::TargetConfig;
use crate::interface::labels::{Labels, levels};
use crate::interface::levels::columns;
use crate::picture::{FORMAT, Offscreen};

impl HeadlessViewer<'_> {
    /// Draws each level into a part of the picture, from the upper left corner on, in the order of their names. All have the same
    /// camera, so that what is above each other is at the same place of each part.
    pub(super) fn render_levels(&mut self, samples: u32) -> Result<RgbaImage> {
        let names = self.stage.feed.world().map(|world| levels(&world)).unwrap_or_default();
        if names.len() < 2 {
            return Err(Error::new("this world has no two levels to show side by side; leave --levels out"));
        }
        let (size, parts, bounds) = (self.size(), names.len() as u32, self.stage.bounds());
        let columns = columns(parts, size.as_vec2(), bounds.high - bounds.low);
        let part = size / UVec2::new(columns, parts.div_ceil(columns));
        self.offscreen = Offscreen::new(&self.gpu, part, TargetConfig::new(&self.gpu, FORMAT, samples))?;
        let mut picture = RgbaImage::new(size.x, size.y);
        for (number, name) in (0..).zip(names) {
            self.show_level(number, &name)?;
            let drawn = self.render(1.0)?;
            let at = part * UVec2::new(number % columns, number / columns);
            imageops::replace(&mut picture, &drawn, at.x.into(), at.y.into());
        }
        // What is left over is like the floor of a part without anything.
        picture.pixels_mut().filter(|pixel| pixel.0[3] == 0).for_each(|pixel| pixel.0[3] = 255);
        Ok(picture)
    }

    fn show_level(&mut self, number: u32, name: &str) -> Result {
        self.stage.scene.level = Some(name.to_owned());
        self.stage.apply(News::default(), Instant::now())?;
        // Another name is as wide as it is: what was laid out before doesn't count.
        self.caption = Caption::new(&self.gpu);
        if let Some(world) = self.stage.feed.world() {
            self.caption.labels = Labels::new(&world, Some(name));
        }
        self.part = Some((number, name.to_owned()));
        Ok(())
    }
}
