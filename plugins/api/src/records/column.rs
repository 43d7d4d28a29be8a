//! Columns: one value per robot, published by a plugin on `regatta/F/columns/NAME`.

use bytemuck::{Pod, Zeroable};
#[cfg(feature = "shared-memory")]
use iceoryx2::prelude::ZeroCopySend;

use super::activity::Activity;
use super::contact::ContactLevel;
use super::sequence::Sequenced;

/// The iceoryx2 user header of a column. Its payload is `robots` values of `f32`, padded to whole
/// lines.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[cfg_attr(feature = "shared-memory", derive(ZeroCopySend))]
#[repr(C)]
#[cfg_attr(feature = "shared-memory", type_name("regatta_ColumnHeader"))]
pub struct ColumnHeader {
    /// The run of the frame that the values were computed from.
    pub run_id: u64,
    /// The tick of the frame that the values were computed from.
    pub tick: u64,
    /// Counts the samples of the run, from 1. The publisher fills it in.
    pub sequence: u64,
    /// Number of values.
    pub robots: u32,
    /// Microseconds that the publisher spent on the frame before it published this; 0 if it doesn't
    /// say.
    pub cost_micros: u32,
}

/// A column of the contract: its name, and the type of its elements.
///
/// ```
/// use regatta_plugin::activity::Activity;
/// use regatta_plugin::column::{ACTIVITY, GOAL};
///
/// assert_eq!(ACTIVITY.name(), "activity");
/// assert_eq!(ACTIVITY.element(2.0), Some(Activity::Carrying));
/// assert_eq!((GOAL.element(446.0), GOAL.element(f32::NAN)), (Some(446), None));
/// ```
#[derive(Clone, Copy, Debug)]
pub struct ColumnOf<T> {
    name: &'static str,
    element: fn(f32) -> Option<T>,
}

/// The type of each robot, as an index into the world's robot types. The producer publishes it.
pub const TYPE: ColumnOf<u32> = ColumnOf { name: "type", element: index };
/// The charge of each robot's battery in per cent. The producer publishes it if robots have
/// batteries.
pub const BATTERY: ColumnOf<f32> = ColumnOf { name: "battery", element: number };
/// The activity of each robot. A fleet manager publishes it.
pub const ACTIVITY: ColumnOf<Activity> =
    ColumnOf { name: "activity", element: Activity::from_value };
/// The robot that each robot waits for, by id. A fleet manager publishes it.
pub const WAITS_FOR: ColumnOf<u32> = ColumnOf { name: "waits-for", element: index };
/// The node to which each robot was sent, by id. A fleet manager publishes it.
pub const GOAL: ColumnOf<u32> = ColumnOf { name: "goal", element: index };
/// The level of each robot's worst contact; none if it is clear. A collision checker publishes it.
pub const COLLISION: ColumnOf<ContactLevel> = ColumnOf { name: "collision", element: level };

impl<T> ColumnOf<T> {
    /// The name, as in `regatta/F/columns/NAME`.
    pub const fn name(self) -> &'static str {
        self.name
    }

    /// Returns the element of a value; `None` if the robot has none.
    pub fn element(self, value: f32) -> Option<T> {
        (self.element)(value)
    }
}

fn number(value: f32) -> Option<f32> {
    (!value.is_nan()).then_some(value)
}

fn index(value: f32) -> Option<u32> {
    (value >= 0.0).then_some(value as u32)
}

fn level(value: f32) -> Option<ContactLevel> {
    index(value).and_then(ContactLevel::from_number)
}

super::sequence::sequenced!(ColumnHeader: sequence);
