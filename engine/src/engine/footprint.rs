//! Footprints of robots that stand, and the distance between two of them.

use glam::DVec2;
use regatta_scenario::{RobotType, Shape};

/// A convex polygon, enlarged by a radius all around: a rectangle without one, or a point with that
/// of a circle.
#[derive(Clone, Debug)]
pub(super) struct Footprint {
    corners: Vec<DVec2>,
    radius: f64,
}

impl Footprint {
    /// Returns the footprint of a robot at a position. `heading` is a unit vector.
    pub fn new(robot_type: &RobotType, position: DVec2, heading: DVec2) -> Self {
        let (length, width) = (f64::from(robot_type.length), f64::from(robot_type.width));
        if robot_type.shape == Shape::Circle {
            return Self { corners: vec![position], radius: 0.5 * length };
        }
        let (along, across) = (0.5 * length * heading, 0.5 * width * heading.perp());
        let corners = [along + across, across - along, -along - across, along - across];
        Self { corners: corners.map(|corner| position + corner).into(), radius: 0.0 }
    }

    /// Returns the metres between two footprints; 0 or less if they touch.
    pub fn distance(&self, other: &Self) -> f64 {
        let apart = match self.is_apart(other) || other.is_apart(self) {
            true => self.corner_distance(other).min(other.corner_distance(self)),
            false => 0.0,
        };
        apart - self.radius - other.radius
    }

    /// Whether a line along one of this polygon's sides separates it from another.
    fn is_apart(&self, other: &Self) -> bool {
        if let ([a], [b]) = (&*self.corners, &*other.corners) {
            return a != b;
        }
        // The corners are counter-clockwise.
        self.sides().any(|[from, to]| {
            other.corners.iter().all(|corner| (to - from).perp_dot(corner - from) < 0.0)
        })
    }

    /// Returns the shortest distance from another polygon's corners to this one's sides.
    fn corner_distance(&self, other: &Self) -> f64 {
        let mut shortest = f64::INFINITY;
        for corner in &other.corners {
            for [from, to] in self.sides() {
                let side = to - from;
                let squared = side.length_squared().max(f64::MIN_POSITIVE);
                let part = ((corner - from).dot(side) / squared).clamp(0.0, 1.0);
                shortest = shortest.min(corner.distance(from + part * side));
            }
        }
        shortest
    }

    fn sides(&self) -> impl Iterator<Item = [DVec2; 2]> + '_ {
        let next = self.corners.iter().cycle().skip(1);
        self.corners.iter().zip(next).map(|(from, to)| [*from, *to])
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn robot_type(shape: Shape, length: f32, width: f32) -> RobotType {
        RobotType {
            name: "test".into(),
            shape,
            length,
            width,
            max_speed: 1.0,
            max_acceleration: 1.0,
            max_rotation_speed: 0.0,
            max_rotation_acceleration: 1.0,
            battery: None,
        }
    }

    fn footprint(shape: Shape, at: [f64; 2], angle: f64) -> Footprint {
        Footprint::new(&robot_type(shape, 2.0, 1.0), DVec2::from(at), DVec2::from_angle(angle))
    }

    #[test]
    fn distances_are_those_of_the_shapes() {
        let square = footprint(Shape::Rectangle, [0.0, 0.0], 0.0);
        for (shape, at, angle, distance) in [
            (Shape::Rectangle, [3.0, 0.0], 0.0, 1.0),
            (Shape::Rectangle, [0.0, 3.0], 0.0, 2.0),
            (Shape::Rectangle, [3.0, 0.0], std::f64::consts::FRAC_PI_2, 1.5),
            (Shape::Rectangle, [5.0, 5.0], 0.0, 5.0),
            (Shape::Circle, [3.0, 0.0], 0.0, 1.0),
            (Shape::Circle, [4.0, 4.5], 0.0, 4.0),
            (Shape::Rectangle, [0.1, 0.0], 0.7, 0.0),
        ] {
            let other = footprint(shape, at, angle);
            assert!((square.distance(&other) - distance).abs() < 1e-9, "{shape:?} {at:?}");
            assert!((other.distance(&square) - distance).abs() < 1e-9, "{shape:?} {at:?}");
        }
    }

    proptest! {
        /// Against the points of a fine grid of one footprint.
        #[test]
        fn the_distance_is_that_of_the_nearest_points(
            x in -4.0f64..4.0, y in -4.0f64..4.0, angle in -4.0f64..4.0,
        ) {
            let still = footprint(Shape::Rectangle, [0.0; 2], 0.0);
            let moved = footprint(Shape::Rectangle, [x, y], angle);
            let direction = DVec2::from_angle(angle);
            let mut nearest = f64::INFINITY;
            for i in -20..=20 {
                for j in -20..=20 {
                    let (along, across) = (f64::from(i) / 20.0, f64::from(j) / 40.0);
                    let point = DVec2::new(x, y) + along * direction + across * direction.perp();
                    let distance = (point.abs() - DVec2::new(1.0, 0.5)).max(DVec2::ZERO).length();
                    nearest = nearest.min(distance);
                }
            }
            let distance = still.distance(&moved);
            prop_assert!((distance - nearest).abs() < 0.05, "{distance} {nearest}");
        }
    }
}
