//! The pose of a robot as it is drawn, and the interpolation between two poses.

use std::f32::consts::PI;

use glam::Vec2;

/// The position and the heading of a robot as it is drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose {
    /// Metres east and north.
    pub place: Vec2,
    /// Radians counter-clockwise from east.
    pub theta: f32,
}

/// Interpolates linearly between two poses, `part` from 0 to 1; the heading turns the shorter way
/// round.
pub fn interpolate(from: Pose, to: Pose, part: f32) -> Pose {
    let place = from.place + (to.place - from.place) * part;
    Pose { place, theta: from.theta + shortest_turn(from.theta, to.theta) * part }
}

/// Returns the angle from one direction to another the shorter way round, in radians in (-π, π].
pub fn shortest_turn(from: f32, to: f32) -> f32 {
    PI - (PI - (to - from)).rem_euclid(2.0 * PI)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headings_turn_the_shorter_way_round() {
        let pose = |theta| Pose { place: Vec2::ZERO, theta };
        let halfway = interpolate(pose(3.0), pose(-3.0), 0.5).theta;
        assert!((halfway - PI).abs() < 1e-5, "{halfway}");
    }
}
