//! Whether two predicted robots come to overlap.

use crate::body::{Outline, Vector, between, corners, outside, seen_along, wide};
use crate::prediction::Piece;

/// A robot's way through the horizon.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Way<'pieces> {
    pub outline: Outline,
    pub pieces: &'pieces [Piece],
}

/// Whether two robots, each grown by some metres on all sides, have a point in common at any time within the horizon.
/// Exact for these pieces: no instants are sampled.
pub(crate) fn meet(a: Way, b: Way, grown: f64) -> bool {
    let (outline_a, outline_b) = (a.outline.grown(grown), b.outline.grown(grown));
    let (mut rest_a, mut rest_b) = (a.pieces.iter(), b.pieces.iter());
    let (mut next_a, mut next_b) = (rest_a.next(), rest_b.next());
    let (mut start_a, mut start_b, mut now) = (0.0, 0.0, 0.0);
    while let (Some(piece_a), Some(piece_b)) = (next_a, next_b) {
        let until = f64::from(piece_a.until.min(piece_b.until));
        let offset = between(piece_a.place, piece_b.place);
        let (gone_a, gone_b) = (now - start_a, now - start_b);
        let velocity = between(piece_a.velocity, piece_b.velocity);
        let here = |axis: usize| {
            offset[axis] + f64::from(piece_b.velocity[axis]) * gone_b - f64::from(piece_a.velocity[axis]) * gone_a
        };
        let pass = Pass { offset: [here(0), here(1)], motion: velocity.map(|speed| speed * (until - now)) };
        if pass.overlaps((outline_a, wide(piece_a.heading)), (outline_b, wide(piece_b.heading))) {
            return true;
        }
        now = until;
        if f64::from(piece_a.until) <= until {
            (next_a, start_a) = (rest_a.next(), until);
        }
        if f64::from(piece_b.until) <= until {
            (next_b, start_b) = (rest_b.next(), until);
        }
    }
    false
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
    fn overlaps(self, (a, heading_a): (Outline, Vector), (b, heading_b): (Outline, Vector)) -> bool {
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
