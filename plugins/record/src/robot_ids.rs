//! Lists of robots' ids on a command line.

use std::ops::RangeInclusive;
use std::str::FromStr;

/// A set of robots' ids: `1,5,7..9` contains 1, 5, 7, 8 and 9.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RobotIds {
    /// The ranges in ascending order, without overlaps.
    ranges: Vec<RangeInclusive<u32>>,
}

impl RobotIds {
    /// Returns the set of all ids.
    pub fn all() -> Self {
        Self { ranges: vec![0..=u32::MAX] }
    }

    /// Returns the ids below `robots` in ascending order.
    pub fn below(&self, robots: usize) -> impl Iterator<Item = usize> {
        let clip = move |range: &RangeInclusive<u32>| {
            *range.start() as usize..(*range.end() as usize + 1).min(robots)
        };
        self.ranges.iter().flat_map(clip)
    }

    /// Whether an id is in the set.
    pub fn contains(&self, robot: u32) -> bool {
        self.ranges.iter().any(|range| range.contains(&robot))
    }

    /// Returns the lowest id, or `None` if the set is empty.
    pub fn first(&self) -> Option<u32> {
        self.ranges.first().map(|range| *range.start())
    }
}

impl FromStr for RobotIds {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let mut ranges = text.split(',').map(range).collect::<Option<Vec<_>>>().ok_or_else(|| {
            format!("invalid list of robots '{text}'; give ids and ranges with both ends, for example 1,5,7..9")
        })?;
        ranges.sort_by_key(|range| *range.start());
        let mut merged: Vec<RangeInclusive<u32>> = Vec::new();
        for range in ranges {
            match merged.last_mut() {
                Some(last) if *range.start() <= last.end().saturating_add(1) => {
                    *last = *last.start()..=*last.end().max(range.end());
                }
                _ => merged.push(range),
            }
        }
        Ok(Self { ranges: merged })
    }
}

fn range(text: &str) -> Option<RangeInclusive<u32>> {
    let (first, last) = text.split_once("..").unwrap_or((text, text));
    let (first, last) = (first.trim().parse().ok()?, last.trim().parse().ok()?);
    (first <= last).then_some(first..=last)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn listed(text: &str, robots: usize) -> Vec<usize> {
        text.parse::<RobotIds>().unwrap().below(robots).collect()
    }

    #[test]
    fn each_id_occurs_once_and_in_order() {
        assert_eq!(listed("1,5,7..9", 100), [1, 5, 7, 8, 9]);
        assert_eq!(listed("9,3..6, 5..7,1", 7), [1, 3, 4, 5, 6]);
        assert_eq!(listed("4294967295,0", 1), [0]);
        let ids: RobotIds = "1,5,7..9".parse().unwrap();
        assert_eq!(
            (0..12).filter(|robot| ids.contains(*robot)).collect::<Vec<_>>(),
            [1, 5, 7, 8, 9]
        );
        assert_eq!(RobotIds::all().below(3).collect::<Vec<_>>(), [0, 1, 2]);
        for bad in ["", "a", "1,", "3..1", "-1", "1..", "..4", "4294967296"] {
            assert!(bad.parse::<RobotIds>().is_err(), "{bad:?}");
        }
    }
}
