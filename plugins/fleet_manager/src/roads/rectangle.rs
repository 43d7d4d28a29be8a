//! Rectangles, and whether two of them touch.

/// A rectangle in the plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rectangle {
    /// Metres east and north.
    pub centre: [f32; 2],
    /// Unit vector along its first side.
    pub heading: [f32; 2],
    /// Half of its sides along and across the heading, in metres.
    pub half: [f32; 2],
}

impl Rectangle {
    /// Radius of the circle around it, in metres.
    pub fn radius(&self) -> f32 {
        // Sizes are far from what overflows, and `hypot` takes several times as long.
        (self.half[0] * self.half[0] + self.half[1] * self.half[1]).sqrt()
    }

    /// Whether two rectangles have a point in common: the separating axis theorem.
    pub fn touches(&self, other: &Self) -> bool {
        let offset = [other.centre[0] - self.centre[0], other.centre[1] - self.centre[1]];
        let cos = dot(self.heading, other.heading).abs();
        let sin = cross(self.heading, other.heading).abs();
        let apart = |axis: [f32; 2], own: [f32; 2], others: [f32; 2]| {
            dot(axis, offset).abs() > own[0] + others[0] * cos + others[1] * sin
                || cross(axis, offset).abs() > own[1] + others[0] * sin + others[1] * cos
        };
        !(apart(self.heading, self.half, other.half) || apart(other.heading, other.half, self.half))
    }
}

fn dot(a: [f32; 2], b: [f32; 2]) -> f32 {
    a[0] * b[0] + a[1] * b[1]
}

fn cross(a: [f32; 2], b: [f32; 2]) -> f32 {
    a[0] * b[1] - a[1] * b[0]
}
