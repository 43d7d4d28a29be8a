//! NURBS (rational B-spline) curves of degree 1 to 5, and their conversion to cubic Bézier curves.
//!
//! Curves of degree 1 to 3 with equal weights are converted exactly. Others are fitted by cubics
//! with continuous tangents, to [`TOLERANCE`] and [`HEADING_TOLERANCE`]. The largest distance is
//! measured and returned.

mod fit;
#[cfg(test)]
mod tests;

use glam::{DVec2, DVec3};
use regatta_base::bezier::CubicBezier;

use fit::{RationalBezier, fit};

/// The distance in metres within which curves are fitted.
pub const TOLERANCE: f64 = 0.0005;

/// The largest error in radians of the heading on fitted curves, 0.014°. It is larger only at
/// corners.
pub const HEADING_TOLERANCE: f64 = 0.00025;

/// The largest degree.
pub const MAX_DEGREE: usize = 5;

/// The largest number of control points of a curve.
pub const MAX_POINTS: usize = 100_000;

/// The largest |x| or |y| of a control point in metres: more than the earth's circumference.
pub const MAX_COORDINATE: f64 = 1e8;

/// The largest quotient of two weights of a curve.
pub const MAX_WEIGHT_RATIO: f64 = 1e6;

/// The extent in metres below which a piece of a curve counts as a point, and is left out.
const NEGLIGIBLE_EXTENT: f64 = 1e-9;

/// A curve of this many cubics isn't subdivided further, whatever its error.
const MAX_FITTED: usize = 20_000;

/// A NURBS curve in metres.
#[derive(Clone, Debug, PartialEq)]
pub struct Nurbs {
    degree: usize,
    /// In ascending order; as many as control points + degree + 1.
    knots: Vec<f64>,
    /// (x·w, y·w, w), with all weights divided by the largest.
    points: Vec<DVec3>,
}

/// The error of constructing a [`Nurbs`] curve.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum NurbsError {
    /// The degree is out of range.
    #[error("the degree is {0}: it must be 1 to {MAX_DEGREE}")]
    Degree(usize),
    /// A curve of this degree needs more control points.
    #[error("it has {points} control points: degree {degree} needs at least {}", degree + 1)]
    TooFewPoints {
        /// The number of control points.
        points: usize,
        /// The degree.
        degree: usize,
    },
    /// There are too many control points.
    #[error("it has {0} control points: at most {MAX_POINTS} can be read")]
    TooManyPoints(usize),
    /// The number of knots doesn't match.
    #[error("it has {found} knots: {expected} are needed, which is control points + degree + 1")]
    KnotCount {
        /// The number of knots.
        found: usize,
        /// The number that is needed.
        expected: usize,
    },
    /// The numbers of weights and control points differ.
    #[error("it has {found} weights for {points} control points")]
    WeightCount {
        /// The number of weights.
        found: usize,
        /// The number of control points.
        points: usize,
    },
    /// A control point isn't finite, or too far away.
    #[error("control point {0} is beyond ±{MAX_COORDINATE} m")]
    Point(usize),
    /// A weight isn't above 0, or much smaller than another.
    #[error(
        "weight {0} is out of range: weights must be above 0, and none more than \
         {MAX_WEIGHT_RATIO} times another"
    )]
    Weight(usize),
    /// A knot isn't finite, or smaller than the one before it.
    #[error("knot {0} is smaller than the one before it, or not a number")]
    KnotOrder(usize),
    /// An inner knot is repeated so often that the curve is interrupted.
    #[error(
        "knot {index} is repeated more than {degree} times, so that the curve is interrupted there"
    )]
    Interrupted {
        /// The index of the last repetition.
        index: usize,
        /// The degree.
        degree: usize,
    },
    /// All knots between which the curve lies are equal.
    #[error("the knots between which the curve lies are equal")]
    NoDomain,
}

/// Cubics end to end that approximate another curve.
#[derive(Clone, Debug, PartialEq)]
pub struct Cubics {
    /// The cubics, at least one.
    pub cubics: Vec<CubicBezier>,
    /// The largest measured distance between the curves in metres; 0 if the conversion is exact.
    pub error: f64,
}

impl Nurbs {
    /// Checks and returns a curve. `weights` is empty for a B-spline, else it has one weight for
    /// each point.
    ///
    /// # Errors
    /// If the arguments make no curve, or one that can't be converted.
    pub fn new(
        degree: usize,
        knots: Vec<f64>,
        points: &[DVec2],
        weights: &[f64],
    ) -> Result<Self, NurbsError> {
        check_counts(degree, knots.len(), points.len(), weights.len())?;
        check_points(points)?;
        check_knots(degree, &knots)?;
        let largest = check_weights(weights)?;
        let weights = weights.iter().map(|weight| weight / largest).chain(std::iter::repeat(1.0));
        let points = points
            .iter()
            .zip(weights)
            .map(|(point, weight)| (*point * weight).extend(weight))
            .collect();
        Ok(Self { degree, knots, points })
    }

    /// Returns the parameters between which the curve lies.
    pub fn domain(&self) -> [f64; 2] {
        [self.knots[self.degree], self.knots[self.points.len()]]
    }

    /// Returns the point at a parameter of the domain, in metres, by de Boor's algorithm.
    pub fn position(&self, parameter: f64) -> DVec2 {
        let [start, end] = self.domain();
        let parameter = parameter.clamp(start, end);
        let after = self.knots.partition_point(|knot| *knot <= parameter);
        // At the end of the domain, the span is the last one with an extent.
        let last = self.knots.partition_point(|knot| *knot < end);
        let span = after.min(last).max(self.degree + 1) - 1;
        project(self.blossom(span, &[parameter; MAX_DEGREE][..self.degree]))
    }

    /// Returns cubics along the curve. A knot whose multiplicity is the degree is a corner, and
    /// stays one.
    pub fn to_cubics(&self) -> Cubics {
        let mut result = Cubics { cubics: Vec::new(), error: 0.0 };
        for span in self.degree..self.points.len() {
            if self.knots[span] < self.knots[span + 1] {
                result.add(&self.bezier(span));
            }
        }
        result.finish()
    }

    /// Returns the Bézier curve between two knots. Its control points are the values of the blossom
    /// at the two knots, which equals knot insertion.
    fn bezier(&self, span: usize) -> RationalBezier {
        let (from, to) = (self.knots[span], self.knots[span + 1]);
        let mut parameters = [from; MAX_DEGREE];
        let mut points = Vec::with_capacity(self.degree + 1);
        for index in 0..=self.degree {
            points.push(self.blossom(span, &parameters[..self.degree]));
            if let Some(parameter) = parameters.get_mut(index) {
                *parameter = to;
            }
        }
        RationalBezier(points)
    }

    /// Evaluates the blossom (polar form) of the polynomial between the knots `span` and `span +
    /// 1`: with equal parameters this is de Boor's algorithm.
    fn blossom(&self, span: usize, parameters: &[f64]) -> DVec3 {
        let degree = self.degree;
        let mut points = [DVec3::ZERO; MAX_DEGREE + 1];
        points[..=degree].copy_from_slice(&self.points[span - degree..=span]);
        for (step, parameter) in (1..=degree).zip(parameters) {
            for index in (step..=degree).rev() {
                let (low, high) =
                    (self.knots[span - degree + index], self.knots[span + 1 + index - step]);
                points[index] =
                    points[index - 1].lerp(points[index], (parameter - low) / (high - low));
            }
        }
        points[degree]
    }
}

/// Converts a single Bézier curve with 2 to 6 control points, in metres.
///
/// # Errors
/// If the number of points or a coordinate is out of range.
pub fn bezier_to_cubics(points: &[DVec2]) -> Result<Cubics, NurbsError> {
    let degree = points.len().saturating_sub(1);
    if !(1..=MAX_DEGREE).contains(&degree) {
        return Err(NurbsError::Degree(degree));
    }
    check_points(points)?;
    let mut result = Cubics { cubics: Vec::new(), error: 0.0 };
    result.add(&RationalBezier(points.iter().map(|point| point.extend(1.0)).collect()));
    Ok(result.finish())
}

impl Cubics {
    /// Appends a piece.
    fn add(&mut self, piece: &RationalBezier) {
        match piece.to_cubic() {
            Some(cubic) => self.cubics.push(cubic),
            None => self.error = self.error.max(fit(piece, &mut self.cubics, MAX_FITTED)),
        }
    }

    /// Removes pieces without extent, such as those between equal control points, and makes the
    /// others meet exactly.
    fn finish(mut self) -> Self {
        let first = self.cubics.first().copied();
        self.cubics.retain(|cubic| extent(cubic) > NEGLIGIBLE_EXTENT);
        if self.cubics.is_empty() {
            self.cubics.extend(first);
        }
        for index in 1..self.cubics.len() {
            self.cubics[index].control_points[0] = self.cubics[index - 1].control_points[3];
        }
        self
    }
}

/// Returns the point of homogeneous coordinates.
fn project(point: DVec3) -> DVec2 {
    point.truncate() / point.z
}

fn extent(cubic: &CubicBezier) -> f64 {
    let [start, others @ ..] = cubic.control_points;
    others.into_iter().map(|point| point.distance(start)).fold(0.0, f64::max)
}

fn check_counts(
    degree: usize,
    knots: usize,
    points: usize,
    weights: usize,
) -> Result<(), NurbsError> {
    if !(1..=MAX_DEGREE).contains(&degree) {
        return Err(NurbsError::Degree(degree));
    }
    if points <= degree {
        return Err(NurbsError::TooFewPoints { points, degree });
    }
    if points > MAX_POINTS {
        return Err(NurbsError::TooManyPoints(points));
    }
    if knots != points + degree + 1 {
        return Err(NurbsError::KnotCount { found: knots, expected: points + degree + 1 });
    }
    if weights != 0 && weights != points {
        return Err(NurbsError::WeightCount { found: weights, points });
    }
    Ok(())
}

fn check_points(points: &[DVec2]) -> Result<(), NurbsError> {
    for (index, point) in points.iter().enumerate() {
        if !point.is_finite() || point.abs().max_element() > MAX_COORDINATE {
            return Err(NurbsError::Point(index));
        }
    }
    Ok(())
}

fn check_knots(degree: usize, knots: &[f64]) -> Result<(), NurbsError> {
    // Differences of knots must be finite too.
    if let Some(index) = knots.iter().position(|knot| knot.is_nan() || knot.abs() > f64::MAX / 4.0)
    {
        return Err(NurbsError::KnotOrder(index));
    }
    if let Some(index) = knots.windows(2).position(|pair| pair[1] < pair[0]) {
        return Err(NurbsError::KnotOrder(index + 1));
    }
    let (start, end) = (knots[degree], knots[knots.len() - 1 - degree]);
    if start >= end {
        return Err(NurbsError::NoDomain);
    }
    for (index, window) in knots.windows(degree + 1).enumerate() {
        if window[0] == window[degree] && window[0] > start && window[0] < end {
            return Err(NurbsError::Interrupted { index: index + degree, degree });
        }
    }
    Ok(())
}

/// Returns the largest weight.
fn check_weights(weights: &[f64]) -> Result<f64, NurbsError> {
    let largest = weights.iter().copied().fold(0.0, f64::max);
    for (index, &weight) in weights.iter().enumerate() {
        if !weight.is_finite() || weight <= 0.0 || weight * MAX_WEIGHT_RATIO < largest {
            return Err(NurbsError::Weight(index));
        }
    }
    Ok(largest)
}
