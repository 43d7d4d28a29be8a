//! Random numbers by counter: the value depends on the seed and on what it is for, and on nothing
//! that was drawn before.

/// Random numbers of a seed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Random {
    key: u64,
}

impl Random {
    pub(super) fn new(seed: u64) -> Self {
        Self { key: mix(seed) }
    }

    /// Returns the random numbers of a part: a generator, an order of it.
    pub(super) fn part(self, number: u64) -> Self {
        Self { key: mix(self.key ^ mix(number)) }
    }

    /// Returns a number in (0, 1].
    pub(super) fn unit(self, draw: u64) -> f64 {
        ((self.part(draw).key >> 11) + 1) as f64 * (-53_f64).exp2()
    }

    /// Returns a number below `count`, which is at least 1.
    pub(super) fn below(self, draw: u64, count: usize) -> usize {
        ((u128::from(self.part(draw).key) * count as u128) >> 64) as usize
    }

    /// Returns an exponentially distributed number with mean 1.
    pub(super) fn exponential(self, draw: u64) -> f64 {
        -logarithm(self.unit(draw))
    }
}

/// The finaliser of SplitMix64 (Steele, Lea, Flood: Fast splittable pseudorandom number generators,
/// 2014).
fn mix(value: u64) -> u64 {
    let value = value.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let value = (value ^ (value >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let value = (value ^ (value >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    value ^ (value >> 31)
}

/// Returns the natural logarithm of a positive, normal number. It has only basic operations,
/// because that of the standard library differs from system to system in the last bits, and runs
/// must not.
fn logarithm(value: f64) -> f64 {
    let bits = value.to_bits();
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
    use super::*;

    #[test]
    fn the_logarithm_is_that_of_the_standard_library() {
        for step in 1..10_000 {
            for value in
                [f64::from(step) / 10_000.0, f64::from(step) * 1e-12, f64::from(step) * 1e5]
            {
                let (ours, theirs) = (logarithm(value), value.ln());
                assert!(
                    (ours - theirs).abs() <= 1e-14 * theirs.abs().max(1.0),
                    "{value}: {ours} {theirs}"
                );
            }
        }
    }

    #[test]
    fn numbers_are_even_and_depend_on_the_counter_only() {
        let random = Random::new(7).part(3);
        let count = 100_000;
        let mean = (0..count).map(|draw| random.unit(draw)).sum::<f64>() / count as f64;
        assert!((mean - 0.5).abs() < 0.005, "{mean}");
        let mean = (0..count).map(|draw| random.exponential(draw)).sum::<f64>() / count as f64;
        assert!((mean - 1.0).abs() < 0.01, "{mean}");
        let mut counts = [0; 7];
        (0..count).for_each(|draw| counts[random.below(draw, 7)] += 1);
        assert!(counts.iter().all(|count| (13_500..15_100).contains(count)), "{counts:?}");
        assert_eq!(random.part(5).key, Random::new(7).part(3).part(5).key);
        assert_ne!(random.part(5).key, Random::new(8).part(3).part(5).key);
    }
}
