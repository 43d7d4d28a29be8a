//! Fits arc-length pieces to a Bézier curve.
//!
//! A piece is the cubic Hermite polynomial in arc length that has the curve's position and unit tangent at both of
//! its ends, so neither jumps from one piece to the next. Where pieces end is chosen by their measured error.
//!
//! Where the curve stops and turns back (a cusp, p' = 0) there is no smooth heading: a piece ends there, and the
//! heading turns by π between that piece and the next. So it does, in steps, where the curve turns within a few units
//! of [`Distance`]; the bounds of heading and pace hold wherever the radius of curvature is 30 µm or more.

use glam::DVec2;

use super::CubicBezier;
use super::arc_length::Distance;
use super::bezier::{Side, Velocity};
use super::stretch::{Fitted, Joint, Polynomial, Stretch};

/// Longest piece in metres: with a step of as much again, `w` still fits [`Distance`].
const LONGEST: f64 = 8.0;
/// Metres. A piece this short is accepted whatever its error, as a straight line. Sixteen units of [`Distance`].
const SHORTEST: f64 = 16.0 / Distance::PER_METRE;
/// What a piece may be off by, in metres, less what hides between the points that are measured and what it costs to
/// round a short length.
const POSITION_TOLERANCE: f64 = 0.95e-3;
/// In radians, likewise.
const HEADING_TOLERANCE: f64 = 0.088 * std::f64::consts::PI / 180.0;
/// Of |p'(w)|: likewise.
const PACE_TOLERANCE: f64 = 0.85e-3;
/// Trials after the first good one, after which the longest good one is long enough.
const ATTEMPTS: u32 = 3;
/// Intervals into which a trial is cut to measure it: enough to find bad ones,
const COARSE: usize = 4;
/// and enough to trust good ones.
const FINE: usize = 16;

/// Cuts a curve into pieces. `tangents` are the unit tangents at its ends, which the caller may know better.
pub(super) fn fit(curve: &CubicBezier, tangents: [DVec2; 2]) -> Fitted {
    let mut fitting = Fitting {
        curve,
        velocity: curve.velocity(),
        tolerance: position_tolerance(curve),
        stretches: Vec::new(),
        metres: 0.0,
        units: 0,
    };
    let joint = |lambda, tangent| Joint { position: curve.position(lambda), tangent };
    let (mut at, mut from) = (0.0, joint(0.0, tangents[0]));
    for slow in curve.slow_points() {
        let is_fixed = stops_at(curve, slow);
        let to = joint(slow, curve.tangent(slow, Side::Before));
        (at, from) = fitting.span(at, from, End { at: slow, joint: to, is_fixed });
        if is_fixed {
            from.tangent = curve.tangent(slow, Side::After);
        }
    }
    fitting.span(at, from, End { at: 1.0, joint: joint(1.0, tangents[1]), is_fixed: true });
    Fitted(fitting.stretches)
}

/// Whether a slow point is a cusp, or so near to one that its turn is over within a few units.
fn stops_at(curve: &CubicBezier, slow: f64) -> bool {
    // Where |p'| is least, p'' is at right angles to it and this is the radius of curvature.
    curve.derivative(slow).length_squared() / curve.second_derivative(slow).length() < 8.0 * SHORTEST
}

/// Where a part of the curve ends that is fitted in one go.
#[derive(Clone, Copy)]
struct End {
    at: f64,
    joint: Joint,
    /// It may not even be moved by a unit.
    is_fixed: bool,
}

/// What rounding to `f32` leaves of [`POSITION_TOLERANCE`]: twice half a unit in the last place of x and of y.
fn position_tolerance(curve: &CubicBezier) -> f64 {
    let farthest = curve.control_points.iter().map(|point| point.abs().max_element()).fold(0.0, f64::max) as f32;
    let rounding = std::f64::consts::SQRT_2 * f64::from(farthest.next_up() - farthest);
    (POSITION_TOLERANCE - rounding).max(0.2 * POSITION_TOLERANCE)
}

/// The work in hand: how far it has come.
struct Fitting<'a> {
    curve: &'a CubicBezier,
    velocity: Velocity,
    /// Metres that positions may be off by.
    tolerance: f64,
    stretches: Vec<Stretch>,
    metres: f64,
    units: i64,
}

/// The curve from one parameter to another as one piece.
#[derive(Clone, Copy)]
struct Trial {
    to: Joint,
    /// Metres.
    length: f64,
    /// Relative to what is tolerated; good up to 1.
    error: f64,
}

impl Trial {
    fn is_good(&self) -> bool {
        self.error <= 1.0 && self.length <= LONGEST + SHORTEST
    }

    /// Whether a longer one would hardly be good.
    fn is_long(&self) -> bool {
        self.error > 0.6 || self.length > 0.999 * LONGEST
    }
}

impl Fitting<'_> {
    /// Fits a part of the curve along which |p'| has no narrow minimum inside. Returns where it ended.
    fn span(&mut self, start: f64, first: Joint, end: End) -> (f64, Joint) {
        let (mut at, mut from, mut hint) = (start, first, end.at - start);
        loop {
            let (to, trial) = self.longest(at, from, hint, end);
            let (to, trial) = self.balanced(at, from, to, end).unwrap_or((to, trial));
            hint = to - at;
            (at, from) = self.push(from, to, &trial, end);
            if to == end.at {
                break;
            }
        }
        (at, from)
    }

    /// The longest good piece from `at`, or nearly, or a fair share of what is left; if none is good, a very short one.
    /// Starts the search at a width of `hint`.
    fn longest(&self, at: f64, from: Joint, hint: f64, end: End) -> (f64, Trial) {
        let mut best: Option<(f64, Trial)> = None;
        let mut bad = f64::INFINITY;
        let mut to = (at + hint).min(end.at);
        let mut share = f64::NAN;
        let mut attempts = 0;
        loop {
            let trial = self.measure(at, from, to, if to < end.at { self.joint(to) } else { end.joint });
            let next = at + (to - at) * self.scale(at, to, &trial);
            if trial.is_good() {
                if to == end.at || trial.is_long() || (to == share && trial.error > 0.25) {
                    return (to, trial);
                }
                best = Some((to, trial));
            } else if best.is_none() && trial.length <= SHORTEST {
                return (to, trial);
            } else {
                bad = to;
            }
            if to == end.at && trial.error.is_finite() && trial.length <= LONGEST {
                share = at + (end.at - at) / trial.error.cbrt().ceil();
                to = share;
                continue;
            }
            attempts += u32::from(best.is_some());
            let good = match best {
                Some(best) if attempts > ATTEMPTS => return best,
                Some((good, _)) => good,
                None => at,
            };
            to = if good < next && next < bad { next.min(end.at) } else { (good + bad.min(end.at)) / 2.0 };
        }
    }

    /// Half of what is left instead of nearly all of it: a short rest would only suffer from its length's rounding.
    fn balanced(&self, at: f64, from: Joint, to: f64, end: End) -> Option<(f64, Trial)> {
        if to == end.at || end.at - to > 0.5 * (to - at) {
            return None;
        }
        let middle = (at + end.at) / 2.0;
        let joint = self.joint(middle);
        let halves = [self.measure(at, from, middle, joint), self.measure(middle, joint, end.at, end.joint)];
        let is_good = halves.iter().all(Trial::is_good);
        let [first, _] = halves;
        is_good.then_some((middle, first))
    }

    /// By how much to widen or narrow a trial, so that it is as long as it may be.
    fn scale(&self, at: f64, to: f64, trial: &Trial) -> f64 {
        // Errors go with the third power of the length where the curve is smooth.
        let by_error = (0.85 / trial.error).cbrt();
        let newton = 1.0 + (LONGEST - trial.length) / (self.curve.derivative(to).length() * (to - at));
        by_error.min(newton.max(0.5 * LONGEST / trial.length)).clamp(0.1, 4.0)
    }

    fn joint(&self, at: f64) -> Joint {
        Joint { position: self.curve.position(at), tangent: self.curve.tangent(at, Side::Before) }
    }

    /// Fits one piece and compares it with the curve in between; closely if it seems to be good.
    fn measure(&self, at: f64, from: Joint, to: f64, joint: Joint) -> Trial {
        let trial = self.measure_at::<COARSE>(at, from, to, joint);
        if trial.is_good() { self.measure_at::<FINE>(at, from, to, joint) } else { trial }
    }

    fn measure_at<const INTERVALS: usize>(&self, at: f64, from: Joint, to: f64, joint: Joint) -> Trial {
        // Denser towards the ends, where a slow point may hide.
        let lambda = |i: usize| {
            let even = i as f64 / INTERVALS as f64;
            at + (to - at) * (even * even * (3.0 - 2.0 * even))
        };
        // Up to each interval's end.
        let mut lengths = [0.0; INTERVALS];
        let mut length = 0.0;
        for (i, sum) in lengths.iter_mut().enumerate() {
            length += self.velocity.quadrature(lambda(i), lambda(i + 1));
            *sum = length;
        }
        let polynomial = Polynomial::hermite(from, joint, length);
        let mut worst = [0.0_f64; 2];
        for i in 1..INTERVALS {
            let errors = self.errors(&polynomial, lengths[i - 1] - length, lambda(i));
            worst = [worst[0].max(errors[0]), worst[1].max(errors[1])];
        }
        // x^¾, as positions go with the fourth power of the length, and the others with the third.
        let position = worst[0].sqrt() * worst[0].sqrt().sqrt();
        Trial { to: joint, length, error: position.max(worst[1]) }
    }

    /// The error of the position at a point, and the worse one of heading and pace, relative to what is tolerated.
    fn errors(&self, polynomial: &Polynomial, w: f64, lambda: f64) -> [f64; 2] {
        let derivative = polynomial.derivative(w);
        let pace = derivative.length();
        let tangent = self.velocity.at(lambda);
        if derivative.dot(tangent) <= 0.0 {
            return [f64::INFINITY; 2];
        }
        let position = polynomial.position(w).distance(self.curve.position(lambda)) / self.tolerance;
        let heading = derivative.perp_dot(tangent).abs() / (pace * tangent.length() * HEADING_TOLERANCE);
        [position, heading.max((pace - 1.0).abs() / PACE_TOLERANCE)]
    }

    /// Adds a piece. If it can, it moves the piece's end by less than a unit, so that the length is a whole number of
    /// units and nothing adds up. Returns where the piece ends.
    fn push(&mut self, from: Joint, to: f64, trial: &Trial, end: End) -> (f64, Joint) {
        self.metres += trial.length;
        let unit = self.next_unit(self.metres);
        let rounding = unit as f64 / Distance::PER_METRE - self.metres;
        let shift = rounding / self.curve.derivative(to).length();
        let (mut to, mut joint) = (to, trial.to);
        if !end.is_fixed || shift.abs() < 0.1 * (end.at - to) {
            self.metres += rounding;
            to += shift;
            joint = self.joint(to);
        }
        self.stretches.push(Stretch { from, to: joint, start: self.units, end: unit, is_tip: trial.error > 1.0 });
        self.units = unit;
        (to, joint)
    }

    /// The unit nearest to so many metres from the origin, and beyond the last.
    fn next_unit(&self, metres: f64) -> i64 {
        ((metres * Distance::PER_METRE).round_ties_even() as i64).max(self.units + 1)
    }
}
