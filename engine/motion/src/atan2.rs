//! The heading of a direction: atan2 by a polynomial, without branches.
//!
//! With t = min(|x|, |y|) / max(|x|, |y|) in [0, 1], atan t = t · P(t²) to within 2.5·10⁻⁷, where P
//! has degree 6 (odd minimax polynomial on [0, 1]); the other seven octants follow by symmetry.
//! Evaluated in `f32` the whole is within 10⁻⁶ rad of the exact angle. P is summed in pairs
//! (Estrin's scheme), which a processor can evaluate in parallel.

use std::f32::consts::{FRAC_PI_2, PI};

/// The largest `f32` below π. Headings that round to -π become minus this.
pub(super) const BELOW_PI: f32 = PI.next_down();

/// Coefficients of P, from t⁰ to t¹².
pub(super) const COEFFICIENTS: [f32; 7] = [
    0.999_996_1,
    -0.333_173_7,
    0.198_078_16,
    -0.132_333_43,
    0.079_623_67,
    -0.033_604_22,
    0.006_811_793_4,
];

/// Lower bound of t in P(t²), which is 1 to the last bit at this t already. Powers of smaller t
/// would be denormal numbers, which are slow.
pub(super) const LEAST: f32 = 1.0 / (1 << 15) as f32;

/// Returns the angle of (x, y) in radians, in (-π, π]; 0 for the zero vector.
///
/// The vector kernels do the same operations in the same order.
pub(super) fn atan2(y: f32, x: f32) -> f32 {
    let (ax, ay) = (x.abs(), y.abs());
    let t = ax.min(ay) / ax.max(ay).max(f32::MIN_POSITIVE);
    let u = t.max(LEAST) * t.max(LEAST);
    let v = u * u;
    let [c0, c1, c2, c3, c4, c5, c6] = COEFFICIENTS;
    let low = (c0 + c1 * u) + v * (c2 + c3 * u);
    let high = (c4 + c5 * u) + v * c6;
    let octant = (low + (v * v) * high) * t;
    let quadrant = if ax < ay { FRAC_PI_2 - octant } else { octant };
    let half = if x < 0.0 { PI - quadrant } else { quadrant };
    let whole = if y < 0.0 { -half } else { half };
    whole.max(-BELOW_PI)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_error_is_below_a_microradian_at_every_angle() {
        for i in -100_000..=100_000 {
            let angle = f64::from(i) * std::f64::consts::PI / 100_000.0;
            let (y, x) = ((0.7 * angle.sin()) as f32, (0.7 * angle.cos()) as f32);
            let error = f64::from(atan2(y, x)) - f64::from(y).atan2(f64::from(x));
            let error = error - std::f64::consts::TAU * (error / std::f64::consts::TAU).round();
            assert!(error.abs() <= 1e-6, "{error} at {angle}");
        }
    }

    #[test]
    fn the_range_is_half_open() {
        assert_eq!([atan2(0.0, -1.0), atan2(-0.0, -1.0)], [PI, PI]);
        for y in [-f32::MIN_POSITIVE, -1e-20, -1e-8, -1e-7] {
            assert_eq!(atan2(y, -1.0), -BELOW_PI, "{y:e}");
        }
        assert!(f64::from(BELOW_PI) < std::f64::consts::PI);
        assert_eq!(atan2(1.0, 0.0), FRAC_PI_2);
        assert_eq!(atan2(-1.0, -0.0), -FRAC_PI_2);
        assert_eq!(atan2(0.0, 0.0), 0.0);
        assert_eq!(atan2(0.0, 1.0).to_bits(), 0);
    }
}
