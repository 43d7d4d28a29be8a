//! Fits arc-length pieces to a Bézier curve.
//!
//! A piece is the cubic Hermite polynomial in arc length that has the curve's position and unit tangent at both of
//! its ends, so neither jumps from one piece to the next. Where pieces end is chosen by their measured error.
//!
//! Where the curve stops and turns back (a cusp, p' = 0) there is no smooth heading: a piece ends there, and the
//! heading turns by π between that piece and the next. A turn so tight that it is over within about a tenth of a
//! micrometre is taken the same way, at one point.

use glam::DVec2;

use super::CubicBezier;
use super::arc_length::{Distance, Piece, PieceInfo};
use super::bezier::Side;

/// Longest piece in metres: with a step of as much again, `w` still fits [`Distance`].
const LONGEST: f64 = 8.0;
/// Metres. A piece this short is accepted whatever its error, as a straight line. Sixteen units of [`Distance`].
const SHORTEST: f64 = 16.0 / Distance::PER_METRE;
/// What a fit may be off by, in metres: 1 mm less what `f32` rounds away at 8 km from the origin.
const POSITION_TOLERANCE: f64 = 0.3e-3;
/// In radians: three quarters of 0.1°.
const HEADING_TOLERANCE: f64 = 0.075 * std::f64::consts::PI / 180.0;
/// Of |p'(w)|: three quarters of 0.1 %.
const PACE_TOLERANCE: f64 = 0.75e-3;
/// Intervals into which a trial is cut to measure it.
const INTERVALS: usize = 8;

/// A point of the curve that a piece starts or ends at.
#[derive(Clone, Copy, Debug)]
struct Joint {
    position: DVec2,
    tangent: DVec2,
}

impl Joint {
    /// Facing the other way: for driving in the other direction.
    fn turned(self) -> Self {
        Self { tangent: -self.tangent, ..self }
    }
}

/// A piece to be: between two points of the curve.
#[derive(Clone, Copy, Debug)]
struct Stretch {
    from: Joint,
    to: Joint,
    /// Units of [`Distance`] from the edge's origin.
    start: i64,
    end: i64,
    /// Too short to tell its turn: straight.
    is_tip: bool,
}

/// A curve cut into stretches, from which the pieces of both gears are made.
#[derive(Clone, Debug)]
pub(super) struct Fitted(Vec<Stretch>);

impl Fitted {
    /// Pieces from P0 to P3.
    pub(super) fn forward(&self) -> impl Iterator<Item = (Piece, PieceInfo)> {
        self.0.iter().map(|stretch| stretch.piece(stretch.from, stretch.to, stretch.end))
    }

    /// Pieces from P3 to P0.
    pub(super) fn reverse(&self) -> impl Iterator<Item = (Piece, PieceInfo)> {
        self.0.iter().rev().map(|stretch| stretch.piece(stretch.to.turned(), stretch.from.turned(), stretch.start))
    }
}

impl Stretch {
    fn piece(&self, from: Joint, to: Joint, s_end: i64) -> (Piece, PieceInfo) {
        let length = Distance((self.end - self.start) as i32);
        let polynomial = match self.is_tip {
            true => Polynomial([to.position, to.tangent, DVec2::ZERO, DVec2::ZERO]),
            false => Polynomial::hermite(from, to, length.to_metres()),
        };
        (polynomial.to_piece(), PieceInfo { length, s_end: (s_end as f64 / Distance::PER_METRE) as f32 })
    }
}

/// A piece in `f64`: coefficients of the powers of w.
struct Polynomial([DVec2; 4]);

impl Polynomial {
    /// The cubic with these positions and derivatives at w = -length and w = 0.
    fn hermite(from: Joint, to: Joint, length: f64) -> Self {
        let mean = (to.position - from.position) / length;
        let bend = from.tangent + to.tangent - mean * 2.0;
        Self([to.position, to.tangent, (bend + to.tangent - mean) / length, bend / (length * length)])
    }

    fn position(&self, w: f64) -> DVec2 {
        self.0[0] + (self.0[1] + (self.0[2] + self.0[3] * w) * w) * w
    }

    fn derivative(&self, w: f64) -> DVec2 {
        self.0[1] + (self.0[2] * 2.0 + self.0[3] * (3.0 * w)) * w
    }

    fn to_piece(&self) -> Piece {
        Piece { x: self.0.map(|c| c.x as f32), y: self.0.map(|c| c.y as f32) }
    }
}

/// Cuts a curve into pieces. `tangents` are the unit tangents at its ends, which the caller may know better.
pub(super) fn fit(curve: &CubicBezier, tangents: [DVec2; 2]) -> Fitted {
    let mut fitting = Fitting { curve, stretches: Vec::new(), metres: 0.0, units: 0 };
    let mut tangent = tangents[0];
    let mut start = 0.0;
    for slow in curve.slow_points() {
        fitting.span(start, tangent, slow, curve.tangent(slow, Side::Before));
        (start, tangent) = (slow, curve.tangent(slow, Side::After));
    }
    fitting.span(start, tangent, 1.0, tangents[1]);
    Fitted(fitting.stretches)
}

/// The work in hand: how far it has come.
struct Fitting<'a> {
    curve: &'a CubicBezier,
    stretches: Vec<Stretch>,
    metres: f64,
    units: i64,
}

/// The curve from one parameter to another as one piece.
struct Trial {
    to: Joint,
    /// Metres.
    length: f64,
    /// Relative to what is tolerated; good up to 1.
    error: f64,
}

impl Fitting<'_> {
    /// Fits a part of the curve along which |p'| has no narrow minimum inside.
    fn span(&mut self, start: f64, tangent: DVec2, end: f64, end_tangent: DVec2) {
        let last = Joint { position: self.curve.position(end), tangent: end_tangent };
        let mut from = Joint { position: self.curve.position(start), tangent };
        let mut at = start;
        while at < end {
            let (to, trial) = self.longest(at, from, end, last);
            let is_tip = trial.error > 1.0;
            (at, from) =
                if to < end { self.push(from, to, trial, is_tip) } else { self.push_last(from, to, trial, is_tip) };
        }
    }

    /// A good piece from `at`, a long one if possible.
    fn longest(&self, at: f64, from: Joint, end: f64, last: Joint) -> (f64, Trial) {
        let mut to = end;
        loop {
            let joint = if to < end { self.joint(to) } else { last };
            let trial = self.measure(at, from, to, joint);
            let shrink = if trial.length > LONGEST + SHORTEST {
                self.shrink_to_longest(at, to, trial.length)
            } else if trial.error > 1.0 && trial.length > SHORTEST {
                // Errors go with the third power of the length; equal parts leave no short rest.
                1.0 / trial.error.cbrt().ceil().clamp(2.0, 8.0)
            } else {
                return (to, trial);
            };
            to = at + (to - at) * shrink;
        }
    }

    /// Newton's step towards the parameter at which a piece has the greatest length, as a part of to - at.
    fn shrink_to_longest(&self, at: f64, to: f64, length: f64) -> f64 {
        let step = (length - LONGEST) / (self.curve.derivative(to).length() * (to - at));
        (1.0 - step).max(0.5 * LONGEST / length)
    }

    fn joint(&self, at: f64) -> Joint {
        Joint { position: self.curve.position(at), tangent: self.curve.tangent(at, Side::Before) }
    }

    /// Fits one piece and compares it with the curve in between.
    fn measure(&self, at: f64, from: Joint, to: f64, joint: Joint) -> Trial {
        let lambda = |i: usize| at + (to - at) * (i as f64 / INTERVALS as f64);
        let mut sums = [0.0; INTERVALS + 1];
        for i in 0..INTERVALS {
            sums[i + 1] = sums[i] + self.curve.quadrature(lambda(i), lambda(i + 1));
        }
        let length = sums[INTERVALS];
        let polynomial = Polynomial::hermite(from, joint, length);
        let error = |i: usize| self.error(&polynomial, sums[i] - length, lambda(i));
        Trial { to: joint, length, error: (1..INTERVALS).map(error).fold(0.0, f64::max) }
    }

    /// The worst of the three errors at a point, relative to what is tolerated.
    fn error(&self, polynomial: &Polynomial, w: f64, lambda: f64) -> f64 {
        let derivative = polynomial.derivative(w);
        let pace = derivative.length();
        let tangent = self.curve.derivative(lambda).normalize_or_zero();
        let position = polynomial.position(w).distance(self.curve.position(lambda)) / POSITION_TOLERANCE;
        if derivative.dot(tangent) <= 0.0 {
            return f64::INFINITY;
        }
        let heading = (derivative.perp_dot(tangent) / pace).abs() / HEADING_TOLERANCE;
        position.max(heading).max((pace - 1.0).abs() / PACE_TOLERANCE)
    }

    /// Adds a piece that ends inside the span, moving its end by less than a unit so that its length is a whole
    /// number of units and nothing adds up.
    fn push(&mut self, from: Joint, to: f64, trial: Trial, is_tip: bool) -> (f64, Joint) {
        let metres = self.metres + trial.length;
        let end = self.next_unit(metres);
        let rounding = end as f64 / Distance::PER_METRE - metres;
        let to = to + rounding / self.curve.derivative(to).length();
        self.metres = metres + rounding;
        let joint = self.joint(to);
        self.stretches.push(Stretch { from, to: joint, start: self.units, end, is_tip });
        self.units = end;
        (to, joint)
    }

    fn push_last(&mut self, from: Joint, to: f64, trial: Trial, is_tip: bool) -> (f64, Joint) {
        self.metres += trial.length;
        let end = self.next_unit(self.metres);
        self.stretches.push(Stretch { from, to: trial.to, start: self.units, end, is_tip });
        self.units = end;
        (to, trial.to)
    }

    /// The unit nearest to so many metres from the origin, and beyond the last.
    fn next_unit(&self, metres: f64) -> i64 {
        ((metres * Distance::PER_METRE).round_ties_even() as i64).max(self.units + 1)
    }
}
