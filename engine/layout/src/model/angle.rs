//! Angles, with the same bits on every machine.

use std::f64::consts::{FRAC_2_PI, PI};

use glam::DVec2;

/// π/2 as a sum of two terms; the first has so few significant bits that its small multiples are
/// exact.
const HALF_PI: [f64; 2] = [1.570_796_326_734_125_6, 6.077_100_506_506_192e-11];

/// Returns the equivalent angle in (-π, π].
pub fn normalize_angle(angle: f64) -> f64 {
    if -PI < angle && angle <= PI {
        return angle;
    }
    let wrapped = angle - 2.0 * PI * (angle / (2.0 * PI)).round();
    if wrapped <= -PI { PI } else { wrapped.min(PI) }
}

/// Returns (cos, sin) of an angle in [-π, π], accurate to about one unit in the last place.
///
/// `f64::sin_cos` isn't used because the C library's results may differ between machines, which
/// would change every frame of a run.
pub fn unit(angle: f64) -> DVec2 {
    let quarter = (angle * FRAC_2_PI).round();
    let rest = (angle - quarter * HALF_PI[0]) - quarter * HALF_PI[1];
    let (cos, sin) = (small_cos(rest), small_sin(rest));
    match quarter as i64 & 3 {
        0 => DVec2::new(cos, sin),
        1 => DVec2::new(-sin, cos),
        2 => DVec2::new(-cos, -sin),
        _ => DVec2::new(sin, -cos),
    }
}

/// Evaluates sin on [-π/4, π/4] by fdlibm's minimax polynomial.
fn small_sin(x: f64) -> f64 {
    const S: [f64; 6] = [
        -1.666_666_666_666_663_2e-1,
        8.333_333_333_322_49e-3,
        -1.984_126_982_985_795e-4,
        2.755_731_370_707_006_8e-6,
        -2.505_076_025_340_686_4e-8,
        1.589_690_995_211_55e-10,
    ];
    let z = x * x;
    x + x * z * polynomial(S, z)
}

/// Evaluates cos on [-π/4, π/4] by fdlibm's minimax polynomial.
fn small_cos(x: f64) -> f64 {
    const C: [f64; 6] = [
        4.166_666_666_666_66e-2,
        -1.388_888_888_887_411e-3,
        2.480_158_728_947_673e-5,
        -2.755_731_435_139_066_3e-7,
        2.087_572_321_298_175e-9,
        -1.135_964_755_778_819_5e-11,
    ];
    let z = x * x;
    1.0 - (0.5 * z - z * z * polynomial(C, z))
}

fn polynomial(coefficients: [f64; 6], z: f64) -> f64 {
    coefficients.into_iter().rev().fold(0.0, |sum, coefficient| sum * z + coefficient)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn angles_are_normalized_to_the_half_open_interval() {
        assert_eq!(normalize_angle(PI), PI);
        assert_eq!(normalize_angle(-PI), PI);
        assert_eq!(normalize_angle(3.0 * PI), PI);
        assert_eq!(normalize_angle(-3.0 * PI), PI);
        assert_eq!(normalize_angle(0.25), 0.25);
        assert!((normalize_angle(0.25 + 2.0 * PI) - 0.25).abs() < 1e-12);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(if cfg!(miri) { 4 } else { 256 }))]

        #[test]
        fn unit_is_cosine_and_sine(angle in -PI..=PI) {
            let direction = unit(angle);
            prop_assert!((direction.x - angle.cos()).abs() < 3e-16, "{} {}", direction.x, angle.cos());
            prop_assert!((direction.y - angle.sin()).abs() < 3e-16, "{} {}", direction.y, angle.sin());
        }

        #[test]
        fn normalized_angles_are_in_range(angle in -1e4..1e4) {
            let normalized = normalize_angle(angle);
            prop_assert!(-PI < normalized && normalized <= PI);
            prop_assert!((normalized.cos() - angle.cos()).abs() < 1e-9);
        }
    }
}
