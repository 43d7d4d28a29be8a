//! Rectangles: of the ground, and of a picture.

use glam::Vec2;

/// An axis-aligned rectangle of the ground, in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// South-west corner.
    pub low: Vec2,
    /// North-east corner.
    pub high: Vec2,
}

impl Bounds {
    /// Returns the bounding box of some points, not counting points that are not finite; `None` if
    /// there are none.
    pub fn from_points(points: impl IntoIterator<Item = Vec2>) -> Option<Self> {
        let mut points = points.into_iter().filter(|point| point.is_finite());
        let first = points.next()?;
        let mut bounds = Self { low: first, high: first };
        for point in points {
            bounds = Self { low: bounds.low.min(point), high: bounds.high.max(point) };
        }
        Some(bounds)
    }

    /// Returns a rectangle around the origin with a width and height in metres.
    pub fn of_size(size: [f32; 2]) -> Self {
        let half = Vec2::from(size) / 2.0;
        Self { low: -half, high: half }
    }

    /// Whether another rectangle lies within this one.
    pub fn contains(self, other: Self) -> bool {
        self.low.cmple(other.low).all() && self.high.cmpge(other.high).all()
    }

    /// Returns the smallest rectangle that contains both.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    /// Returns a rectangle that is larger by a fifth of its size plus one metre on all sides.
    #[must_use]
    pub fn padded(self) -> Self {
        let padding = (self.high - self.low) * 0.2 + 1.0;
        Self { low: self.low - padding, high: self.high + padding }
    }

    /// The rectangle's centre.
    pub fn centre(self) -> Vec2 {
        (self.low + self.high) / 2.0
    }
}

/// The part of a picture that nothing covers, as fractions of its width and height from the top
/// left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// Width of the picture divided by its height.
    pub aspect: f32,
    /// The part's top left corner.
    pub low: Vec2,
    /// The part's bottom right corner.
    pub high: Vec2,
}

impl Window {
    /// Returns all of a picture.
    pub fn whole(aspect: f32) -> Self {
        Self { aspect, low: Vec2::ZERO, high: Vec2::ONE }
    }
}

impl Default for Bounds {
    /// A square of twenty metres around the origin, which an empty fleet is shown in.
    fn default() -> Self {
        Self { low: Vec2::splat(-10.0), high: Vec2::splat(10.0) }
    }
}
