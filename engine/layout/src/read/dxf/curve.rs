//! The curves of drawings as cubics.

use std::f64::consts::{FRAC_PI_2, TAU};

use glam::DVec2;
use regatta_base::bezier::CubicBezier;

use crate::model::nurbs::Nurbs;

/// The largest distance in metres between a cubic and the arc that it approximates.
const MAX_ERROR: f64 = 1e-6;

/// The largest number of points of a spline.
const MAX_POINTS: usize = 100_000;

/// An arc of an ellipse: `centre + major cos t + minor sin t`.
#[derive(Clone, Copy, Debug)]
pub struct EllipticArc {
    pub centre: DVec2,
    pub major: DVec2,
    pub minor: DVec2,
    /// The first parameter in radians, and the last, which is larger unless the arc is clockwise.
    pub from: f64,
    pub to: f64,
}

impl EllipticArc {
    /// Returns the arc of a circle.
    pub fn circular(centre: DVec2, radius: f64, from: f64, to: f64) -> Self {
        Self { centre, major: DVec2::X * radius, minor: DVec2::Y * radius, from, to }
    }

    /// Returns the arc of a segment of a polyline: `bulge` is the tangent of a quarter of its
    /// angle.
    pub fn bulged(start: DVec2, end: DVec2, bulge: f64) -> Self {
        let angle = 4.0 * bulge.atan();
        let chord = end - start;
        let centre = start.midpoint(end) + chord.perp() * ((1.0 - bulge * bulge) / (4.0 * bulge));
        let from = (start - centre).to_angle();
        Self::circular(centre, centre.distance(start), from, from + angle)
    }

    fn point(&self, parameter: f64) -> DVec2 {
        self.centre + self.major * parameter.cos() + self.minor * parameter.sin()
    }

    fn derivative(&self, parameter: f64) -> DVec2 {
        self.minor * parameter.cos() - self.major * parameter.sin()
    }

    /// Returns cubics within [`MAX_ERROR`] of the arc, if its unit is `scale` metres.
    pub fn cubics(&self, scale: f64) -> Vec<CubicBezier> {
        let radius = self.major.length().max(self.minor.length()) * scale;
        let span = self.to - self.from;
        let mut count = (span.abs() / FRAC_PI_2).ceil().max(1.0) as u32;
        while error(radius, span / f64::from(count)) > MAX_ERROR && count < 64 {
            count += 1;
        }
        (0..count).map(|index| self.part(index, count)).map(|part| part.cubic()).collect()
    }

    /// Returns the parts within quarters of a turn, so that no part is closed.
    pub fn quarters(&self) -> impl Iterator<Item = Self> {
        let whole = *self;
        (0..4).map(move |quarter| whole.part(quarter, 4))
    }

    /// Returns one of `count` equal parts.
    fn part(&self, index: u32, count: u32) -> Self {
        let span = self.to - self.from;
        let [from, to] =
            [index, index + 1].map(|index| self.from + span * f64::from(index) / f64::from(count));
        Self { from, to, ..*self }
    }

    fn cubic(&self) -> CubicBezier {
        let handle = 4.0 / 3.0 * ((self.to - self.from) / 4.0).tan();
        let (start, end) = (self.point(self.from), self.point(self.to));
        let control_points = [
            start,
            start + self.derivative(self.from) * handle,
            end - self.derivative(self.to) * handle,
            end,
        ];
        CubicBezier { control_points }
    }
}

/// Returns the distance between an arc and its standard cubic: 4/27 · sin⁶(a/4) / cos²(a/4) of the
/// radius. The angle is in radians.
fn error(radius: f64, angle: f64) -> f64 {
    let (sin, cos) = (angle / 4.0).sin_cos();
    radius * 4.0 / 27.0 * sin.powi(6) / cos.powi(2)
}

/// Returns the counter-clockwise angle in radians, in (0, 2π], from one angle to another.
pub fn turn(from: f64, to: f64) -> f64 {
    let turn = (to - from).rem_euclid(TAU);
    if turn < 1e-12 { TAU } else { turn }
}

/// Returns the cubics of a spline in metres; `None` if it can't be read. `weights` is empty for a
/// B-spline.
pub fn spline_to_cubics(
    degree: usize,
    knots: &[f64],
    points: &[DVec2],
    weights: &[f64],
) -> Option<Vec<CubicBezier>> {
    if points.len() > MAX_POINTS {
        return None;
    }
    let curve = Nurbs::new(degree, knots.to_vec(), points, weights).ok()?;
    Some(curve.to_cubics().cubics)
}
