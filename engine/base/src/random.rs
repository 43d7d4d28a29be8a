//! Random numbers by counter: a value depends on a seed and on the purpose of the draw, and on
//! nothing that was drawn before, so that the order of draws and threads has no influence.

use crate::ln;

/// The random numbers of a seed.
///
/// ```
/// use regatta_base::random::Random;
///
/// let first = Random::new(7).part(1);
/// assert_eq!(first.below(0, 6), Random::new(7).part(1).below(0, 6));
/// assert!(first.unit(1) > 0.0 && first.unit(1) <= 1.0);
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Random {
    key: u64,
}

impl Random {
    /// Returns the random numbers of a seed.
    pub fn new(seed: u64) -> Self {
        Self { key: mix(seed) }
    }

    /// Returns the random numbers of a part: a generator, an order of it.
    pub fn part(self, number: u64) -> Self {
        Self { key: mix(self.key ^ mix(number)) }
    }

    /// Returns a number in (0, 1].
    pub fn unit(self, draw: u64) -> f64 {
        ((self.part(draw).key >> 11) + 1) as f64 * (-53_f64).exp2()
    }

    /// Returns an index below `count`, which is at least 1.
    pub fn below(self, draw: u64, count: usize) -> usize {
        ((u128::from(self.part(draw).key) * count as u128) >> 64) as usize
    }

    /// Returns an exponentially distributed number with mean 1.
    pub fn exponential(self, draw: u64) -> f64 {
        -ln(self.unit(draw))
    }
}

/// Returns random bits for any counter: the finaliser of SplitMix64 (Steele, Lea, Flood: Fast
/// splittable pseudorandom number generators, 2014), after one step of its sequence.
///
/// ```
/// use regatta_base::random::mix;
///
/// let (seed, robot) = (7, 42);
/// let bits = mix(seed ^ mix(robot));
/// assert_eq!(bits, mix(seed ^ mix(robot)));
/// assert_ne!(bits, mix(seed ^ mix(robot + 1)));
/// ```
pub const fn mix(counter: u64) -> u64 {
    let z = counter.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

/// Returns a number in [0, 1) made of the upper 53 bits.
pub const fn unit(bits: u64) -> f64 {
    (bits >> 11) as f64 / (1_u64 << 53) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

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
