//! A robot's way through the horizon in short, to see quickly who stays far from whom.

use crate::body::Body;
use crate::bounds::{Bounds, slack};
use crate::prediction::Piece;
use crate::settings::HYSTERESIS;

/// A robot's way through the horizon in short. Half a cache line.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Way {
    /// Around all that the robot may come to in any way that counts.
    pub bounds: Bounds,
    /// Mean velocity, in metres per second.
    pub drift: [f32; 2],
    /// Most metres that it strays from where it would be if it drove at that velocity all the time.
    pub stray: f32,
    /// Where its pieces start in the list that they are in. One that has only one needs none there.
    pub first_piece: u32,
}

impl Way {
    /// Of a robot that drives the pieces from the first one on. `now` is what it covers now, and what is beside it that
    /// counts.
    pub(crate) fn new(body: &Body, all_pieces: &[Piece], first_piece: usize, now: Bounds) -> Self {
        let (pieces, first_piece) = (&all_pieces[first_piece..], first_piece as u32);
        // One that only drives straight on keeps its heading.
        if let [only] = pieces {
            let swept = grown(around(only.place, only.end(0.0)), body.half_extent(body.heading));
            return Self { bounds: now.join(swept), drift: only.velocity, stray: 0.0, first_piece };
        }
        // One that doesn't may turn any side to the outside.
        let mut all = around(body.place, body.place);
        let (mut end, mut until) = (body.place, 0.0);
        for piece in pieces {
            end = piece.end(until);
            until = piece.until;
            all = all.join(around(end, end));
        }
        let drift = [0, 1].map(|axis| (end[axis] - body.place[axis]) / until);
        let mut square = 0.0_f32;
        for joint in pieces.windows(2) {
            let off = |axis: usize| joint[1].place[axis] - body.place[axis] - drift[axis] * joint[0].until;
            square = square.max(off(0) * off(0) + off(1) * off(1));
        }
        let bounds = now.join(grown(all, [body.radius(); 2]));
        Self { bounds, drift, stray: square.sqrt(), first_piece }
    }
}

fn around(a: [f32; 2], b: [f32; 2]) -> Bounds {
    Bounds::new([a[0].min(b[0]), a[1].min(b[1])], [a[0].max(b[0]), a[1].max(b[1])])
}

/// A way's bounds with the footprint around it, and room for the hysteresis and for what rounding hides.
fn grown(way: Bounds, half: [f32; 2]) -> Bounds {
    let pad = HYSTERESIS as f32 + slack(way.west()) + slack(way.east()) + slack(way.south()) + slack(way.north());
    let (x, y) = (half[0] + pad, half[1] + pad);
    Bounds::new([way.west() - x, way.south() - y], [way.east() + x, way.north() + y])
}

/// The piece of a robot that drives straight on.
pub(crate) fn straight_on(body: &Body, way: &Way, horizon: f32) -> Piece {
    Piece { until: horizon, place: body.place, velocity: way.drift, heading: body.heading }
}

/// Two robots, each taken for a circle that drives at its mean velocity and is large enough to hold the robot all the
/// time. In single precision, with room for what that loses. No branches: guesses would often be wrong.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Approach {
    /// From the first to the second, in metres and metres per second.
    offset: [f32; 2],
    velocity: [f32; 2],
    /// Radii of both footprints, in metres, and what rounding may hide.
    radii: f32,
    strays: f32,
}

impl Approach {
    pub(crate) fn of((a, way_a): (&Body, &Way), (b, way_b): (&Body, &Way)) -> Self {
        let beyond = |body: &Body| body.place[0].abs() + body.place[1].abs();
        Self {
            offset: [b.place[0] - a.place[0], b.place[1] - a.place[1]],
            velocity: [way_b.drift[0] - way_a.drift[0], way_b.drift[1] - way_a.drift[1]],
            radii: a.radius() + b.radius() + 0.01 + 1e-6 * (beyond(a) + beyond(b)),
            strays: way_a.stray + way_b.stray,
        }
    }

    /// Whether they may be within some metres of each other now.
    pub(crate) fn is_near(&self, metres: f32) -> bool {
        let ([x, y], reach) = (self.offset, self.radii + metres);
        x * x + y * y <= reach * reach
    }

    /// Whether they may come within some metres of each other in that many seconds.
    pub(crate) fn comes_near(&self, metres: f32, seconds: f32) -> bool {
        let ([x, y], [u, v], reach) = (self.offset, self.velocity, self.radii + self.strays + metres);
        let time = self.nearest();
        let time = if time > 0.0 { time } else { 0.0 };
        let time = if time < seconds { time } else { seconds };
        let [x, y] = [x + u * time, y + v * time];
        x * x + y * y <= reach * reach
    }

    /// Seconds from now between which they may be within some metres of each other.
    pub(crate) fn when_near(&self, metres: f32) -> [f32; 2] {
        let ([x, y], [u, v], reach) = (self.offset, self.velocity, self.radii + self.strays + metres);
        let (square, cross) = (u * u + v * v, x * v - y * u);
        // Along the way, before and after where they are nearest.
        let half = ((reach * reach * square - cross * cross).max(0.0)).sqrt() / square;
        let middle = self.nearest();
        if square < SLOWEST { [0.0, f32::INFINITY] } else { [middle - half, middle + half] }
    }

    /// Seconds from now when they are nearest; some number if they never move.
    fn nearest(&self) -> f32 {
        let ([x, y], [u, v]) = (self.offset, self.velocity);
        let square = u * u + v * v;
        -(x * u + y * v) / if square < SLOWEST { SLOWEST } else { square }
    }
}

/// Least square of a speed that gets anybody anywhere, in m²/s².
const SLOWEST: f32 = 1e-12;

/// A robot's pieces, by its number among ways and all of their pieces; none if it drives straight on.
pub(crate) fn pieces_of<'all>(number: usize, ways: &[Way], pieces: &'all [Piece]) -> &'all [Piece] {
    let Some(way) = ways.get(number) else { return &[] };
    let end = ways.get(number + 1).map_or(pieces.len(), |next| next.first_piece as usize);
    &pieces[way.first_piece as usize..end]
}
