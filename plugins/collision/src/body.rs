//! Footprints, poses with footprints, and the distance between two.

use glam::{DVec2, Vec2};
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
        let (width, half_width) = match record.shape() {
            Shape::Rectangle => (record.width, 0.5 * record.width),
            Shape::Circle => (record.length, CIRCLE),
        };
        let is_valid = [record.length, width].iter().all(|size| (0.0..=MAX_SIZE).contains(size));
        Self { half_length: if is_valid { 0.5 * record.length } else { f32::NAN }, half_width }
    }

    pub(crate) fn is_valid(self) -> bool {
        !self.half_length.is_nan()
    }
}

/// A robot's pose and footprint at one moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Body {
    /// Position east and north, in metres.
    pub position: Vec2,
    /// Unit vector along the heading.
    pub heading: Vec2,
    /// Half of the length, or the radius.
    pub half_length: f32,
    /// Half of the width; [`CIRCLE`] for a circle.
    pub half_width: f32,
}

impl Body {
    pub(crate) fn is_circle(&self) -> bool {
        self.half_width == CIRCLE
    }

    /// Returns the footprint without its pose.
    pub(crate) fn outline(&self) -> Outline {
        let half_length = f64::from(self.half_length);
        if self.is_circle() {
            Outline::Circle(half_length)
        } else {
            Outline::Rectangle(DVec2::new(half_length, self.half_width.into()))
        }
    }

    /// Returns the radius of the smallest circle around the position that holds the footprint, in
    /// metres.
    pub(crate) fn radius(&self) -> f32 {
        let (length, width) = (self.half_length, self.half_width);
        if self.is_circle() { length } else { (length * length + width * width).sqrt() }
    }

    /// Returns half of the size, east and north, of the bounding box of the footprint at some
    /// heading, in metres.
    pub(crate) fn half_extent(&self, heading: Vec2) -> Vec2 {
        let (length, width) = (self.half_length, self.half_width);
        let Vec2 { x: cos, y: sin } = heading.abs();
        if self.is_circle() {
            Vec2::splat(length)
        } else {
            Vec2::new(length * cos + width * sin, length * sin + width * cos)
        }
    }
}

/// A footprint without its pose.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Outline {
    /// Half of the length and width, in metres.
    Rectangle(DVec2),
    /// Radius, in metres.
    Circle(f64),
}

/// Returns the vector from one point to another in double precision.
pub(crate) fn between(from: Vec2, to: Vec2) -> DVec2 {
    to.as_dvec2() - from.as_dvec2()
}

/// Rotates a vector into the frame whose first axis is `heading`: the inverse of `heading.rotate`.
pub(crate) fn seen_along(heading: DVec2, vector: DVec2) -> DVec2 {
    DVec2::new(heading.dot(vector), heading.perp_dot(vector))
}

/// Returns the distance of a point from a rectangle at the origin, in metres; 0 inside.
pub(crate) fn outside(half: DVec2, point: DVec2) -> f64 {
    (point.abs() - half).max(DVec2::ZERO).length()
}

/// Returns the distance between two footprints, in metres: 0 if they have a point in common. If it
/// exceeds `reach`, the result is only some number above `reach`.
///
/// Computed in `f64` from the `f32` of the frame: by separating axes and, for rectangles that are
/// close, by the distances of their corners.
pub(crate) fn gap(a: &Body, b: &Body, reach: f64) -> f64 {
    let offset = between(a.position, b.position);
    match (a.outline(), b.outline()) {
        (Outline::Rectangle(half_a), Outline::Rectangle(half_b)) => {
            let (heading_a, heading_b) = (a.heading.as_dvec2(), b.heading.as_dvec2());
            rectangles((half_a, heading_a), (half_b, heading_b), offset, reach)
        }
        (Outline::Rectangle(half), Outline::Circle(radius)) => {
            (outside(half, seen_along(a.heading.as_dvec2(), offset)) - radius).max(0.0)
        }
        (Outline::Circle(radius), Outline::Rectangle(half)) => {
            (outside(half, seen_along(b.heading.as_dvec2(), offset)) - radius).max(0.0)
        }
        (Outline::Circle(radius_a), Outline::Circle(radius_b)) => {
            (offset.length() - radius_a - radius_b).max(0.0)
        }
    }
}

fn rectangles(
    (half_a, heading_a): (DVec2, DVec2),
    (half_b, heading_b): (DVec2, DVec2),
    offset: DVec2,
    reach: f64,
) -> f64 {
    let from_a = seen_along(heading_a, offset);
    let from_b = seen_along(heading_b, offset);
    let turn = seen_along(heading_a, heading_b);
    let DVec2 { x: cos, y: sin } = turn.abs();
    let separations = [
        from_a.x.abs() - (half_a.x + half_b.x * cos + half_b.y * sin),
        from_a.y.abs() - (half_a.y + half_b.x * sin + half_b.y * cos),
        from_b.x.abs() - (half_b.x + half_a.x * cos + half_a.y * sin),
        from_b.y.abs() - (half_b.y + half_a.x * sin + half_a.y * cos),
    ];
    let widest = separations.into_iter().fold(f64::NEG_INFINITY, f64::max);
    if widest <= 0.0 || widest > reach {
        return widest.max(0.0);
    }
    let back = DVec2::new(turn.x, -turn.y);
    let near_a = corners(half_b).map(|corner| outside(half_a, turn.rotate(corner) + from_a));
    let near_b = corners(half_a).map(|corner| outside(half_b, back.rotate(corner) - from_b));
    near_a.into_iter().chain(near_b).fold(f64::INFINITY, f64::min)
}

pub(crate) fn corners(half: DVec2) -> [DVec2; 4] {
    let other = DVec2::new(-half.x, half.y);
    [half, other, -half, -other]
}

/// Returns approximately the point at which two footprints that don't overlap come nearest: between
/// their positions, closer to the smaller robot in proportion to the sizes.
pub(crate) fn nearest_point(a: &Body, b: &Body) -> Vec2 {
    let [size_a, size_b] = [a, b].map(|body| {
        body.half_length + if body.is_circle() { body.half_length } else { body.half_width }
    });
    let part = if size_a + size_b > 0.0 { size_a / (size_a + size_b) } else { 0.5 };
    a.position + part * (b.position - a.position)
}

#[cfg(test)]
mod tests;
