//! Continuous collision detection: whether the footprints of two predicted robots come to overlap.

use crate::body::{Body, Outline, Vector, between, corners, outside, seen_along, wide};
use crate::prediction::Segment;

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
    /// Classifies a pair, given whether its footprints overlap when both are inflated by some metres.
    fn of(inflation: f64, overlap: impl Fn(f64) -> bool) -> Self {
        match (overlap(0.0), overlap(inflation)) {
            (true, _) => Self::Overlap,
            (false, true) => Self::Near,
            (false, false) => Self::Apart,
        }
    }
}

/// The time window of [`closest_proximity`] that covers the whole trajectories, in seconds from now.
pub(crate) const ALWAYS: [f32; 2] = [0.0, f32::INFINITY];

/// Returns the closest proximity of two robots on their trajectories, as they are and with both inflated by some metres
/// on all sides. The result is exact for these segments, as no instants are sampled. Only segments within the time
/// window `[from, to]`, in seconds from now, are examined.
pub(crate) fn closest_proximity(
    (a, segments_a): (&Body, &[Segment]),
    (b, segments_b): (&Body, &[Segment]),
    [from, to]: [f32; 2],
    inflation: f64,
) -> Proximity {
    let reach = a.radius() + b.radius() + 2.0 * inflation as f32;
    let mut cursor_a = TrajectoryCursor { segments: segments_a, start: 0.0 };
    let mut cursor_b = TrajectoryCursor { segments: segments_b, start: 0.0 };
    let (mut now, mut proximity) = (0.0, Proximity::Apart);
    while let ([segment_a, ..], [segment_b, ..]) = (cursor_a.segments, cursor_b.segments)
        && now <= to
    {
        let until = segment_a.until.min(segment_b.until);
        if until >= from {
            let pass = Pass {
                a: (segment_a, now - cursor_a.start),
                b: (segment_b, now - cursor_b.start),
                seconds: until - now,
            };
            proximity = proximity.max(pass.proximity((a, b), inflation, reach));
            if proximity == Proximity::Overlap {
                return proximity;
            }
        }
        cursor_a.advance(until);
        cursor_b.advance(until);
        now = until;
    }
    proximity
}

/// The rest of a trajectory, and the time at which its first segment started, in seconds from now.
struct TrajectoryCursor<'segments> {
    segments: &'segments [Segment],
    start: f32,
}

impl TrajectoryCursor<'_> {
    fn advance(&mut self, now: f32) {
        if let [segment, rest @ ..] = self.segments
            && segment.until <= now
        {
            (self.segments, self.start) = (rest, now);
        }
    }
}

/// The part of two trajectories in which both robots drive straight and without turning.
struct Pass<'segments> {
    /// Segment of the first robot, and the seconds since it started.
    a: (&'segments Segment, f32),
    /// Segment of the second robot, likewise.
    b: (&'segments Segment, f32),
    /// Duration, in seconds.
    seconds: f32,
}

impl Pass<'_> {
    fn proximity(&self, (a, b): (&Body, &Body), inflation: f64, reach: f32) -> Proximity {
        // Both axes are tested, as a branch on the first would often be mispredicted.
        if self.is_far(0, reach) | self.is_far(1, reach) {
            return Proximity::Apart;
        }
        let motion = self.motion();
        let (heading_a, heading_b) = (wide(self.a.0.heading), wide(self.b.0.heading));
        match (a.outline(), b.outline()) {
            (Outline::Rectangle(half_a), Outline::Rectangle(half_b)) => {
                motion.rectangles((half_a, heading_a), (half_b, heading_b), inflation)
            }
            (Outline::Rectangle(half), Outline::Circle(radius)) => Proximity::of(inflation, |inflation| {
                motion.seen_along(heading_a).hits_rectangle(half, radius, inflation)
            }),
            (Outline::Circle(radius), Outline::Rectangle(half)) => Proximity::of(inflation, |inflation| {
                motion.seen_along(heading_b).hits_rectangle(half, radius, inflation)
            }),
            (Outline::Circle(a), Outline::Circle(b)) => {
                let distance = motion.distance([0.0; 2]);
                Proximity::of(inflation, |inflation| distance <= a + b + 2.0 * inflation)
            }
        }
    }

    /// Whether they stay farther apart than `reach` along an axis, which cheaply excludes most pairs. In single
    /// precision, with allowance for its rounding errors.
    fn is_far(&self, axis: usize, reach: f32) -> bool {
        let ((a, elapsed_a), (b, elapsed_b)) = (self.a, self.b);
        let offset = b.position[axis] - a.position[axis] + b.velocity[axis] * elapsed_b - a.velocity[axis] * elapsed_a;
        let motion = (b.velocity[axis] - a.velocity[axis]) * self.seconds;
        let rounding = 0.01 + 1e-6 * (a.position[axis].abs() + b.position[axis].abs());
        (offset + 0.5 * motion).abs() > reach + 0.5 * motion.abs() + rounding
    }

    fn motion(&self) -> RelativeMotion {
        let ((a, elapsed_a), (b, elapsed_b)) = (self.a, self.b);
        let (offset, velocity) = (between(a.position, b.position), between(a.velocity, b.velocity));
        let displacement =
            |segment: &Segment, axis: usize, elapsed: f32| f64::from(segment.velocity[axis]) * f64::from(elapsed);
        let here = |axis: usize| offset[axis] + displacement(b, axis, elapsed_b) - displacement(a, axis, elapsed_a);
        RelativeMotion {
            offset: [here(0), here(1)],
            displacement: velocity.map(|speed| speed * f64::from(self.seconds)),
        }
    }
}

/// The straight motion of a robot relative to another; both keep their headings.
#[derive(Clone, Copy, Debug)]
struct RelativeMotion {
    /// Position of the second robot relative to the first, in metres.
    offset: Vector,
    /// Displacement of the second robot relative to the first over the whole time, in metres.
    displacement: Vector,
}

impl RelativeMotion {
    fn seen_along(self, heading: Vector) -> Self {
        Self { offset: seen_along(heading, self.offset), displacement: seen_along(heading, self.displacement) }
    }

    /// Tests by separating axes: two rectangles overlap at a time when their projections overlap on all four axes.
    /// Without branches, which would often be mispredicted.
    fn rectangles(
        self,
        (half_a, heading_a): (Vector, Vector),
        (half_b, heading_b): (Vector, Vector),
        inflation: f64,
    ) -> Proximity {
        let [cos, sin] = seen_along(heading_a, heading_b).map(f64::abs);
        let (from_a, from_b) = (self.seen_along(heading_a), self.seen_along(heading_b));
        let inflation = inflation * (1.0 + cos + sin);
        let (mut plain, mut wide) = (Interval::ALL, Interval::ALL);
        let mut clip = |pass: Self, axis: usize, reach: f64| {
            let crossing = Crossing::of(pass, axis);
            plain.clip(&crossing, reach);
            wide.clip(&crossing, reach + inflation);
        };
        clip(from_a, 0, half_a[0] + half_b[0] * cos + half_b[1] * sin);
        clip(from_a, 1, half_a[1] + half_b[0] * sin + half_b[1] * cos);
        clip(from_b, 0, half_b[0] + half_a[0] * cos + half_a[1] * sin);
        clip(from_b, 1, half_b[1] + half_a[0] * sin + half_a[1] * cos);
        match (plain.is_some(), wide.is_some()) {
            (true, _) => Proximity::Overlap,
            (false, true) => Proximity::Near,
            (false, false) => Proximity::Apart,
        }
    }

    /// Whether a circle hits a rectangle at the origin on its way, both inflated by some metres.
    fn hits_rectangle(self, half: Vector, radius: f64, inflation: f64) -> bool {
        let (half, radius) = (half.map(|half| half + inflation), radius + inflation);
        let mut interval = Interval::ALL;
        interval.clip(&Crossing::of(self, 0), half[0]);
        interval.clip(&Crossing::of(self, 1), half[1]);
        let end = [self.offset[0] + self.displacement[0], self.offset[1] + self.displacement[1]];
        interval.is_some()
            || outside(half, self.offset) <= radius
            || outside(half, end) <= radius
            || corners(half).into_iter().any(|corner| self.distance(corner) <= radius)
    }

    /// Returns the shortest distance to a point, in metres.
    fn distance(self, point: Vector) -> f64 {
        let [x, y] = [self.offset[0] - point[0], self.offset[1] - point[1]];
        let [u, v] = self.displacement;
        let square = u * u + v * v;
        let part = if square > 0.0 { (-(x * u + y * v) / square).clamp(0.0, 1.0) } else { 0.0 };
        let [x, y] = [x + part * u, y + part * v];
        (x * x + y * y).sqrt()
    }
}

/// The motion along one axis.
struct Crossing {
    /// Time at which it crosses the origin, as a fraction of the whole time.
    middle: f64,
    /// Time per metre, as a fraction of the whole time.
    per_metre: f64,
}

impl Crossing {
    fn of(motion: RelativeMotion, axis: usize) -> Self {
        // A displacement of 0 would make the time infinite, and the interval NaN.
        let displacement = motion.displacement[axis];
        let per_metre = 1.0 / if displacement.abs() < MIN_DISPLACEMENT { MIN_DISPLACEMENT } else { displacement };
        Self { middle: -motion.offset[axis] * per_metre, per_metre: per_metre.abs() }
    }
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

#[cfg(test)]
mod tests;
