//! Robot types, and the battery of a type.

use serde::Deserialize;

/// A type of robot, with everything that its robots have in common.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotType {
    /// Name, for display.
    pub name: String,
    /// Footprint.
    pub shape: Shape,
    /// Metres along the heading; of a circle, its diameter.
    pub length: f32,
    /// Metres across it.
    pub width: f32,
    /// Metres per second, > 0; infinity if only edges limit the speed.
    pub max_speed: f32,
    /// Metres per second squared, > 0; infinity if the speed changes at once.
    pub max_acceleration: f32,
    /// Radians per second, ≥ 0; 0 if it can't turn on the spot.
    pub max_rotation_speed: f32,
    /// Radians per second squared, > 0; infinity if the rotation speed changes at once.
    pub max_rotation_acceleration: f32,
    /// `None` if it never needs charging.
    pub battery: Option<Battery>,
}

/// The footprint of a robot type.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Shape {
    /// A rectangle of `length` × `width`.
    #[default]
    Rectangle,
    /// A circle of diameter `length`.
    Circle,
}

/// The battery of a robot type.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Battery {
    /// Watt-hours, > 0.
    pub capacity: f32,
    /// Watts that a robot takes while it drives or turns, ≥ 0.
    pub drain_moving: f32,
    /// Watts that it takes while it stands, ≥ 0.
    pub drain_standing: f32,
    /// Watts by which its charge grows while it stands idle at a charger, ≥ 0.
    pub charge_rate: f32,
    /// Its charge at the start is between these, in per cent.
    pub charge: [f32; 2],
}
