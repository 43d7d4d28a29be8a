//! A radix sort of packed keys, which is what most of a frame's sorting needs: the keys are nearly random, and few of
//! their bits count.

use std::ops::Range;

/// Widest digit: its buckets' ends of written memory stay in the second-level cache.
const DIGIT_BITS: u32 = 11;

/// Sorts by these bits of the keys alone; keys that are equal there stay in their order. `scratch` is memory for it.
pub(crate) fn sort(keys: &mut Vec<u64>, scratch: &mut Vec<u64>, bits: Range<u32>) {
    let passes = bits.len().div_ceil(DIGIT_BITS as usize) as u32;
    if keys.len() < 2 || passes == 0 {
        return;
    }
    scratch.resize(keys.len(), 0);
    let width = (bits.len() as u32).div_ceil(passes);
    for shift in bits.clone().step_by(width as usize) {
        pass(keys, scratch, shift, width.min(bits.end - shift));
        std::mem::swap(keys, scratch);
    }
}

fn pass(from: &[u64], to: &mut [u64], shift: u32, width: u32) {
    let mut places = [0_u32; 1 << DIGIT_BITS];
    let digit = |key: u64| (key >> shift) as usize & ((1 << width) - 1);
    for &key in from {
        places[digit(key)] += 1;
    }
    let mut place = 0;
    for bucket in &mut places[..1 << width] {
        (place, *bucket) = (place + *bucket, place);
    }
    for &key in from {
        let bucket = &mut places[digit(key)];
        to[*bucket as usize] = key;
        *bucket += 1;
    }
}

/// How many bits hold the numbers below `count`.
pub(crate) fn bits_below(count: usize) -> u32 {
    count.saturating_sub(1).checked_ilog2().map_or(0, |log| log + 1)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn keys_are_sorted_by_the_bits_asked_for(
            keys in prop::collection::vec(any::<u64>(), 0..500),
            (start, end) in (0_u32..=64).prop_flat_map(|start| (Just(start), start..=64)),
        ) {
            let part = |key: &u64| (u128::from(*key) & ((1 << end) - 1)) >> start;
            let (mut sorted, mut expected) = (keys.clone(), keys);
            sort(&mut sorted, &mut Vec::new(), start..end);
            expected.sort_by_key(part);
            prop_assert_eq!(sorted, expected);
        }
    }

    #[test]
    fn bits_are_counted() {
        assert_eq!([0, 1, 2, 3, 4, 5, 1 << 20].map(bits_below), [0, 0, 1, 2, 2, 3, 20]);
    }
}
