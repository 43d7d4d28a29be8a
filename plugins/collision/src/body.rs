//! Poses with footprints, and the distance between two.

use crate::footprint::CIRCLE;

/// A robot's pose and footprint at one moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Body {
    /// Position east and north, in metres.
    pub position: [f32; 2],
    /// Unit vector along the heading.
    pub heading: [f32; 2],
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
            Outline::Rectangle([half_length, self.half_width.into()])
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
    pub(crate) fn half_extent(&self, [cos, sin]: [f32; 2]) -> [f32; 2] {
        let (length, width, cos, sin) = (self.half_length, self.half_width, cos.abs(), sin.abs());
        if self.is_circle() {
            [length; 2]
        } else {
            [length * cos + width * sin, length * sin + width * cos]
        }
    }
}

/// A footprint without its pose.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Outline {
    /// Half of the length and width, in metres.
    Rectangle([f64; 2]),
    /// Radius, in metres.
    Circle(f64),
}

pub(crate) type Vector = [f64; 2];

pub(crate) fn wide(vector: [f32; 2]) -> Vector {
    vector.map(f64::from)
}

pub(crate) fn between(from: [f32; 2], to: [f32; 2]) -> Vector {
    [f64::from(to[0]) - f64::from(from[0]), f64::from(to[1]) - f64::from(from[1])]
}

/// Rotates a vector into the frame whose first axis is `heading`.
pub(crate) fn seen_along([cos, sin]: Vector, [x, y]: Vector) -> Vector {
    [x * cos + y * sin, y * cos - x * sin]
}

/// Rotates a vector back from that frame: the inverse of [`seen_along`].
pub(crate) fn turned_by([cos, sin]: Vector, [x, y]: Vector) -> Vector {
    [x * cos - y * sin, x * sin + y * cos]
}

/// Returns the distance of a point from a rectangle at the origin, in metres; 0 inside.
pub(crate) fn outside(half: Vector, [x, y]: Vector) -> f64 {
    let [x, y] = [(x.abs() - half[0]).max(0.0), (y.abs() - half[1]).max(0.0)];
    (x * x + y * y).sqrt()
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
            rectangles((half_a, wide(a.heading)), (half_b, wide(b.heading)), offset, reach)
        }
        (Outline::Rectangle(half), Outline::Circle(radius)) => {
            (outside(half, seen_along(wide(a.heading), offset)) - radius).max(0.0)
        }
        (Outline::Circle(radius), Outline::Rectangle(half)) => {
            (outside(half, seen_along(wide(b.heading), offset)) - radius).max(0.0)
        }
        (Outline::Circle(radius_a), Outline::Circle(radius_b)) => {
            ((offset[0] * offset[0] + offset[1] * offset[1]).sqrt() - radius_a - radius_b).max(0.0)
        }
    }
}

fn rectangles(
    (half_a, heading_a): (Vector, Vector),
    (half_b, heading_b): (Vector, Vector),
    offset: Vector,
    reach: f64,
) -> f64 {
    let from_a = seen_along(heading_a, offset);
    let from_b = seen_along(heading_b, offset);
    let turn = seen_along(heading_a, heading_b);
    let [cos, sin] = turn.map(f64::abs);
    let separations = [
        from_a[0].abs() - (half_a[0] + half_b[0] * cos + half_b[1] * sin),
        from_a[1].abs() - (half_a[1] + half_b[0] * sin + half_b[1] * cos),
        from_b[0].abs() - (half_b[0] + half_a[0] * cos + half_a[1] * sin),
        from_b[1].abs() - (half_b[1] + half_a[0] * sin + half_a[1] * cos),
    ];
    let widest = separations.into_iter().fold(f64::NEG_INFINITY, f64::max);
    if widest <= 0.0 || widest > reach {
        return widest.max(0.0);
    }
    let corners_of_b = corners(half_b)
        .map(|corner| turned_by(turn, corner))
        .map(|[x, y]| [x + from_a[0], y + from_a[1]]);
    let back = [turn[0], -turn[1]];
    let corners_of_a = corners(half_a)
        .map(|corner| turned_by(back, corner))
        .map(|[x, y]| [x - from_b[0], y - from_b[1]]);
    let near_a = corners_of_b.into_iter().map(|corner| outside(half_a, corner));
    let near_b = corners_of_a.into_iter().map(|corner| outside(half_b, corner));
    near_a.chain(near_b).fold(f64::INFINITY, f64::min)
}

pub(crate) fn corners([length, width]: Vector) -> [Vector; 4] {
    [[length, width], [-length, width], [-length, -width], [length, -width]]
}

/// Returns approximately where two footprints that don't overlap come nearest: between their
/// positions, closer to the smaller robot in proportion to the sizes.
pub(crate) fn nearest_point(a: &Body, b: &Body) -> [f32; 2] {
    let size = |body: &Body| {
        body.half_length + if body.is_circle() { body.half_length } else { body.half_width }
    };
    let (size_a, size_b) = (size(a), size(b));
    let part = if size_a + size_b > 0.0 { size_a / (size_a + size_b) } else { 0.5 };
    let between = |axis: usize| a.position[axis] + part * (b.position[axis] - a.position[axis]);
    [between(0), between(1)]
}

/// Returns the relative speed of two robots, in metres per second, from their velocities.
pub(crate) fn relative_speed(a: [f32; 2], b: [f32; 2]) -> f32 {
    let [x, y] = [b[0] - a[0], b[1] - a[1]];
    (x * x + y * y).sqrt()
}

#[cfg(test)]
mod tests;
