//! Cubic Bézier curves as sweeps sample them. One rule of fixed order measures their length:
//! stretches are shorter than a decimetre, so that it is exact there, and much faster than the
//! adaptive one of [`bezier`](crate::bezier).

use glam::DVec2;

/// A cubic Bézier curve in double precision.
#[derive(Clone, Copy, Debug)]
pub struct Cubic([DVec2; 4]);

/// Abscissas and weights of the five-point Gauss–Legendre rule on [-1, 1].
const GAUSS: [(f64, f64); 5] = [
    (0.0, 0.568_888_888_888_888_9),
    (-0.538_469_310_105_683_1, 0.478_628_670_499_366_5),
    (0.538_469_310_105_683_1, 0.478_628_670_499_366_5),
    (-0.906_179_845_938_664, 0.236_926_885_056_189_1),
    (0.906_179_845_938_664, 0.236_926_885_056_189_1),
];

impl Cubic {
    /// Takes the control points of a curve, in metres.
    pub fn new(control_points: [DVec2; 4]) -> Self {
        Self(control_points)
    }

    /// The point at a parameter in 0 to 1.
    pub fn point(&self, t: f64) -> DVec2 {
        let (u, [p0, p1, p2, p3]) = (1.0 - t, self.0);
        p0 * (u * u * u) + p1 * (3.0 * u * u * t) + p2 * (3.0 * u * t * t) + p3 * (t * t * t)
    }

    /// The derivative at a parameter. Where it vanishes (a handle of length zero), the direction of
    /// the chord from there.
    pub fn tangent(&self, t: f64) -> DVec2 {
        let derivative = self.derivative(t);
        if derivative.x.hypot(derivative.y) > 1e-9 {
            return derivative;
        }
        let (near, far) = if t < 0.5 { (t, t + 1e-4) } else { (t - 1e-4, t) };
        self.point(far) - self.point(near)
    }

    /// The arc length between two parameters, in metres.
    pub fn length(&self, from: f64, to: f64) -> f64 {
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
        let speeds = GAUSS
            .map(|(abscissa, weight)| weight * self.derivative(middle + half * abscissa).length());
        half * speeds.iter().sum::<f64>()
    }

    fn derivative(&self, t: f64) -> DVec2 {
        let (u, [p0, p1, p2, p3]) = (1.0 - t, self.0);
        ((p1 - p0) * (u * u) + (p2 - p1) * (2.0 * u * t) + (p3 - p2) * (t * t)) * 3.0
    }
}
