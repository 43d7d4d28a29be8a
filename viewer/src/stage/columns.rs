//! The values that robots are coloured by, their range, and the bounds of robots without a graph.

use glam::Vec2;
use regatta_plugin::{Frame, Result};
use regatta_scene::camera::Bounds;
use regatta_scene::palette::Colouring;

use super::Stage;
use super::further_levels::all;
use crate::feed::News;

/// The number of rows that are sampled to find the range of a column's values.
const SAMPLED_ROWS: usize = 1_024;
/// The number of frames between two samplings of the range.
const RANGE_EVERY: u64 = 16;
/// The number of frames between two updates of the robots' bounds, for a fleet without a graph.
const BOUNDS_EVERY: u64 = 64;

impl Stage {
    /// Sets the colouring of the scene. Returns whether other values are watched than before.
    ///
    /// # Errors
    /// If a column can't be opened.
    pub(super) fn update_colouring(&mut self) -> Result<bool> {
        let has_activities = self.feed.activity().is_some();
        let automatic = if has_activities { Colouring::activity() } else { Colouring::collision() };
        let wanted = self.colouring.clone().unwrap_or(automatic);
        let is_other = self.watched.as_ref() != Some(&wanted);
        if is_other {
            let column = if let Colouring::Column(name) = &wanted { Some(name) } else { None };
            self.feed.watch(column)?;
            self.watched = Some(wanted.clone());
            self.range = None;
            for renderer in self.renderers() {
                renderer.set_values(None);
            }
        }
        let is_fallback = self.colouring.is_none() && self.colouring_values().is_none();
        self.scene.colouring = if is_fallback { Colouring::State } else { wanted };
        Ok(is_other)
    }

    pub(super) fn update_columns(&mut self, news: News, is_recoloured: bool) {
        if (news.robot_type || news.frame)
            && let Some(robot_type) = self.feed.robot_type()
        {
            // A frame may have replaced the buffers, which are empty then.
            for renderer in all(&mut self.renderer, &mut self.further_levels) {
                if news.robot_type || renderer.lacks_robot_type_column() {
                    renderer.set_robot_type_column(robot_type);
                }
            }
        }
        let is_due =
            self.robot_bounds.is_none() || self.feed.counts().read.is_multiple_of(BOUNDS_EVERY);
        if news.frame && self.graph_bounds.is_none() && is_due {
            self.update_robot_bounds();
        }
        let frame = self.feed.frame();
        let values = match &self.scene.colouring {
            Colouring::Speed if news.frame || is_recoloured => {
                Some(frame.map(|frame| frame.speed()))
            }
            // A frame may have replaced the buffers, which are empty then.
            Colouring::Column(_)
                if news.value || is_recoloured || (news.frame && self.renderer.lacks_values()) =>
            {
                Some(self.feed.value())
            }
            _ => None,
        };
        let past = self.looking_back.zip(self.history.as_ref());
        let values = match (past, values) {
            (Some(((_, time), history)), Some(_)) => match &self.scene.colouring {
                Colouring::Speed => Some(history.at(time).map(|frame| frame.speed())),
                colouring if *colouring == Colouring::activity() => {
                    Some(history.activities_at(time))
                }
                _ => None,
            },
            (_, values) => values,
        };
        if let Some(values) = values {
            let is_due =
                self.range.is_none() || self.feed.counts().read.is_multiple_of(RANGE_EVERY);
            if let Some(values) = values.filter(|_| is_due) {
                self.range = widened(self.range, values);
            }
            for renderer in all(&mut self.renderer, &mut self.further_levels) {
                renderer.set_values(values);
            }
        }
    }

    /// Grows the robots' bounds. They never shrink during a run, and grow in large steps, so that
    /// the view seldom moves.
    fn update_robot_bounds(&mut self) {
        let Some(frame) = self.feed.frame() else { return };
        let run = frame.run_id();
        let old = self.robot_bounds.filter(|_| self.robot_bounds_run == run);
        let bounds = match (old, bounds_of_robots(&frame)) {
            (Some(old), Some(new)) if old.contains(new) => Some(old),
            (old, new) => new.map(|new| old.map_or(new, |old| old.union(new)).padded()),
        };
        (self.robot_bounds_run, self.robot_bounds) = (run, bounds);
        if let Some(bounds) = bounds {
            let ground = (bounds.high - bounds.low).element_product();
            for renderer in self.renderers() {
                renderer.set_ground(ground);
            }
        }
    }
}

fn bounds_of_robots(frame: &Frame<'_>) -> Option<Bounds> {
    Bounds::from_points(frame.x().iter().zip(frame.y()).map(|(x, y)| Vec2::new(*x, *y)))
}

/// Extends a range by a sample of the values, rounded outwards so that it seldom changes.
fn widened(range: Option<(f32, f32)>, values: &[f32]) -> Option<(f32, f32)> {
    let step = values.len().div_ceil(SAMPLED_ROWS).max(1);
    let finite = values.iter().step_by(step).copied().filter(|value| value.is_finite());
    let ends = range.into_iter().flat_map(|(low, high)| [low, high]);
    let (low, high) =
        ends.chain(finite).fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), value| {
            (low.min(value), high.max(value))
        });
    if low > high {
        return None;
    }
    let unit = 10_f32.powf((high - low).max(1e-3).log10().floor()) * 0.5;
    Some(((low / unit).floor() * unit, (high / unit).ceil() * unit))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_contain_their_values_and_are_rounded() {
        assert_eq!(widened(None, &[]), None);
        assert_eq!(widened(None, &[f32::NAN]), None);
        let range = widened(None, &[0.13, 1.37]).unwrap();
        assert!((range.0 - 0.0).abs() < 1e-6 && (range.1 - 1.5).abs() < 1e-6, "{range:?}");
        assert_eq!(widened(Some(range), &[1.0]), Some(range), "no value is outside the range");
    }
}
