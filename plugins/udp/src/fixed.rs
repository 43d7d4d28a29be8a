//! Writes numbers as text with a fixed number of decimals: the same text as
//! `format!("{value:.3}")`, ten times as fast.

use std::io::Write as _;

/// The largest number of decimals. The product of an `f32` and ten to this power is exact in an
/// `f64`, so that the rounding is exact too.
pub const MAX_DECIMALS: usize = 9;

const POWERS: [f64; MAX_DECIMALS + 1] = [1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9];
/// The scaled value from which on the result may not fit in a `u64`.
const LIMIT: f64 = 1e18;

/// Appends `value` with `decimals` decimals, rounded to the nearest: the same bytes as
/// `format!("{value:.decimals$}")`.
///
/// # Panics
/// Panics if `decimals` is greater than [`MAX_DECIMALS`].
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

/// Appends a value that is NaN or too large for the fast path; coordinates of robots never are.
#[cold]
fn write_slowly(out: &mut Vec<u8>, value: f32, decimals: usize) {
    // Writing to a vector never fails.
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

        /// Uses odd multiples of powers of two, which include values exactly halfway between two
        /// decimals.
        #[test]
        fn ties_are_rounded_as_the_standard_library_does(
            odd in -4_000_i32..4_000, halvings in 0_i32..12, decimals in 0..=MAX_DECIMALS
        ) {
            let value = odd as f32 * (-halvings as f32).exp2();
            prop_assert_eq!(written(value, decimals), format!("{value:.decimals$}"));
        }
    }

    #[test]
    fn small_and_negative_values_have_all_their_decimals() {
        assert_eq!(written(0.004, 3), "0.004");
        assert_eq!(written(-0.000_1, 3), "-0.000");
        assert_eq!(written(-12.5, 1), "-12.5");
        assert_eq!(written(999.999_9, 3), "1000.000");
        assert_eq!(written(7.0, 0), "7");
    }
}
