//! Numbers as text with a fixed count of decimals: what `format!("{value:.3}")` writes, ten times as fast.

use std::io::Write as _;

/// Most decimals that can be asked for. An `f32` times ten to this power is exact in an `f64`, and so the rounding
/// is too.
pub const MAX_DECIMALS: usize = 9;

const POWERS: [f64; MAX_DECIMALS + 1] = [1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9];
/// Scaled values from here on don't surely fit the integer.
const LIMIT: f64 = 1e18;

/// Appends `value` with so many decimals, rounded to the nearest; byte for byte as `format!("{value:.decimals$}")`.
///
/// # Panics
/// If `decimals` is over [`MAX_DECIMALS`].
pub fn write(out: &mut Vec<u8>, value: f32, decimals: usize) {
    let scaled = (f64::from(value).abs() * POWERS[decimals]).round_ties_even();
    if scaled.is_nan() || scaled >= LIMIT {
        return write_slowly(out, value, decimals);
    }
    if value.is_sign_negative() {
        out.push(b'-');
    }
    let mut buffer = itoa::Buffer::new();
    let digits = buffer.format(scaled as u64).as_bytes();
    let whole = digits.len().saturating_sub(decimals);
    out.extend_from_slice(if whole == 0 { b"0" } else { &digits[..whole] });
    if decimals > 0 {
        out.push(b'.');
        out.extend_from_slice(&b"000000000"[..decimals.saturating_sub(digits.len())]);
        out.extend_from_slice(&digits[whole..]);
    }
}

/// For what no robot's coordinate should be.
#[cold]
fn write_slowly(out: &mut Vec<u8>, value: f32, decimals: usize) {
    // Writing to a vector can't fail.
    let _ = write!(out, "{value:.decimals$}");
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn written(value: f32, decimals: usize) -> String {
        let mut out = Vec::new();
        write(&mut out, value, decimals);
        String::from_utf8(out).expect("digits")
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(20_000))]

        #[test]
        fn any_bits_are_written_as_the_standard_library_does(bits: u32, decimals in 0..=MAX_DECIMALS) {
            let value = f32::from_bits(bits);
            prop_assert_eq!(written(value, decimals), format!("{value:.decimals$}"));
        }

        #[test]
        fn coordinates_are_written_as_the_standard_library_does(
            value in -20_000.0_f32..20_000.0, decimals in 0..=MAX_DECIMALS
        ) {
            prop_assert_eq!(written(value, decimals), format!("{value:.decimals$}"));
        }

        /// Odd multiples of a power of two: the values that lie exactly between two decimals are among them.
        #[test]
        fn ties_are_rounded_as_the_standard_library_does(
            odd in -4_000_i32..4_000, halvings in 0_i32..12, decimals in 0..=MAX_DECIMALS
        ) {
            let value = odd as f32 * (-halvings as f32).exp2();
            prop_assert_eq!(written(value, decimals), format!("{value:.decimals$}"));
        }
    }

    #[test]
    fn small_and_negative_values_have_all_their_zeros() {
        assert_eq!(written(0.004, 3), "0.004");
        assert_eq!(written(-0.000_1, 3), "-0.000");
        assert_eq!(written(-12.5, 1), "-12.5");
        assert_eq!(written(999.999_9, 3), "1000.000");
        assert_eq!(written(7.0, 0), "7");
    }
}
