//! Whether two predicted robots come to overlap.

use crate::body::{Outline, Vector, between, corners, outside, seen_along, wide};
use crate::prediction::Piece;

/// A robot's way through the horizon.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Way<'pieces> {
    pub outline: Outline,
    pub pieces: &'pieces [Piece],
}

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

/// How near two robots come, as they are and with both grown by some metres on all sides. Exact for these pieces: no
/// instants are sampled.
pub(crate) fn meet(a: Way, b: Way, grown: f64) -> Meeting {
    let (wide_a, wide_b) = (a.outline.grown(grown), b.outline.grown(grown));
    let reach = wide_a.radius() + wide_b.radius();
    let (mut rest_a, mut rest_b) = (a.pieces.iter(), b.pieces.iter());
    let (mut next_a, mut next_b) = (rest_a.next(), rest_b.next());
    let (mut start_a, mut start_b, mut now) = (0.0, 0.0, 0.0);
    let mut meeting = Meeting::None;
    while let (Some(piece_a), Some(piece_b)) = (next_a, next_b) {
        let until = f64::from(piece_a.until.min(piece_b.until));
        let pass = Pass::of((piece_a, now - start_a), (piece_b, now - start_b), until - now);
        let headings = (piece_a.heading, piece_b.heading);
        if pass.comes_within(reach) && pass.overlaps((wide_a, headings.0), (wide_b, headings.1)) {
            if pass.overlaps((a.outline, headings.0), (b.outline, headings.1)) {
                return Meeting::Overlap;
            }
            meeting = Meeting::Near;
        }
        now = until;
        if f64::from(piece_a.until) <= until {
            (next_a, start_a) = (rest_a.next(), until);
        }
        if f64::from(piece_b.until) <= until {
            (next_b, start_b) = (rest_b.next(), until);
        }
    }
    meeting
}

/// One robot passing another in a straight line, both with constant headings.
#[derive(Clone, Copy, Debug)]
struct Pass {
    /// From the first to the second, in metres.
    offset: Vector,
    /// How far the second goes, seen from the first.
    motion: Vector,
}

impl Pass {
    /// Of two pieces that began some time ago, for some seconds from now.
    fn of((a, gone_a): (&Piece, f64), (b, gone_b): (&Piece, f64), seconds: f64) -> Self {
        let offset = between(a.place, b.place);
        let here =
            |axis: usize| offset[axis] + f64::from(b.velocity[axis]) * gone_b - f64::from(a.velocity[axis]) * gone_a;
        Self { offset: [here(0), here(1)], motion: between(a.velocity, b.velocity).map(|speed| speed * seconds) }
    }

    /// Whether it comes within that distance east or west and north or south, at some times: a cheap no.
    fn comes_within(self, reach: f64) -> bool {
        let far =
            |axis: usize| (2.0 * self.offset[axis] + self.motion[axis]).abs() > 2.0 * reach + self.motion[axis].abs();
        !far(0) && !far(1)
    }

    fn overlaps(self, (a, heading_a): (Outline, [f32; 2]), (b, heading_b): (Outline, [f32; 2])) -> bool {
        let (heading_a, heading_b) = (wide(heading_a), wide(heading_b));
        match (a, b) {
            (Outline::Rectangle(half_a), Outline::Rectangle(half_b)) => {
                let turn = seen_along(heading_a, heading_b).map(f64::abs);
                self.rectangles((half_a, heading_a), (half_b, heading_b), turn)
            }
            (Outline::Rectangle(half), Outline::Circle(radius)) => self.seen_along(heading_a).circle(half, radius),
            (Outline::Circle(radius), Outline::Rectangle(half)) => self.seen_along(heading_b).circle(half, radius),
            (Outline::Circle(a), Outline::Circle(b)) => self.distance([0.0; 2]) <= a + b,
        }
    }

    fn seen_along(self, heading: Vector) -> Self {
        Self { offset: seen_along(heading, self.offset), motion: seen_along(heading, self.motion) }
    }

    /// Separating axes: they overlap at a time when they overlap along all four.
    fn rectangles(
        self,
        (half_a, heading_a): (Vector, Vector),
        (half_b, heading_b): (Vector, Vector),
        [cos, sin]: Vector,
    ) -> bool {
        let mut span = (0.0, 1.0);
        let from_a = self.seen_along(heading_a);
        let mut clip =
            |pass: &Self, axis: usize, reach: f64| clip(pass.offset[axis], pass.motion[axis], reach, &mut span);
        clip(&from_a, 0, half_a[0] + half_b[0] * cos + half_b[1] * sin)
            && clip(&from_a, 1, half_a[1] + half_b[0] * sin + half_b[1] * cos)
            && {
                let from_b = self.seen_along(heading_b);
                clip(&from_b, 0, half_b[0] + half_a[0] * cos + half_a[1] * sin)
                    && clip(&from_b, 1, half_b[1] + half_a[0] * sin + half_a[1] * cos)
            }
    }

    /// Whether a circle passes a rectangle about the origin within its radius.
    fn circle(self, half: Vector, radius: f64) -> bool {
        let mut span = (0.0, 1.0);
        let enters = clip(self.offset[0], self.motion[0], half[0], &mut span)
            && clip(self.offset[1], self.motion[1], half[1], &mut span);
        let end = [self.offset[0] + self.motion[0], self.offset[1] + self.motion[1]];
        enters
            || outside(half, self.offset) <= radius
            || outside(half, end) <= radius
            || corners(half).into_iter().any(|corner| self.distance(corner) <= radius)
    }

    /// How near it passes a point.
    fn distance(self, point: Vector) -> f64 {
        let [x, y] = [self.offset[0] - point[0], self.offset[1] - point[1]];
        let [u, v] = self.motion;
        let square = u * u + v * v;
        let part = if square > 0.0 { (-(x * u + y * v) / square).clamp(0.0, 1.0) } else { 0.0 };
        let [x, y] = [x + part * u, y + part * v];
        (x * x + y * y).sqrt()
    }
}

/// Cuts a span of time to when `|offset + time · motion| ≤ reach`; whether anything is left.
fn clip(offset: f64, motion: f64, reach: f64, span: &mut (f64, f64)) -> bool {
    if motion == 0.0 {
        return offset.abs() <= reach;
    }
    let (one, other) = ((-reach - offset) / motion, (reach - offset) / motion);
    *span = (span.0.max(one.min(other)), span.1.min(one.max(other)));
    span.0 <= span.1
}
