//! The natural logarithm with the same bits on every machine: the one of the standard library is
//! that of the system.

use std::f64::consts::LN_2;

/// Returns ln x for a normal x > 0, with a relative error of some 1e-15.
///
/// ```
/// assert_eq!(regatta_base::ln(1.0), 0.0);
/// ```
pub fn ln(x: f64) -> f64 {
    const MANTISSA: u64 = (1 << 52) - 1;
    let bits = x.to_bits();
    let exponent = (bits >> 52) as i64 - 1023;
    let m = f64::from_bits(bits & MANTISSA | 1023 << 52);
    // ln m = 2 artanh t for m in [1, 2), so that t is at most 1/3.
    let t = (m - 1.0) / (m + 1.0);
    let square = t * t;
    let series = (0..18).rev().fold(0.0, |sum, k| sum * square + 1.0 / f64::from(2 * k + 1));
    exponent as f64 * LN_2 + 2.0 * t * series
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_the_logarithm() {
        for x in [1.0, 0.5, 1e-9, 2.0, 3.7, 1.999_999, 1e17, 0.999_999_9] {
            let (found, exact) = (ln(x), f64::ln(x));
            assert!(
                (found - exact).abs() <= 1e-14 * exact.abs().max(1.0),
                "ln {x}: {found}, not {exact}"
            );
        }
    }
}
