//! The footprint of a robot, by its type.

use regatta_plugin::world::{RobotTypeRecord, Shape};

/// The largest side or diameter of a valid footprint, in metres.
pub const MAX_SIZE: f32 = 1000.0;

/// A footprint relative to the robot's pose, in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Footprint {
    /// Half of the length, along the heading, or the radius; NaN if the type is invalid.
    pub half_length: f32,
    /// Half of the width; [`CIRCLE`] for a circle.
    pub half_width: f32,
}

/// The value of [`Footprint::half_width`] that marks a circle.
pub(crate) const CIRCLE: f32 = -1.0;

impl Footprint {
    /// The footprint in a world without robot types: the one of scenarios that define none.
    pub(crate) const UNKNOWN: Self = Self { half_length: 0.45, half_width: 0.3 };

    /// Returns the footprint of a type. It is valid if the sizes are numbers from 0 to
    /// [`MAX_SIZE`].
    pub(crate) fn of(record: &RobotTypeRecord) -> Self {
        let is_valid = |size: f32| (0.0..=MAX_SIZE).contains(&size);
        let (half_width, is_valid) = match record.shape() {
            Shape::Rectangle => {
                (0.5 * record.width, is_valid(record.length) && is_valid(record.width))
            }
            Shape::Circle => (CIRCLE, is_valid(record.length)),
        };
        Self { half_length: if is_valid { 0.5 * record.length } else { f32::NAN }, half_width }
    }

    pub(crate) fn is_valid(self) -> bool {
        !self.half_length.is_nan()
    }
}
