//! Sets of numbers that are mostly consecutive: those of orders that are over.

use std::collections::BTreeMap;

/// The largest number of ranges that are kept.
const MOST_RANGES: usize = 1 << 16;

/// A set of numbers, as ranges. A long run needs no more room than a short one.
#[derive(Debug, Default)]
pub(crate) struct Numbers {
    /// The first number of each range, and its last one.
    ranges: BTreeMap<u64, u64>,
}

impl Numbers {
    pub fn contains(&self, number: u64) -> bool {
        self.ranges.range(..=number).next_back().is_some_and(|(_, last)| number <= *last)
    }

    /// Adds a number. If the ranges are too many, the lowest one is forgotten.
    pub fn add(&mut self, number: u64) {
        if self.contains(number) {
            return;
        }
        let before = number.checked_sub(1).and_then(|before| self.range_to(before));
        let after = number.checked_add(1).and_then(|after| self.ranges.remove(&after));
        self.ranges.insert(before.unwrap_or(number), after.unwrap_or(number));
        if self.ranges.len() > MOST_RANGES {
            self.ranges.pop_first();
        }
    }

    /// Returns the first number of the range that ends with a number.
    fn range_to(&self, last: u64) -> Option<u64> {
        let range = self.ranges.range(..=last).next_back();
        range.filter(|(_, end)| **end == last).map(|(first, _)| *first)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn consecutive_numbers_are_one_range_in_any_order() {
        let mut numbers = Numbers::default();
        for number in [5, 3, 4, 9, 0, 1, 5, u64::MAX, 2] {
            numbers.add(number);
        }
        assert_eq!(numbers.ranges, BTreeMap::from([(0, 5), (9, 9), (u64::MAX, u64::MAX)]));
        assert!([0, 3, 5, 9, u64::MAX].iter().all(|number| numbers.contains(*number)));
        assert!([6, 8, 10].iter().all(|number| !numbers.contains(*number)));
    }

    #[test]
    fn numbers_far_apart_have_a_bound() {
        let mut numbers = Numbers::default();
        for number in 0..2 * MOST_RANGES as u64 {
            numbers.add(2 * number);
        }
        assert_eq!(numbers.ranges.len(), MOST_RANGES);
        assert!(numbers.contains(4 * MOST_RANGES as u64 - 2) && !numbers.contains(0));
    }
}
