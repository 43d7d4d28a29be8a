//! What a robot covers of the floor, by its type.

use regatta_plugin::world::{RobotTypeRecord, Shape};

/// Largest side or diameter, in metres. A type that claims more is a mistake.
pub const MAX_SIZE: f32 = 1000.0;

/// A robot's footprint about its pose, in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Footprint {
    /// Half of its length, along the heading, and half of its width.
    Rectangle(f32, f32),
    /// Its radius.
    Circle(f32),
}

/// For a world without robot types: what scenarios without robot types have.
pub(crate) const UNKNOWN: Footprint = Footprint::Rectangle(0.45, 0.3);

impl Footprint {
    /// `None` unless the sizes are numbers from 0 to [`MAX_SIZE`].
    pub(crate) fn of(record: &RobotTypeRecord) -> Option<Self> {
        let sane = |size: f32| (0.0..=MAX_SIZE).contains(&size).then_some(0.5 * size);
        match record.shape() {
            Shape::Rectangle => Some(Self::Rectangle(sane(record.length)?, sane(record.width)?)),
            Shape::Circle => Some(Self::Circle(sane(record.length)?)),
        }
    }
}
