//! The numbers of vehicles that are tried, one after the other.

use std::collections::BTreeMap;

use super::Verdict;
use crate::plan::Robots;

/// Returns the next number of vehicles; `None` if the answer is there.
///
/// A list is tried as it is. A range is doubled until the master fails. Then the distance to the
/// largest number below is halved until it is at most `resolution` of that. A number without a
/// verdict ends the search: larger ones would have none either.
pub fn next(vehicles: &Robots, resolution: f64, known: &BTreeMap<u32, Verdict>) -> Option<u32> {
    let grid = vehicles.grid();
    if !vehicles.is_refined() {
        return grid.into_iter().find(|number| !known.contains_key(number));
    }
    if known.values().any(|verdict| *verdict == Verdict::Unknown) {
        return None;
    }
    let Some(fails) = first_failure(known) else {
        return grid.into_iter().find(|number| !known.contains_key(number));
    };
    let copes = known.range(..fails).next_back().map(|(number, _)| *number)?;
    let step = (f64::from(copes) * resolution).floor().max(1.0) as u32;
    (fails - copes > step).then_some(copes + (fails - copes) / 2)
}

/// The least number of vehicles with which the master fails.
pub fn first_failure(known: &BTreeMap<u32, Verdict>) -> Option<u32> {
    known.iter().find(|(_, verdict)| **verdict == Verdict::Fails).map(|(number, _)| *number)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tries a master of a capacity, and returns the numbers in their order.
    fn tried(vehicles: &str, capacity: u32) -> Vec<u32> {
        let vehicles: Robots = vehicles.parse().expect("numbers");
        let (mut known, mut tried) = (BTreeMap::new(), Vec::new());
        while let Some(number) = next(&vehicles, 0.06, &known) {
            let verdict = if number <= capacity { Verdict::Copes } else { Verdict::Fails };
            assert_eq!(known.insert(number, verdict), None, "{number} is tried twice");
            tried.push(number);
        }
        tried
    }

    #[test]
    fn a_range_is_doubled_and_then_halved() {
        assert_eq!(tried("1..1000", 140), [1, 2, 4, 8, 16, 32, 64, 128, 256, 192, 160, 144, 136]);
        assert_eq!(tried("1..8", 100), [1, 2, 4, 8]);
        assert_eq!(tried("4..8", 3), [4]);
        assert_eq!(tried("4..16", 10), [4, 8, 16, 12, 10, 11]);
    }

    #[test]
    fn a_list_is_tried_as_it_is_and_an_unknown_number_ends_a_range() {
        assert_eq!(tried("10,20,40", 10), [10, 20, 40]);
        let known = BTreeMap::from([(1, Verdict::Copes), (2, Verdict::Unknown)]);
        assert_eq!(next(&"1..8".parse().expect("numbers"), 0.06, &known), None);
    }
}
