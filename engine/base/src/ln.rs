//! The natural logarithm with the same bits on every machine. That of the standard library differs
//! from system to system in the last bits, and runs must not.

/// Returns the natural logarithm of a positive, normal number, exact to some 1e-15. It uses basic
/// operations only.
///
/// ```
/// use regatta_base::ln;
///
/// assert_eq!(ln(1.0), 0.0);
/// assert!((ln(10.0) - 2.302585092994046).abs() < 1e-15);
/// ```
pub fn ln(x: f64) -> f64 {
    let bits = x.to_bits();
    let mut exponent = ((bits >> 52) & 0x7ff) as f64 - 1023.0;
    let mut mantissa = f64::from_bits((bits & ((1 << 52) - 1)) | (1023 << 52));
    if mantissa > std::f64::consts::SQRT_2 {
        mantissa *= 0.5;
        exponent += 1.0;
    }
    let ratio = (mantissa - 1.0) / (mantissa + 1.0);
    let square = ratio * ratio;
    // The series of 2 artanh: the ratio is at most 0.172, and so 12 terms have all bits.
    let series = (0..12).rev().fold(0.0, |sum, term| sum * square + 1.0 / f64::from(2 * term + 1));
    exponent * std::f64::consts::LN_2 + 2.0 * ratio * series
}

#[cfg(test)]
mod tests {
    use super::ln;

    #[test]
    fn it_is_the_logarithm_of_the_standard_library() {
        let steps = (1..10_000).map(f64::from);
        let values = steps.flat_map(|step| [step / 10_000.0, step * 1e-12, step * 1e5]);
        for value in values.chain([1.0, 0.5, 1e-9, 2.0, 1.999_999, 1e17, 0.999_999_9]) {
            let (ours, theirs) = (ln(value), value.ln());
            assert!(
                (ours - theirs).abs() <= 1e-14 * theirs.abs().max(1.0),
                "{value}: {ours} {theirs}"
            );
        }
    }
}
