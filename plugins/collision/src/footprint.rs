//! What a robot covers of the floor, by its type.

use regatta_plugin::world::{RobotTypeRecord, Shape};

/// Largest side or diameter, in metres. A type that claims more is a mistake.
pub const MAX_SIZE: f32 = 1000.0;

/// A robot's footprint about its pose, in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Footprint {
    /// Half of its length, along the heading, or its radius; not a number if the type makes no sense.
    pub half_length: f32,
    /// Half of its width; [`CIRCLE`] for a circle.
    pub half_width: f32,
}

/// In place of a width.
pub(crate) const CIRCLE: f32 = -1.0;

impl Footprint {
    /// For a world without robot types: what scenarios without robot types have.
    pub(crate) const UNKNOWN: Self = Self { half_length: 0.45, half_width: 0.3 };

    /// Makes sense if the sizes are numbers from 0 to [`MAX_SIZE`].
    pub(crate) fn of(record: &RobotTypeRecord) -> Self {
        let is_sane = |size: f32| (0.0..=MAX_SIZE).contains(&size);
        let (half_width, is_sane) = match record.shape() {
            Shape::Rectangle => (0.5 * record.width, is_sane(record.length) && is_sane(record.width)),
            Shape::Circle => (CIRCLE, is_sane(record.length)),
        };
        Self { half_length: if is_sane { 0.5 * record.length } else { f32::NAN }, half_width }
    }

    /// Whether its type makes sense.
    pub(crate) fn is_sane(self) -> bool {
        !self.half_length.is_nan()
    }
}
