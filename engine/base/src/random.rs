//! Random numbers by counter: a value depends on a seed and on the purpose of the draw, and on
//! nothing that was drawn before, so that the order of draws and threads has no influence.

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
    (bits >> 11) as f64 / (1u64 << 53) as f64
}
