//! The outlines of robots on the ground, and the clearance between two of them.

use glam::Vec2;
use regatta_plugin::world::{RobotTypeRecord, Shape};

/// The outline of a robot, or a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Footprint {
    /// A circle; a point if its radius is 0.
    Circle {
        /// Metres.
        centre: Vec2,
        /// Metres.
        radius: f32,
    },
    /// A rectangle, by its corners counter-clockwise.
    Rectangle([Vec2; 4]),
}

impl Footprint {
    /// Returns the outline of a robot at a place, with a heading in radians.
    pub fn of(robot_type: &RobotTypeRecord, place: Vec2, heading: f32) -> Self {
        if robot_type.shape() == Shape::Circle {
            return Self::Circle { centre: place, radius: robot_type.length / 2.0 };
        }
        let (ahead, aside) =
            (Vec2::from_angle(heading) * 0.5, Vec2::from_angle(heading).perp() * 0.5);
        let (ahead, aside) = (ahead * robot_type.length, aside * robot_type.width);
        Self::Rectangle(
            [-ahead - aside, ahead - aside, ahead + aside, aside - ahead]
                .map(|corner| place + corner),
        )
    }

    /// Returns the least distance to another outline, and the points where it is; 0 and the same
    /// point twice if they overlap.
    pub fn clearance(self, other: Self) -> (f32, [Vec2; 2]) {
        let ([a, b], [reach_a, reach_b]) =
            ([self.core(), other.core()], [self.radius(), other.radius()]);
        let (distance, [from, to]) = nearest(&a, &b);
        let rest = distance - reach_a - reach_b;
        if rest <= 0.0 {
            let middle = (from + to) / 2.0;
            return (0.0, [middle; 2]);
        }
        let way = (to - from).normalize_or_zero();
        (rest, [from + way * reach_a, to - way * reach_b])
    }

    fn radius(self) -> f32 {
        if let Self::Circle { radius, .. } = self { radius } else { 0.0 }
    }

    /// The outline without its radius: a point or corners.
    fn core(&self) -> Vec<Vec2> {
        match self {
            Self::Circle { centre, .. } => vec![*centre],
            Self::Rectangle(corners) => corners.to_vec(),
        }
    }
}

/// Returns the nearest points of two convex outlines and their distance; 0 if one contains a point
/// of the other, or they cross.
fn nearest(a: &[Vec2], b: &[Vec2]) -> (f32, [Vec2; 2]) {
    for (outline, points) in [(a, b), (b, a)] {
        if let Some(point) = points.iter().find(|point| contains(outline, **point)) {
            return (0.0, [*point; 2]);
        }
    }
    let mut best = (f32::INFINITY, [Vec2::ZERO; 2]);
    for (i, from) in a.iter().enumerate() {
        for (j, other) in b.iter().enumerate() {
            let sides = ([*from, a[(i + 1) % a.len()]], [*other, b[(j + 1) % b.len()]]);
            let found = nearest_of_sides(sides.0, sides.1);
            if found.0 < best.0 {
                best = found;
            }
        }
    }
    best
}

fn contains(outline: &[Vec2], point: Vec2) -> bool {
    outline.len() > 2
        && (0..outline.len())
            .all(|i| turn([outline[i], outline[(i + 1) % outline.len()]], point) >= 0.0)
}

/// Returns a positive number if a point is to the left of a side, and a negative one to its right.
fn turn([from, to]: [Vec2; 2], point: Vec2) -> f32 {
    (to - from).perp_dot(point - from)
}

fn nearest_of_sides(a: [Vec2; 2], b: [Vec2; 2]) -> (f32, [Vec2; 2]) {
    let crosses = turn(a, b[0]) * turn(a, b[1]) < 0.0 && turn(b, a[0]) * turn(b, a[1]) < 0.0;
    if crosses {
        let part = turn(b, a[0]) / (turn(b, a[0]) - turn(b, a[1]));
        return (0.0, [a[0].lerp(a[1], part); 2]);
    }
    let ends = [
        [a[0], on_side(b, a[0])],
        [a[1], on_side(b, a[1])],
        [on_side(a, b[0]), b[0]],
        [on_side(a, b[1]), b[1]],
    ];
    let found = ends.map(|[from, to]| (from.distance(to), [from, to]));
    found
        .into_iter()
        .reduce(|best, next| if next.0 < best.0 { next } else { best })
        .unwrap_or_default()
}

/// The point of a side that is nearest to a point.
fn on_side([from, to]: [Vec2; 2], point: Vec2) -> Vec2 {
    let way = to - from;
    let part = (point - from).dot(way) / way.length_squared().max(1e-12);
    from.lerp(to, part.clamp(0.0, 1.0))
}

#[cfg(test)]
mod tests {
    use core::f32::consts::FRAC_PI_4;

    use super::*;

    fn cart() -> RobotTypeRecord {
        RobotTypeRecord::new("cart", 1.0, 0.6)
    }

    fn puck() -> RobotTypeRecord {
        RobotTypeRecord { shape: Shape::Circle as u32, ..RobotTypeRecord::new("puck", 0.8, 0.8) }
    }

    fn clearance(a: Footprint, b: Footprint) -> f32 {
        let (there, back) = (a.clearance(b), b.clearance(a));
        assert!((there.0 - back.0).abs() < 1e-5, "{there:?} {back:?}");
        assert!((there.1[0].distance(there.1[1]) - there.0).abs() < 1e-4, "{there:?}");
        there.0
    }

    #[test]
    fn clearance_is_between_the_outlines() {
        let origin = Footprint::of(&cart(), Vec2::ZERO, 0.0);
        for (other, wanted) in [
            (Footprint::of(&cart(), Vec2::new(3.0, 0.0), 0.0), 2.0),
            (Footprint::of(&cart(), Vec2::new(0.0, 2.0), 0.0), 1.4),
            (Footprint::of(&cart(), Vec2::new(4.0, 4.6), 0.0), 5.0),
            (Footprint::of(&puck(), Vec2::new(2.0, 0.0), 1.0), 1.1),
            (Footprint::of(&cart(), Vec2::new(2.0, 0.0), core::f32::consts::FRAC_PI_2), 1.2),
            (Footprint::Circle { centre: Vec2::new(-1.5, 0.0), radius: 0.0 }, 1.0),
            (Footprint::of(&cart(), Vec2::new(0.9, 0.0), 0.0), 0.0),
            (Footprint::of(&puck(), Vec2::new(0.1, 0.1), 0.0), 0.0),
        ] {
            assert!(
                (clearance(origin, other) - wanted).abs() < 1e-5,
                "{other:?}: {} {wanted}",
                clearance(origin, other)
            );
        }
    }

    #[test]
    fn crossing_outlines_without_a_corner_inside_have_no_clearance() {
        let long = RobotTypeRecord::new("long", 4.0, 0.4);
        let a = Footprint::of(&long, Vec2::ZERO, FRAC_PI_4);
        let b = Footprint::of(&long, Vec2::ZERO, -FRAC_PI_4);
        assert_eq!(clearance(a, b), 0.0);
    }
}
