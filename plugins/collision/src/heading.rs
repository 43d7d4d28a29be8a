//! Vectorizable cosine and sine.

use std::f32::consts::FRAC_2_PI;

use glam::Vec2;

/// The largest valid heading, in radians. Headings of the contract are in (-π, π].
pub const MAX_HEADING: f32 = 1000.0;

/// Adding and subtracting it rounds to an integer, which is then in the lowest bits of the
/// mantissa: 1.5 · 2²³.
const ROUND: f32 = 12_582_912.0;

/// π/2 in three parts (Cody and Waite). The first two have spare bits, so that their multiples are
/// exact.
const QUARTER: [f32; 3] = [1.570_312_5, 4.837_513e-4, 7.549_79e-8];

/// Returns the cosine and sine of an angle up to [`MAX_HEADING`], to 2·10⁻⁷: polynomials on (-π/4,
/// π/4) as in Moshier's Cephes library, and the symmetries of the circle. No branches and no calls,
/// so that the compiler vectorizes it.
#[inline(always)]
pub(crate) fn heading(angle: f32) -> Vec2 {
    let shifted = angle * FRAC_2_PI + ROUND;
    let (quarters, whole) = (shifted.to_bits(), shifted - ROUND);
    let rest = ((angle - whole * QUARTER[0]) - whole * QUARTER[1]) - whole * QUARTER[2];
    let square = rest * rest;
    let sin = rest
        + rest * square * (-1.666_665_5e-1 + square * (8.332_161e-3 - square * 1.951_529_6e-4));
    let cos = 1.0 - 0.5 * square
        + square * square * (4.166_664_6e-2 + square * (-1.388_731_6e-3 + square * 2.443_315_7e-5));
    let swapped = quarters & 1 != 0;
    let (cos, sin) = if swapped { (sin, cos) } else { (cos, sin) };
    Vec2::new(negate_if(quarters.wrapping_add(1), cos), negate_if(quarters, sin))
}

/// Negates a value if the second lowest bit of `quarters` is set.
#[inline(always)]
fn negate_if(quarters: u32, value: f32) -> f32 {
    f32::from_bits(value.to_bits() ^ ((quarters & 2) << 30))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn cosine_and_sine_are_exact(angle in -MAX_HEADING..MAX_HEADING) {
            let Vec2 { x: cos, y: sin } = heading(angle);
            let exact = f64::from(angle).sin_cos();
            prop_assert!((f64::from(sin) - exact.0).abs() < 2e-7, "{sin} {}", exact.0);
            prop_assert!((f64::from(cos) - exact.1).abs() < 2e-7, "{cos} {}", exact.1);
        }
    }

    #[test]
    fn right_angles_are_exact_up_to_rounding() {
        use std::f32::consts::{FRAC_PI_2, PI};
        for (angle, cos, sin) in
            [(0.0, 1.0, 0.0), (FRAC_PI_2, 0.0, 1.0), (PI, -1.0, 0.0), (-FRAC_PI_2, 0.0, -1.0)]
        {
            let found = heading(angle);
            assert!(
                (found.x - cos).abs() < 1e-7 && (found.y - sin).abs() < 1e-7,
                "{angle}: {found:?}"
            );
        }
    }
}
