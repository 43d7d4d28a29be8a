//! Stretches of edges.

/// A stretch of an edge, in metres from one of the edge's ends.
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

    /// The span as seen from the other end of an edge of some length in metres.
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
