//! A radix sort for keys that are nearly random and of which few bits are significant.

use std::ops::Range;

/// The number of bits of the widest digit: the ends of all buckets stay in the first-level cache.
const DIGIT_BITS: u32 = 10;

/// Sorts by a range of bits of each item's key. The sort is stable. `scratch` is scratch memory.
pub(crate) fn sort<T: Copy>(
    items: &mut Vec<T>,
    scratch: &mut Vec<T>,
    bits: Range<u32>,
    key: impl Fn(&T) -> u64,
) {
    let passes = bits.len().div_ceil(DIGIT_BITS as usize) as u32;
    let (Some(&any), 1..) = (items.first(), passes) else { return };
    scratch.resize(items.len(), any);
    let width = (bits.len() as u32).div_ceil(passes);
    for shift in bits.clone().step_by(width as usize) {
        let buckets = 1 << width.min(bits.end - shift);
        pass(items, scratch, buckets, |item| (key(item) >> shift) as usize & (buckets - 1));
        std::mem::swap(items, scratch);
    }
}

fn pass<T: Copy>(from: &[T], to: &mut [T], buckets: usize, digit: impl Fn(&T) -> usize) {
    let mut offsets = [0_u32; 1 << DIGIT_BITS];
    let offsets = &mut offsets[..buckets];
    for item in from {
        offsets[digit(item)] += 1;
    }
    let mut start = 0;
    for bucket in &mut *offsets {
        (start, *bucket) = (start + *bucket, start);
    }
    for item in from {
        let bucket = &mut offsets[digit(item)];
        to[*bucket as usize] = *item;
        *bucket += 1;
    }
}

/// Returns the number of bits that hold all numbers below `count`.
pub(crate) fn bits_below(count: usize) -> u32 {
    count.saturating_sub(1).checked_ilog2().map_or(0, |log| log + 1)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn keys_are_sorted_by_the_given_bits(
            keys in prop::collection::vec(any::<u64>(), 0..500),
            (start, end) in (0_u32..=64).prop_flat_map(|start| (Just(start), start..=64)),
        ) {
            let part = |key: &u64| (u128::from(*key) & ((1 << end) - 1)) >> start;
            let (mut sorted, mut expected) = (keys.clone(), keys);
            sort(&mut sorted, &mut Vec::new(), start..end, |key| *key);
            expected.sort_by_key(part);
            prop_assert_eq!(sorted, expected);
        }
    }

    #[test]
    fn bits_are_counted() {
        assert_eq!([0, 1, 2, 3, 4, 5, 1 << 20].map(bits_below), [0, 0, 1, 2, 2, 3, 20]);
    }
}
