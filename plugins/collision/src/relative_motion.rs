//! The straight motion of a robot relative to another, and whether they overlap on the way.

use glam::DVec2;

use crate::body::{corners, outside, seen_along};

/// The closest proximity of two robots within the horizon.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Proximity {
    /// They stay apart, even when both are inflated.
    Apart,
    /// They overlap only when both are inflated.
    Near,
    /// They overlap.
    Overlap,
}

impl Proximity {
    /// Classifies a pair, given whether its footprints overlap when both are inflated by so many
    /// metres.
    pub(crate) fn of(inflations: Inflations, overlap: impl Fn(f64) -> bool) -> Self {
        match (overlap(inflations.overlapping), overlap(inflations.near)) {
            (true, _) => Self::Overlap,
            (false, true) => Self::Near,
            (false, false) => Self::Apart,
        }
    }
}

/// The metres by which both footprints are inflated on all sides to test whether they overlap, and
/// whether they are near. A negative inflation makes them smaller.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Inflations {
    pub overlapping: f64,
    pub near: f64,
}

/// The straight motion of a robot relative to another; both keep their headings.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RelativeMotion {
    /// Position of the second robot relative to the first, in metres.
    pub offset: DVec2,
    /// Displacement of the second robot relative to the first over the whole time, in metres.
    pub displacement: DVec2,
}

impl RelativeMotion {
    pub(crate) fn seen_along(self, heading: DVec2) -> Self {
        Self {
            offset: seen_along(heading, self.offset),
            displacement: seen_along(heading, self.displacement),
        }
    }

    /// Tests by separating axes: two rectangles overlap at a time when their projections overlap on
    /// all four axes. Without branches, which would often be mispredicted.
    pub(crate) fn rectangles(
        self,
        (half_a, heading_a): (DVec2, DVec2),
        (half_b, heading_b): (DVec2, DVec2),
        inflations: Inflations,
    ) -> Proximity {
        let DVec2 { x: cos, y: sin } = seen_along(heading_a, heading_b).abs();
        let (from_a, from_b) = (self.seen_along(heading_a), self.seen_along(heading_b));
        let [small, large] = [inflations.overlapping, inflations.near]
            .map(|inflation| inflation * (1.0 + cos + sin));
        let crossings = [
            (from_a.crossing(0), half_a.x + half_b.x * cos + half_b.y * sin),
            (from_a.crossing(1), half_a.y + half_b.x * sin + half_b.y * cos),
            (from_b.crossing(0), half_b.x + half_a.x * cos + half_a.y * sin),
            (from_b.crossing(1), half_b.y + half_a.x * sin + half_a.y * cos),
        ];
        let (mut overlapping, mut near) = (Interval::ALL, Interval::ALL);
        for (crossing, reach) in &crossings {
            overlapping.clip(crossing, reach + small);
            near.clip(crossing, reach + large);
        }
        match (overlapping.is_some(), near.is_some()) {
            (true, _) => Proximity::Overlap,
            (false, true) => Proximity::Near,
            (false, false) => Proximity::Apart,
        }
    }

    /// Whether a circle hits a rectangle at the origin on its way, both inflated by some metres.
    /// Nothing is hit where a negative inflation leaves nothing of one of them.
    pub(crate) fn hits_rectangle(self, half: DVec2, radius: f64, inflation: f64) -> bool {
        let (half, radius) = (half + inflation, radius + inflation);
        if half.x.min(half.y).min(radius) < 0.0 {
            return false;
        }
        let mut interval = Interval::ALL;
        interval.clip(&self.crossing(0), half.x);
        interval.clip(&self.crossing(1), half.y);
        let end = self.offset + self.displacement;
        interval.is_some()
            || outside(half, self.offset) <= radius
            || outside(half, end) <= radius
            || corners(half).into_iter().any(|corner| self.distance(corner) <= radius)
    }

    /// Returns the shortest distance to a point, in metres.
    pub(crate) fn distance(self, point: DVec2) -> f64 {
        let offset = self.offset - point;
        let square = self.displacement.length_squared();
        let part = if square > 0.0 {
            (-offset.dot(self.displacement) / square).clamp(0.0, 1.0)
        } else {
            0.0
        };
        (offset + part * self.displacement).length()
    }

    /// Returns the motion along one axis.
    fn crossing(self, axis: usize) -> Crossing {
        // A displacement of 0 would make the time infinite, and the interval NaN.
        let displacement = self.displacement[axis];
        let per_metre = 1.0
            / if displacement.abs() < MIN_DISPLACEMENT { MIN_DISPLACEMENT } else { displacement };
        Crossing { middle: -self.offset[axis] * per_metre, per_metre: per_metre.abs() }
    }
}

/// The motion along one axis.
struct Crossing {
    /// Time at which it crosses the origin, as a fraction of the whole time.
    middle: f64,
    /// Time per metre, as a fraction of the whole time.
    per_metre: f64,
}

/// The least displacement that counts, in metres: far below any effect, but with a finite inverse.
const MIN_DISPLACEMENT: f64 = 1e-30;

/// An interval of time, as fractions of the whole time.
struct Interval(f64, f64);

impl Interval {
    const ALL: Self = Self(0.0, 1.0);

    /// Shrinks it to the time in which a crossing is within a distance from the origin.
    fn clip(&mut self, crossing: &Crossing, reach: f64) {
        let half = reach * crossing.per_metre;
        let (from, to) = (crossing.middle - half, crossing.middle + half);
        self.0 = if from > self.0 { from } else { self.0 };
        self.1 = if to < self.1 { to } else { self.1 };
    }

    fn is_some(&self) -> bool {
        self.0 <= self.1
    }
}
