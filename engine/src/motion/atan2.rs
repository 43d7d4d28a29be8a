//! The heading of a direction: atan2 by a polynomial, without branches.
//!
//! With t = min(|x|, |y|) / max(|x|, |y|) in [0, 1], atan t = t · P(t²) to within 2.5·10⁻⁷, where P has degree 6
//! (odd minimax polynomial on [0, 1]); the other seven octants follow by symmetry. Evaluated in `f32` the whole is
//! within 10⁻⁶ rad of the truth.

use std::f32::consts::{FRAC_PI_2, PI};

/// Coefficients of P, from t⁰ to t¹².
pub(super) const COEFFICIENTS: [f32; 7] =
    [0.999_996_1, -0.333_173_7, 0.198_078_16, -0.132_333_43, 0.079_623_67, -0.033_604_22, 0.006_811_793_4];

/// Angle of (x, y) in radians, in (-π, π]: -π itself never occurs. 0 for the zero vector.
///
/// The vector kernels do the same operations in the same order.
pub(super) fn atan2(y: f32, x: f32) -> f32 {
    let (ax, ay) = (x.abs(), y.abs());
    let t = ax.min(ay) / ax.max(ay).max(f32::MIN_POSITIVE);
    let u = t * t;
    let [rest @ .., last] = COEFFICIENTS;
    let p = rest.iter().rev().fold(last, |p, &c| p * u + c);
    let octant = p * t;
    let quadrant = if ax < ay { FRAC_PI_2 - octant } else { octant };
    let half = if x < 0.0 { PI - quadrant } else { quadrant };
    let whole = if y < 0.0 { -half } else { half };
    if -PI < whole { whole } else { PI }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_close_to_the_truth_all_around() {
        for i in -100_000..=100_000 {
            let angle = f64::from(i) * std::f64::consts::PI / 100_000.0;
            let (y, x) = ((0.7 * angle.sin()) as f32, (0.7 * angle.cos()) as f32);
            let error = f64::from(atan2(y, x)) - f64::from(y).atan2(f64::from(x));
            let error = error - std::f64::consts::TAU * (error / std::f64::consts::TAU).round();
            assert!(error.abs() <= 1e-6, "{error} at {angle}");
        }
    }

    #[test]
    fn its_range_is_half_open() {
        for y in [0.0, -0.0, -f32::MIN_POSITIVE, -1e-20, -1e-8] {
            assert_eq!(atan2(y, -1.0), PI, "{y:e}");
        }
        assert!(atan2(-1e-6, -1.0) > -PI);
        assert_eq!(atan2(1.0, 0.0), FRAC_PI_2);
        assert_eq!(atan2(-1.0, -0.0), -FRAC_PI_2);
        assert_eq!(atan2(0.0, 0.0), 0.0);
        assert_eq!(atan2(0.0, 1.0).to_bits(), 0);
    }
}
