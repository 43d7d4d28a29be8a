//! The curves of an edge, by arc length.

use regatta_plugin::world::CurveRecord;

/// A cubic Bézier curve in double precision.
#[derive(Clone, Copy, Debug)]
pub struct Cubic([[f64; 2]; 4]);

/// Abscissas and weights of the five-point Gauss–Legendre rule on [-1, 1].
const GAUSS: [(f64, f64); 5] = [
    (0.0, 0.568_888_888_888_888_9),
    (-0.538_469_310_105_683_1, 0.478_628_670_499_366_5),
    (0.538_469_310_105_683_1, 0.478_628_670_499_366_5),
    (-0.906_179_845_938_664, 0.236_926_885_056_189_1),
    (0.906_179_845_938_664, 0.236_926_885_056_189_1),
];

impl Cubic {
    /// Takes a curve of the world.
    pub fn new(record: &CurveRecord) -> Self {
        Self(record.control_points.map(|point| point.map(f64::from)))
    }

    /// The point at a parameter in 0 to 1.
    pub fn point(&self, t: f64) -> [f64; 2] {
        let (u, p) = (1.0 - t, &self.0);
        [0, 1].map(|axis| {
            u * u * u * p[0][axis]
                + 3.0 * u * u * t * p[1][axis]
                + 3.0 * u * t * t * p[2][axis]
                + t * t * t * p[3][axis]
        })
    }

    /// The derivative at a parameter. Where it vanishes (a handle of length zero), the direction of
    /// the chord from there.
    pub fn tangent(&self, t: f64) -> [f64; 2] {
        let derivative = self.derivative(t);
        if derivative[0].hypot(derivative[1]) > 1e-9 {
            return derivative;
        }
        let (near, far) = if t < 0.5 { (t, t + 1e-4) } else { (t - 1e-4, t) };
        let (a, b) = (self.point(near), self.point(far));
        [b[0] - a[0], b[1] - a[1]]
    }

    /// The arc length between two parameters, in metres.
    pub fn length(&self, from: f64, to: f64) -> f64 {
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
        let speed = |t: f64| {
            let [x, y] = self.derivative(t);
            (x * x + y * y).sqrt()
        };
        half * GAUSS
            .iter()
            .map(|(abscissa, weight)| weight * speed(middle + half * abscissa))
            .sum::<f64>()
    }

    fn derivative(&self, t: f64) -> [f64; 2] {
        let (u, p) = (1.0 - t, &self.0);
        [0, 1].map(|axis| {
            3.0 * (u * u * (p[1][axis] - p[0][axis])
                + 2.0 * u * t * (p[2][axis] - p[1][axis])
                + t * t * (p[3][axis] - p[2][axis]))
        })
    }
}
