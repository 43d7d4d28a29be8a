//! Rectangles, and whether two of them touch.

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

    /// Whether one of its own axes separates it from a rectangle whose centre is at an offset, given
    /// the absolute cosine and sine of the angle between both.
    fn is_apart(&self, offset: Vec2, cos: f32, sin: f32, other_half: Vec2) -> bool {
        self.heading.dot(offset).abs() > self.half.x + other_half.x * cos + other_half.y * sin
            || self.heading.perp_dot(offset).abs()
                > self.half.y + other_half.x * sin + other_half.y * cos
    }
}
