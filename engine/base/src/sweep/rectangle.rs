//! Rectangles, and spans of curves.

use glam::Vec2;

/// A rectangle in the plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rectangle {
    /// Metres east and north.
    pub centre: Vec2,
    /// Unit vector along its first side.
    pub heading: Vec2,
    /// Half of its sides along and across the heading, in metres.
    pub half: Vec2,
}

impl Rectangle {
    /// Radius of the circle around it, in metres.
    pub fn radius(&self) -> f32 {
        // Sizes are far from what overflows, and `hypot` takes several times as long.
        self.half.length()
    }

    /// Whether two rectangles have a point in common: the separating axis theorem.
    pub fn touches(&self, other: &Self) -> bool {
        let offset = other.centre - self.centre;
        let cos = self.heading.dot(other.heading).abs();
        let sin = self.heading.perp_dot(other.heading).abs();
        !(self.is_apart(offset, cos, sin, other.half)
            || other.is_apart(offset, cos, sin, self.half))
    }

    /// Whether one of its own axes separates it from a rectangle whose centre is at an offset,
    /// given the absolute cosine and sine of the angle between both.
    fn is_apart(&self, offset: Vec2, cos: f32, sin: f32, other_half: Vec2) -> bool {
        self.heading.dot(offset).abs() > self.half.x + other_half.x * cos + other_half.y * sin
            || self.heading.perp_dot(offset).abs()
                > self.half.y + other_half.x * sin + other_half.y * cos
    }
}

/// A stretch of a curve, in metres from one of its ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    /// Its nearer end.
    pub low: f32,
    /// Its farther end.
    pub high: f32,
}

impl Span {
    /// The span of nothing.
    pub const EMPTY: Self = Self::new(f32::INFINITY, f32::NEG_INFINITY);

    /// Makes a span of its ends.
    pub const fn new(low: f32, high: f32) -> Self {
        Self { low, high }
    }

    /// Whether a place is within, ends included.
    pub fn contains(self, place: f32) -> bool {
        place >= self.low && place <= self.high
    }

    /// The span as seen from the other end of a curve of some length in metres.
    #[must_use]
    pub fn reversed(self, length: f32) -> Self {
        Self::new(length - self.high, length - self.low)
    }

    /// The smallest span that contains both.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        Self::new(self.low.min(other.low), self.high.max(other.high))
    }
}
