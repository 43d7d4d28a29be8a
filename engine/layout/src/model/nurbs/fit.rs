//! Fits cubics to a rational Bézier curve within a tolerance, by least squares with the curve's
//! tangents at both ends. Where the fit isn't close enough, the curve is halved.

use glam::{DVec2, DVec3};
use regatta_base::bezier::{CubicBezier, Side};

use super::{HEADING_TOLERANCE, TOLERANCE, project};

/// The number of intervals between the points of a curve to which a cubic is fitted.
const INTERVALS: usize = 24;

/// The number of times that the points' parameters are corrected.
const ROUNDS: usize = 6;

/// A cubic is accepted after this many halvings, whatever its error.
const MAX_DEPTH: u32 = 8;

/// A cubic is accepted after this many halvings, whatever the error of its heading. At corners and
/// on tiny curves, more halvings don't help.
const MAX_HEADING_DEPTH: u32 = 4;

/// The relative difference of weights that is a rounding error.
const SAME_WEIGHT: f64 = 1e-12;

/// The distance in metres below which two control points are the same, as a fraction of the curve's
/// extent.
const SAME_POINT: f64 = 1e-9;

/// A rational Bézier curve: control points (x·w, y·w, w), at least two.
#[derive(Clone, Debug)]
pub(super) struct RationalBezier(pub Vec<DVec3>);

impl RationalBezier {
    /// Returns the same curve as a cubic, if it has at most degree 3 and equal weights.
    pub fn to_cubic(&self) -> Option<CubicBezier> {
        let weight = self.0.first()?.z;
        if self.0.iter().any(|point| (point.z - weight).abs() > SAME_WEIGHT * weight) {
            return None;
        }
        let points: Vec<DVec2> = self.0.iter().map(|point| project(*point)).collect();
        match points[..] {
            [p0, p1] => Some(CubicBezier::straight(p0, p1)),
            [p0, p1, p2] => Some(CubicBezier {
                control_points: [p0, p0.lerp(p1, 2.0 / 3.0), p2.lerp(p1, 2.0 / 3.0), p2],
            }),
            [p0, p1, p2, p3] => Some(CubicBezier { control_points: [p0, p1, p2, p3] }),
            _ => None,
        }
    }

    /// Returns the point at a parameter in [0, 1].
    pub fn position(&self, parameter: f64) -> DVec2 {
        let mut points = self.0.clone();
        while points.len() > 1 {
            halfway(&mut points, parameter);
            points.pop();
        }
        points.first().map_or(DVec2::ZERO, |point| project(*point))
    }

    /// Returns the direction at a parameter in [0, 1], not normalized; zero where it isn't defined.
    fn direction(&self, parameter: f64) -> DVec2 {
        let mut points = self.0.clone();
        while points.len() > 2 {
            halfway(&mut points, parameter);
            points.pop();
        }
        // The last two points of de Casteljau's scheme are on the tangent.
        match points[..] {
            [before, after] => project(after) - project(before),
            _ => DVec2::ZERO,
        }
    }

    /// Returns the two halves.
    fn halves(&self) -> [Self; 2] {
        let (mut points, mut left, mut right) = (self.0.clone(), Vec::new(), Vec::new());
        while let (Some(first), Some(last)) = (points.first().copied(), points.last().copied()) {
            left.push(first);
            right.push(last);
            halfway(&mut points, 0.5);
            points.pop();
        }
        right.reverse();
        [Self(left), Self(right)]
    }

    /// Returns the derivative at the start, in metres.
    fn start_derivative(&self) -> DVec2 {
        let [first, second] = [self.0[0], self.0[1]];
        (project(second) - project(first)) * (second.z / first.z * (self.0.len() - 1) as f64)
    }

    /// Returns the unit tangent at the start; zero if all control points coincide.
    fn start_tangent(&self) -> DVec2 {
        let start = project(self.0[0]);
        let mut offsets = self.0.iter().map(|point| project(*point) - start);
        let extent = offsets.clone().map(DVec2::length).fold(0.0, f64::max);
        offsets
            .find(|offset| offset.length() > SAME_POINT * extent)
            .map_or(DVec2::ZERO, DVec2::normalize)
    }

    /// Whether the curve may move against the direction from its start to its end, judged by its
    /// control points.
    fn turns_back(&self) -> bool {
        let points: Vec<DVec2> = self.0.iter().map(|point| project(*point)).collect();
        let chord = project(self.0[self.0.len() - 1]) - project(self.0[0]);
        points.windows(2).any(|pair| (pair[1] - pair[0]).dot(chord) < 0.0)
    }

    fn reversed(&self) -> Self {
        Self(self.0.iter().rev().copied().collect())
    }
}

/// Interpolates each point with the next at `parameter`. The last point stays.
fn halfway(points: &mut [DVec3], parameter: f64) {
    for index in 1..points.len() {
        points[index - 1] = points[index - 1].lerp(points[index], parameter);
    }
}

/// Appends cubics along a curve. Returns the largest distance in metres. Halving stops at
/// `max_cubics`.
pub(super) fn fit(curve: &RationalBezier, cubics: &mut Vec<CubicBezier>, max_cubics: usize) -> f64 {
    fit_or_halve(curve, cubics, max_cubics, MAX_DEPTH)
}

fn fit_or_halve(
    curve: &RationalBezier,
    cubics: &mut Vec<CubicBezier>,
    max_cubics: usize,
    depth: u32,
) -> f64 {
    let samples: Vec<DVec2> =
        (0..=INTERVALS).map(|index| curve.position(fraction(index))).collect();
    let (cubic, error) = best(curve, &samples);
    let is_close = error <= TOLERANCE
        && (depth + MAX_HEADING_DEPTH <= MAX_DEPTH
            || heading_error(curve, &cubic, &samples) <= HEADING_TOLERANCE);
    if is_close || depth == 0 || cubics.len() >= max_cubics {
        cubics.push(cubic);
        return error;
    }
    let [left, right] = curve.halves();
    let left = fit_or_halve(&left, cubics, max_cubics, depth - 1);
    left.max(fit_or_halve(&right, cubics, max_cubics, depth - 1))
}

fn fraction(index: usize) -> f64 {
    index as f64 / INTERVALS as f64
}

/// Returns the closest cubic and its distance.
fn best(curve: &RationalBezier, samples: &[DVec2]) -> (CubicBezier, f64) {
    let hermite = hermite(curve);
    let error = distance(&hermite, samples, &(0..=INTERVALS).map(fraction).collect::<Vec<_>>());
    if error <= TOLERANCE / 10.0 {
        return (hermite, error);
    }
    let fitted = least_squares(curve, samples).filter(|(_, fitted)| *fitted < error);
    fitted.unwrap_or((hermite, error))
}

/// Returns the greatest angle in radians between a curve and a cubic close to it; 0 for a curve
/// that turns back.
fn heading_error(curve: &RationalBezier, cubic: &CubicBezier, samples: &[DVec2]) -> f64 {
    if curve.turns_back() {
        return 0.0;
    }
    let mut parameters: Vec<f64> = (0..=INTERVALS).map(fraction).collect();
    for _ in 0..ROUNDS {
        correct(&mut parameters, cubic, samples);
    }
    let mut largest: f64 = 0.0;
    for (index, &at) in parameters.iter().enumerate() {
        let direction = curve.direction(fraction(index));
        if direction != DVec2::ZERO {
            largest = largest.max(direction.angle_to(cubic.tangent(at, Side::After)).abs());
        }
    }
    largest
}

/// Returns the cubic with the points and derivatives of the curve at its ends.
fn hermite(curve: &RationalBezier) -> CubicBezier {
    let back = curve.reversed();
    let (start, end) = (project(curve.0[0]), project(back.0[0]));
    let control_points =
        [start, start + curve.start_derivative() / 3.0, end + back.start_derivative() / 3.0, end];
    CubicBezier { control_points }
}

/// Returns the cubic closest to the samples among those with the curve's tangents at both ends, and
/// its distance. Returns `None` if the curve has no tangents, or turns back, so that nearest points
/// aren't unique.
fn least_squares(curve: &RationalBezier, samples: &[DVec2]) -> Option<(CubicBezier, f64)> {
    if curve.turns_back() {
        return None;
    }
    let tangents = [curve.start_tangent(), curve.reversed().start_tangent()];
    let mut parameters: Vec<f64> = (0..=INTERVALS).map(fraction).collect();
    let mut best: Option<(CubicBezier, f64)> = None;
    let mut measure = Measure::Distance;
    for _ in 0..ROUNDS {
        let Some(cubic) = handles(samples, &parameters, tangents, measure) else { break };
        correct(&mut parameters, &cubic, samples);
        if parameters.windows(2).any(|pair| pair[1] <= pair[0]) {
            break;
        }
        let error = distance(&cubic, samples, &parameters);
        if best.is_none_or(|(_, least)| error < least) {
            best = Some((cubic, error));
        }
        measure = Measure::Across(cubic);
    }
    best
}

/// The measure to minimize.
#[derive(Clone, Copy, Debug)]
enum Measure {
    /// The distance of each sample from the point at its parameter.
    Distance,
    /// Only the part of the distance across a cubic that is already close. It depends less on the
    /// parameters, so that few rounds are enough.
    Across(CubicBezier),
}

impl Measure {
    fn of(&self, vector: DVec2, parameter: f64) -> DVec2 {
        match self {
            Self::Distance => vector,
            Self::Across(cubic) => {
                vector.reject_from_normalized(cubic.tangent(parameter, Side::After))
            }
        }
    }
}

/// Solves for the lengths of both handles.
fn handles(
    samples: &[DVec2],
    parameters: &[f64],
    tangents: [DVec2; 2],
    measure: Measure,
) -> Option<CubicBezier> {
    let (start, end) = (*samples.first()?, *samples.last()?);
    let (mut matrix, mut right) = ([[0.0; 2]; 2], [0.0; 2]);
    for (sample, &at) in samples.iter().zip(parameters) {
        let mu = 1.0 - at;
        let columns = [tangents[0] * (3.0 * mu * mu * at), tangents[1] * (3.0 * mu * at * at)];
        let columns = columns.map(|column| measure.of(column, at));
        let rest =
            *sample - start * (mu * mu * (1.0 + 2.0 * at)) - end * (at * at * (3.0 - 2.0 * at));
        for (row, one) in columns.iter().enumerate() {
            matrix[row] =
                [matrix[row][0] + one.dot(columns[0]), matrix[row][1] + one.dot(columns[1])];
            right[row] += one.dot(rest);
        }
    }
    let determinant = matrix[0][0] * matrix[1][1] - matrix[0][1] * matrix[1][0];
    let lengths = [
        (right[0] * matrix[1][1] - right[1] * matrix[0][1]) / determinant,
        (right[1] * matrix[0][0] - right[0] * matrix[1][0]) / determinant,
    ];
    let is_good = lengths.iter().all(|length| length.is_finite() && *length > 0.0);
    is_good.then(|| CubicBezier {
        control_points: [
            start,
            start + tangents[0] * lengths[0],
            end + tangents[1] * lengths[1],
            end,
        ],
    })
}

/// Moves each parameter, except the ends, towards the point of the cubic that is closest to its
/// sample: one step of Newton.
fn correct(parameters: &mut [f64], cubic: &CubicBezier, samples: &[DVec2]) {
    for (parameter, sample) in parameters.iter_mut().zip(samples).take(INTERVALS).skip(1) {
        *parameter = cubic.nearer(*parameter, *sample);
    }
}

/// Returns the greatest distance between samples and the points of the cubic at their parameters.
fn distance(cubic: &CubicBezier, samples: &[DVec2], parameters: &[f64]) -> f64 {
    let distances =
        parameters.iter().zip(samples).map(|(&at, sample)| cubic.position(at).distance(*sample));
    distances.fold(0.0, f64::max)
}
