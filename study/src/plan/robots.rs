//! The numbers of robots of a study.

use std::fmt;
use std::str::FromStr;

use regatta_base::thousands;
use serde::Deserialize;

/// The numbers of robots that are tried.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(try_from = "RobotsEntry")]
pub enum Robots {
    /// Doubling from the first to the last, then refined round the knee.
    Range(u32, u32),
    /// Just these, ascending.
    List(Vec<u32>),
}

/// The largest number of robots of a study.
const MAX_ROBOTS: u32 = 1_000_000;

impl Robots {
    /// The numbers that are tried first, ascending.
    pub fn grid(&self) -> Vec<u32> {
        match self {
            Self::List(list) => list.clone(),
            Self::Range(from, to) => {
                let doubling = std::iter::successors(Some(*from), |robots| robots.checked_mul(2));
                doubling.take_while(|robots| robots < to).chain([*to]).collect()
            }
        }
    }

    /// Whether numbers are added round the knee.
    pub fn is_refined(&self) -> bool {
        matches!(self, Self::Range(..))
    }
}

/// Returns a number of robots in words: `1 robot`, `5 robots`.
pub fn robots_in_words(robots: u32) -> String {
    format!("{} robot{}", thousands(robots.into()), if robots == 1 { "" } else { "s" })
}

/// The error of parsing [`Robots`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "invalid numbers of robots '{0}': give a range such as 1..500, or a list such as 10,50,200; 1 \
     to a million each"
)]
pub struct ParseRobotsError(String);

impl FromStr for Robots {
    type Err = ParseRobotsError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        parse(text).ok_or_else(|| ParseRobotsError(text.to_owned()))
    }
}

fn parse(text: &str) -> Option<Robots> {
    if let Some((from, to)) = text.split_once("..") {
        let (from, to) = (parse_number(from)?, parse_number(to)?);
        return (from <= to).then_some(Robots::Range(from, to));
    }
    let mut list: Vec<u32> = text.split(',').map(parse_number).collect::<Option<_>>()?;
    list.sort_unstable();
    list.dedup();
    Some(Robots::List(list))
}

fn parse_number(text: &str) -> Option<u32> {
    text.trim().parse().ok().filter(|number| (1..=MAX_ROBOTS).contains(number))
}

impl fmt::Display for Robots {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Range(from, to) => write!(f, "{from} to {to} robots"),
            Self::List(list) => {
                let list: Vec<_> = list.iter().map(u32::to_string).collect();
                write!(f, "{} robots", list.join(", "))
            }
        }
    }
}

/// The numbers of robots in a study file.
#[derive(Deserialize)]
#[serde(untagged, expecting = "give a range such as 1..500, or a list of numbers")]
enum RobotsEntry {
    Text(String),
    Number(u32),
    List(Vec<u32>),
}

impl TryFrom<RobotsEntry> for Robots {
    type Error = ParseRobotsError;

    fn try_from(entry: RobotsEntry) -> Result<Self, Self::Error> {
        let numbers = match entry {
            RobotsEntry::Text(text) => return text.parse(),
            RobotsEntry::Number(number) => vec![number],
            RobotsEntry::List(numbers) => numbers,
        };
        numbers.iter().map(u32::to_string).collect::<Vec<_>>().join(",").parse()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_range_doubles_up_to_its_end() {
        let grid = |text: &str| text.parse::<Robots>().expect("robots").grid();
        assert_eq!(grid("1..10"), [1, 2, 4, 8, 10]);
        assert_eq!(grid("10..500"), [10, 20, 40, 80, 160, 320, 500]);
        assert_eq!(
            (grid("8..8"), grid("4..8"), grid("30,10,30")),
            (vec![8], vec![4, 8], vec![10, 30])
        );
    }

    #[test]
    fn wrong_numbers_are_refused() {
        for text in ["", "0", "5..1", "0..4", "1..", "-3", "1,,2", "2000000", "a..b", "1...5"] {
            assert_eq!(text.parse::<Robots>(), Err(ParseRobotsError(text.to_owned())));
        }
    }
}
