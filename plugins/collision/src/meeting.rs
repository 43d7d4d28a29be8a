//! Whether two predicted robots come to overlap.

use crate::body::{Body, Outline, Vector, between, corners, outside, seen_along, wide};
use crate::prediction::Piece;

/// How near two robots come within the horizon.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Meeting {
    /// They stay apart, even when grown.
    None,
    /// They overlap when both are grown.
    Near,
    /// They overlap.
    Overlap,
}

impl Meeting {
    /// By whether two overlap when both are grown by some metres.
    fn of(grown: f64, overlap: impl Fn(f64) -> bool) -> Self {
        match (overlap(0.0), overlap(grown)) {
            (true, _) => Self::Overlap,
            (false, true) => Self::Near,
            (false, false) => Self::None,
        }
    }
}

/// For [`meet`]: the whole of their ways.
pub(crate) const ALWAYS: [f32; 2] = [0.0, f32::INFINITY];

/// How near two robots come on their ways, as they are and with both grown by some metres on all sides. Exact for these
/// pieces: no instants are sampled. Only looks at the pieces that they drive between these seconds from now.
pub(crate) fn meet(
    (a, pieces_a): (&Body, &[Piece]),
    (b, pieces_b): (&Body, &[Piece]),
    [from, to]: [f32; 2],
    grown: f64,
) -> Meeting {
    let reach = a.radius() + b.radius() + 2.0 * grown as f32;
    let (mut way_a, mut way_b) = (Way { pieces: pieces_a, start: 0.0 }, Way { pieces: pieces_b, start: 0.0 });
    let (mut now, mut meeting) = (0.0, Meeting::None);
    while let ([piece_a, ..], [piece_b, ..]) = (way_a.pieces, way_b.pieces)
        && now <= to
    {
        let until = piece_a.until.min(piece_b.until);
        if until >= from {
            let pass = Pass { a: (piece_a, now - way_a.start), b: (piece_b, now - way_b.start), seconds: until - now };
            meeting = meeting.max(pass.meeting((a, b), grown, reach));
            if meeting == Meeting::Overlap {
                return meeting;
            }
        }
        way_a.go_on(until);
        way_b.go_on(until);
        now = until;
    }
    meeting
}

/// What is left of a robot's way, and when its first piece started.
struct Way<'pieces> {
    pieces: &'pieces [Piece],
    start: f32,
}

impl Way<'_> {
    fn go_on(&mut self, now: f32) {
        if let [piece, rest @ ..] = self.pieces
            && piece.until <= now
        {
            (self.pieces, self.start) = (rest, now);
        }
    }
}

/// Two robots for some seconds, in which both drive straight on.
struct Pass<'pieces> {
    /// The pieces, and how long ago they began.
    a: (&'pieces Piece, f32),
    b: (&'pieces Piece, f32),
    seconds: f32,
}

impl Pass<'_> {
    fn meeting(&self, (a, b): (&Body, &Body), grown: f64, reach: f32) -> Meeting {
        // Both axes, as a guess at the first would often be wrong.
        if self.is_far(0, reach) | self.is_far(1, reach) {
            return Meeting::None;
        }
        let motion = self.motion();
        let (heading_a, heading_b) = (wide(self.a.0.heading), wide(self.b.0.heading));
        match (a.outline(), b.outline()) {
            (Outline::Rectangle(half_a), Outline::Rectangle(half_b)) => {
                motion.rectangles((half_a, heading_a), (half_b, heading_b), grown)
            }
            (Outline::Rectangle(half), Outline::Circle(radius)) => {
                Meeting::of(grown, |more| motion.seen_along(heading_a).passes_rectangle(half, radius, more))
            }
            (Outline::Circle(radius), Outline::Rectangle(half)) => {
                Meeting::of(grown, |more| motion.seen_along(heading_b).passes_rectangle(half, radius, more))
            }
            (Outline::Circle(a), Outline::Circle(b)) => {
                let distance = motion.distance([0.0; 2]);
                Meeting::of(grown, |more| distance <= a + b + 2.0 * more)
            }
        }
    }

    /// A cheap no for most: whether they stay farther apart than that, along an axis. In single precision, but with
    /// room for what that loses.
    fn is_far(&self, axis: usize, reach: f32) -> bool {
        let ((a, gone_a), (b, gone_b)) = (self.a, self.b);
        let offset = b.place[axis] - a.place[axis] + b.velocity[axis] * gone_b - a.velocity[axis] * gone_a;
        let motion = (b.velocity[axis] - a.velocity[axis]) * self.seconds;
        let lost = 0.01 + 1e-6 * (a.place[axis].abs() + b.place[axis].abs());
        (offset + 0.5 * motion).abs() > reach + 0.5 * motion.abs() + lost
    }

    fn motion(&self) -> Motion {
        let ((a, gone_a), (b, gone_b)) = (self.a, self.b);
        let (offset, velocity) = (between(a.place, b.place), between(a.velocity, b.velocity));
        let gone = |piece: &Piece, axis: usize, gone: f32| f64::from(piece.velocity[axis]) * f64::from(gone);
        let here = |axis: usize| offset[axis] + gone(b, axis, gone_b) - gone(a, axis, gone_a);
        Motion { offset: [here(0), here(1)], way: velocity.map(|speed| speed * f64::from(self.seconds)) }
    }
}

/// One robot passing another in a straight line, both with constant headings.
#[derive(Clone, Copy, Debug)]
struct Motion {
    /// From the first to the second, in metres.
    offset: Vector,
    /// How far the second goes, seen from the first.
    way: Vector,
}

impl Motion {
    fn seen_along(self, heading: Vector) -> Self {
        Self { offset: seen_along(heading, self.offset), way: seen_along(heading, self.way) }
    }

    /// Separating axes: two rectangles overlap at a time when they overlap along all four. Without branches, as
    /// guesses would often be wrong.
    fn rectangles(
        self,
        (half_a, heading_a): (Vector, Vector),
        (half_b, heading_b): (Vector, Vector),
        grown: f64,
    ) -> Meeting {
        let [cos, sin] = seen_along(heading_a, heading_b).map(f64::abs);
        let (from_a, from_b) = (self.seen_along(heading_a), self.seen_along(heading_b));
        let more = grown * (1.0 + cos + sin);
        let (mut plain, mut wide) = (Span::ALL, Span::ALL);
        let mut clip = |pass: Self, axis: usize, reach: f64| {
            let crossing = Crossing::of(pass, axis);
            plain.clip(&crossing, reach);
            wide.clip(&crossing, reach + more);
        };
        clip(from_a, 0, half_a[0] + half_b[0] * cos + half_b[1] * sin);
        clip(from_a, 1, half_a[1] + half_b[0] * sin + half_b[1] * cos);
        clip(from_b, 0, half_b[0] + half_a[0] * cos + half_a[1] * sin);
        clip(from_b, 1, half_b[1] + half_a[0] * sin + half_a[1] * cos);
        match (plain.is_some(), wide.is_some()) {
            (true, _) => Meeting::Overlap,
            (false, true) => Meeting::Near,
            (false, false) => Meeting::None,
        }
    }

    /// Whether a circle passes a rectangle about the origin, both grown by some metres.
    fn passes_rectangle(self, half: Vector, radius: f64, grown: f64) -> bool {
        let (half, radius) = (half.map(|half| half + grown), radius + grown);
        let mut span = Span::ALL;
        span.clip(&Crossing::of(self, 0), half[0]);
        span.clip(&Crossing::of(self, 1), half[1]);
        let end = [self.offset[0] + self.way[0], self.offset[1] + self.way[1]];
        span.is_some()
            || outside(half, self.offset) <= radius
            || outside(half, end) <= radius
            || corners(half).into_iter().any(|corner| self.distance(corner) <= radius)
    }

    /// How near it passes a point.
    fn distance(self, point: Vector) -> f64 {
        let [x, y] = [self.offset[0] - point[0], self.offset[1] - point[1]];
        let [u, v] = self.way;
        let square = u * u + v * v;
        let part = if square > 0.0 { (-(x * u + y * v) / square).clamp(0.0, 1.0) } else { 0.0 };
        let [x, y] = [x + part * u, y + part * v];
        (x * x + y * y).sqrt()
    }
}

/// A motion along an axis.
struct Crossing {
    /// When it crosses the origin, in parts of the whole.
    middle: f64,
    /// How long it takes for a metre.
    per_metre: f64,
}

impl Crossing {
    fn of(motion: Motion, axis: usize) -> Self {
        // One that stands crosses in no time, but not in none.
        let way = motion.way[axis];
        let per_metre = 1.0 / if way.abs() < SLOWEST { SLOWEST } else { way };
        Self { middle: -motion.offset[axis] * per_metre, per_metre: per_metre.abs() }
    }
}

/// Least way of a robot, in metres: far less than counts, and its inverse is still a number.
const SLOWEST: f64 = 1e-30;

/// From when to when, in parts of the whole.
struct Span(f64, f64);

impl Span {
    const ALL: Self = Self(0.0, 1.0);

    /// Leaves of it when a crossing is within a distance from the origin.
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
