//! Fits arc-length pieces to a Bézier curve.
//!
//! A piece is the cubic Hermite polynomial in arc length that has the curve's position and unit
//! tangent at both of its ends, so that position and heading are continuous from one piece to the
//! next. The ends of the pieces are chosen by measuring the error of each candidate.
//!
//! Where the curve stops and turns back (a cusp, p' = 0) it has no continuous heading: a piece ends
//! there, and the heading turns by π between that piece and the next. A curve that turns within a
//! few units of [`Distance`] also turns in steps. The bounds on heading and |p'(w)| hold wherever
//! the radius of curvature is 30 µm or more.

use glam::DVec2;
use regatta_base::bezier::{CubicBezier, Side, Velocity};
use regatta_layout::Path;
use regatta_motion::Distance;

use super::SAME_HEADING;
use super::curve_span::{CurveSpan, Knot, Polynomial};

/// The longest piece in metres: with one step of the same length added, `w` still fits
/// [`Distance`].
const LONGEST: f64 = 8.0;
/// The longest piece that is accepted, in metres.
pub(super) const LONGEST_ACCEPTED: f64 = LONGEST + SHORTEST;
/// The length in metres up to which a piece is accepted, as a straight line, whatever its error.
/// Sixteen units of [`Distance`].
const SHORTEST: f64 = 16.0 / Distance::PER_METRE;
/// The position error in metres that a piece may have: the documented bound, less a margin for
/// errors between the measured points and for the rounding of a short piece's length.
const POSITION_TOLERANCE: f64 = 0.95e-3;
/// The heading error in radians, with the same margin.
const HEADING_TOLERANCE: f64 = 0.088 * std::f64::consts::PI / 180.0;
/// The error of the parametric speed |p'(w)|, with the same margin.
const PARAMETRIC_SPEED_TOLERANCE: f64 = 0.85e-3;
/// The number of candidates that are tried after the first good one; then the longest good one is
/// used.
const ATTEMPTS: u32 = 3;
/// The number of intervals in which a candidate is first measured: enough to find a bad one.
const COARSE: usize = 4;
/// The number of intervals in which a seemingly good candidate is measured again.
const FINE: usize = 16;

/// Divides a path into spans that can each be driven as one piece. `tangents` are the unit tangents
/// at the path's ends, which the caller may know more exactly than the control points do.
pub(super) fn fit(path: &Path, tangents: [DVec2; 2]) -> Vec<CurveSpan> {
    let mut fitted = Fitted { spans: Vec::new(), metres: 0.0, units: 0 };
    let mut start = tangents[0];
    let mut cubics = path.cubics().peekable();
    while let Some(cubic) = cubics.next() {
        let end =
            if cubics.peek().is_none() { tangents[1] } else { cubic.tangent(1.0, Side::Before) };
        fitted = fit_cubic(cubic, [start, end], fitted);
        let Some(next) = cubics.peek() else { break };
        let departure = next.tangent(0.0, Side::After);
        // If the curve is smooth there, both pieces get exactly the same tangent.
        start = if departure.distance(end) < SAME_HEADING { end } else { departure };
    }
    fitted.spans
}

/// The fitted part of a path: the spans, and their length.
struct Fitted {
    spans: Vec<CurveSpan>,
    metres: f64,
    units: i64,
}

/// Divides the next cubic of a path.
fn fit_cubic(curve: &CubicBezier, tangents: [DVec2; 2], before: Fitted) -> Fitted {
    let Fitted { spans, metres, units } = before;
    let mut fitter = Fitter {
        curve,
        velocity: curve.velocity(),
        tolerance: position_tolerance(curve),
        spans,
        metres,
        units,
    };
    let [start_tangent, end_tangent] = tangents;
    let mut at = 0.0;
    let mut from = Knot { position: curve.position(0.0), tangent: start_tangent };
    for slow in curve.slow_points() {
        let is_fixed = stops_at(curve, slow);
        let to = fitter.knot(slow);
        (at, from) = fitter.fit_section(at, from, SectionEnd { at: slow, knot: to, is_fixed });
        if is_fixed {
            from.tangent = curve.tangent(slow, Side::After);
        }
    }
    let to = Knot { position: curve.position(1.0), tangent: end_tangent };
    fitter.fit_section(at, from, SectionEnd { at: 1.0, knot: to, is_fixed: true });
    Fitted { spans: fitter.spans, metres: fitter.metres, units: fitter.units }
}

/// Whether a slow point is a cusp, or so close to one that the curve turns within a few units of
/// [`Distance`].
fn stops_at(curve: &CubicBezier, slow: f64) -> bool {
    // At a minimum of |p'|, p'' is perpendicular to p', so this is the radius of curvature.
    curve.derivative(slow).length_squared() / curve.second_derivative(slow).length()
        < 8.0 * SHORTEST
}

/// The end of a section of the curve: the part between two slow points, which is fitted at once.
#[derive(Clone, Copy)]
struct SectionEnd {
    /// The curve parameter λ.
    at: f64,
    knot: Knot,
    /// Whether the end must stay where it is, to the unit.
    is_fixed: bool,
}

/// Returns [`POSITION_TOLERANCE`] less the error of rounding to `f32`: twice half a unit in the
/// last place of x and of y.
fn position_tolerance(curve: &CubicBezier) -> f64 {
    let farthest =
        curve.control_points.iter().map(|point| point.abs().max_element()).fold(0.0, f64::max)
            as f32;
    let rounding = std::f64::consts::SQRT_2 * f64::from(farthest.next_up() - farthest);
    (POSITION_TOLERANCE - rounding).max(0.2 * POSITION_TOLERANCE)
}

/// The state of fitting one cubic: the spans of the path so far, and their length.
struct Fitter<'a> {
    curve: &'a CubicBezier,
    velocity: Velocity,
    /// The position error in metres that a piece may have.
    tolerance: f64,
    spans: Vec<CurveSpan>,
    metres: f64,
    units: i64,
}

/// A candidate piece: the curve from one parameter to another as one polynomial.
#[derive(Clone, Copy)]
struct Candidate {
    to: Knot,
    /// Metres.
    length: f64,
    /// The largest error relative to its tolerance; good up to 1.
    error: f64,
}

impl Candidate {
    fn is_good(&self) -> bool {
        self.error <= 1.0 && self.length <= LONGEST_ACCEPTED
    }

    /// Whether a longer candidate is unlikely to be good.
    fn is_long(&self) -> bool {
        self.error > 0.6 || self.length > 0.999 * LONGEST
    }
}

impl Fitter<'_> {
    /// Fits a section of the curve in whose interior |p'| has no narrow minimum. Returns the
    /// parameter and the knot where it ended.
    fn fit_section(&mut self, start: f64, first: Knot, end: SectionEnd) -> (f64, Knot) {
        let (mut at, mut from, mut hint) = (start, first, end.at - start);
        loop {
            let (to, candidate) = self.longest(at, from, hint, end);
            let (to, candidate) = self.balanced(at, from, to, end).unwrap_or((to, candidate));
            hint = to - at;
            (at, from) = self.push(from, to, &candidate, end);
            if to == end.at {
                break;
            }
        }
        (at, from)
    }

    /// Returns a good candidate from `at` that is nearly as long as possible, or that divides the
    /// rest of the section evenly; if none is good, a very short one. The search starts at a width
    /// of `hint`.
    fn longest(&self, at: f64, from: Knot, hint: f64, end: SectionEnd) -> (f64, Candidate) {
        let mut best: Option<(f64, Candidate)> = None;
        let mut bad = f64::INFINITY;
        let mut to = (at + hint).min(end.at);
        let mut share = f64::NAN;
        let mut attempts = 0;
        loop {
            let candidate =
                self.measure(at, from, to, if to < end.at { self.knot(to) } else { end.knot });
            let next = at + (to - at) * self.scale(at, to, &candidate);
            if candidate.is_good() {
                if to == end.at || candidate.is_long() || (to == share && candidate.error > 0.25) {
                    return (to, candidate);
                }
                best = Some((to, candidate));
            } else if best.is_none() && candidate.length <= SHORTEST {
                return (to, candidate);
            } else {
                bad = to;
            }
            if to == end.at && candidate.error.is_finite() && candidate.length <= LONGEST {
                share = at + (end.at - at) / candidate.error.cbrt().ceil();
                to = share;
                continue;
            }
            attempts += u32::from(best.is_some());
            let good = match best {
                Some(best) if attempts > ATTEMPTS => return best,
                Some((good, _)) => good,
                None => at,
            };
            to = if good < next && next < bad {
                next.min(end.at)
            } else {
                (good + bad.min(end.at)) / 2.0
            };
        }
    }

    /// Returns a candidate for half of the rest of the section if a longer one would leave only a
    /// short remainder: the rounding of its length would make that inexact.
    fn balanced(&self, at: f64, from: Knot, to: f64, end: SectionEnd) -> Option<(f64, Candidate)> {
        if to == end.at || end.at - to > 0.5 * (to - at) {
            return None;
        }
        let middle = (at + end.at) / 2.0;
        let knot = self.knot(middle);
        let halves =
            [self.measure(at, from, middle, knot), self.measure(middle, knot, end.at, end.knot)];
        let is_good = halves.iter().all(Candidate::is_good);
        let [first, _] = halves;
        is_good.then_some((middle, first))
    }

    /// Returns the factor by which to widen a candidate so that it becomes as long as its error
    /// allows.
    fn scale(&self, at: f64, to: f64, candidate: &Candidate) -> f64 {
        // Errors grow with the third power of the length where the curve is smooth.
        let by_error = (0.85 / candidate.error).cbrt();
        let newton =
            1.0 + (LONGEST - candidate.length) / (self.curve.derivative(to).length() * (to - at));
        by_error.min(newton.max(0.5 * LONGEST / candidate.length)).clamp(0.1, 4.0)
    }

    fn knot(&self, at: f64) -> Knot {
        Knot { position: self.curve.position(at), tangent: self.curve.tangent(at, Side::Before) }
    }

    /// Fits one piece and measures its error between its ends; at more points if it seems to be
    /// good.
    fn measure(&self, at: f64, from: Knot, to: f64, knot: Knot) -> Candidate {
        let candidate = self.measure_at::<COARSE>(at, from, to, knot);
        if candidate.is_good() { self.measure_at::<FINE>(at, from, to, knot) } else { candidate }
    }

    fn measure_at<const INTERVALS: usize>(
        &self,
        at: f64,
        from: Knot,
        to: f64,
        knot: Knot,
    ) -> Candidate {
        // The ends of the intervals, and the arc lengths up to there.
        let mut ends = [at; INTERVALS];
        let mut lengths = [0.0; INTERVALS];
        let (mut start, mut length) = (at, 0.0);
        for i in 0..INTERVALS {
            // Denser towards the ends, where the slow points are.
            let end = at + (to - at) * smoothstep((i + 1) as f64 / INTERVALS as f64);
            length += self.velocity.quadrature(start, end);
            (ends[i], lengths[i], start) = (end, length, end);
        }
        let polynomial = Polynomial::hermite(from, knot, length);
        let mut worst = [0.0_f64; 2];
        for i in 1..INTERVALS {
            let errors = self.errors(&polynomial, lengths[i - 1] - length, ends[i - 1]);
            worst = [worst[0].max(errors[0]), worst[1].max(errors[1])];
        }
        // x^¾: position errors grow with the fourth power of the length, the others with the third.
        let position = worst[0].sqrt() * worst[0].sqrt().sqrt();
        Candidate { to: knot, length, error: position.max(worst[1]) }
    }

    /// Returns the position error at a point, and the larger of the errors of heading and
    /// parametric speed, relative to their tolerances.
    fn errors(&self, polynomial: &Polynomial, w: f64, lambda: f64) -> [f64; 2] {
        let derivative = polynomial.derivative(w);
        let speed = derivative.length();
        let tangent = self.velocity.at(lambda);
        if derivative.dot(tangent) <= 0.0 {
            return [f64::INFINITY; 2];
        }
        let position =
            polynomial.position(w).distance(self.curve.position(lambda)) / self.tolerance;
        let heading =
            derivative.perp_dot(tangent).abs() / (speed * tangent.length() * HEADING_TOLERANCE);
        [position, heading.max((speed - 1.0).abs() / PARAMETRIC_SPEED_TOLERANCE)]
    }

    /// Adds a span. Unless its end is fixed, moves the end by less than a unit so that the length
    /// is a whole number of units and rounding errors don't accumulate. Returns the parameter and
    /// the knot where the span ends.
    fn push(&mut self, from: Knot, to: f64, candidate: &Candidate, end: SectionEnd) -> (f64, Knot) {
        self.metres += candidate.length;
        let unit = self.next_unit(self.metres);
        let rounding = unit as f64 / Distance::PER_METRE - self.metres;
        let shift = rounding / self.curve.derivative(to).length();
        let (mut to, mut knot) = (to, candidate.to);
        if !end.is_fixed || shift.abs() < 0.1 * (end.at - to) {
            self.metres += rounding;
            to += shift;
            knot = self.knot(to);
        }
        let is_straight = candidate.error > 1.0;
        self.spans.push(CurveSpan { from, to: knot, start: self.units, end: unit, is_straight });
        self.units = unit;
        (to, knot)
    }

    /// Returns the unit nearest to a distance in metres from the origin, at least one unit beyond
    /// the last span.
    fn next_unit(&self, metres: f64) -> i64 {
        ((metres * Distance::PER_METRE).round_ties_even() as i64).max(self.units + 1)
    }
}

/// Returns the cubic 3 t² - 2 t³, which rises from 0 to 1 with the slope 0 at both ends.
fn smoothstep(t: f64) -> f64 {
    t * t * (3.0 - 2.0 * t)
}
