//! Options and parsers that both command lines share.

use std::ops::Range;
use std::str::FromStr;

use crate::fixed::MAX_DECIMALS;
use crate::line::AngleUnit;
use crate::packer::{MAX_DATAGRAM_BYTES, MIN_DATAGRAM_BYTES};

/// Options of the format of sent lines and datagrams.
#[derive(clap::Args, Clone, Debug)]
pub struct Form {
    /// Use radians for angles instead of degrees
    #[arg(long)]
    pub radians: bool,
    /// Decimals of sent numbers; angles in radians have two more
    #[arg(long, value_name = "N", default_value = "3", value_parser = decimals)]
    pub decimals: usize,
    /// Longest datagram to send, in bytes
    #[arg(long, value_name = "BYTES", default_value = "1400", value_parser = datagram_bytes)]
    pub mtu: usize,
}

impl Form {
    /// Returns the unit of angles.
    pub fn unit(&self) -> AngleUnit {
        if self.radians { AngleUnit::Radians } else { AngleUnit::Degrees }
    }
}

/// An offset `X,Y` in metres.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Offset(pub [f64; 2]);

/// The error of parsing an [`Offset`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("give X,Y in metres, for example 1.5,-2")]
pub struct ParseOffsetError;

impl FromStr for Offset {
    type Err = ParseOffsetError;

    fn from_str(text: &str) -> Result<Self, ParseOffsetError> {
        let (x, y) = text.split_once(',').ok_or(ParseOffsetError)?;
        match [x, y].map(|number| number.trim().parse::<f64>()) {
            [Ok(x), Ok(y)] if x.is_finite() && y.is_finite() => Ok(Self([x, y])),
            _ => Err(ParseOffsetError),
        }
    }
}

/// A range of robots' ids: `A..B` is A to B - 1. Either end may be omitted.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RobotRange(pub Range<u32>);

/// The error of parsing a [`RobotRange`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("give A..B, the first robot and the one after the last, for example 0..100 or 100..")]
pub struct ParseRangeError;

impl FromStr for RobotRange {
    type Err = ParseRangeError;

    fn from_str(text: &str) -> Result<Self, ParseRangeError> {
        let (from, to) = text.split_once("..").ok_or(ParseRangeError)?;
        let from = if from.is_empty() { Ok(0) } else { from.parse() };
        let to = if to.is_empty() { Ok(u32::MAX) } else { to.parse() };
        match (from, to) {
            (Ok(from), Ok(to)) if from < to => Ok(Self(from..to)),
            _ => Err(ParseRangeError),
        }
    }
}

pub fn decimals(text: &str) -> Result<usize, String> {
    within(text, 1..=MAX_DECIMALS)
}

pub fn datagram_bytes(text: &str) -> Result<usize, String> {
    within(text, MIN_DATAGRAM_BYTES..=MAX_DATAGRAM_BYTES)
}

pub fn datagram_limit(text: &str) -> Result<usize, String> {
    within(text, 1..=MAX_DATAGRAM_BYTES)
}

/// Parses a duration in seconds.
pub fn seconds(text: &str) -> Result<std::time::Duration, String> {
    let seconds = text.parse().ok().filter(|seconds| (0.001..=1e6).contains(seconds));
    seconds
        .map(std::time::Duration::from_secs_f64)
        .ok_or_else(|| "give a number of seconds from 0.001 to 1000000".to_owned())
}

fn within(text: &str, range: std::ops::RangeInclusive<usize>) -> Result<usize, String> {
    let number = text.parse().ok().filter(|number| range.contains(number));
    number.ok_or_else(|| format!("give a number from {} to {}", range.start(), range.end()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_of_robots_are_parsed() {
        let range = |text: &str| text.parse::<RobotRange>().ok().map(|range| range.0);
        assert_eq!(range("3..10"), Some(3..10));
        assert_eq!(range("3.."), Some(3..u32::MAX));
        assert_eq!(range("..7"), Some(0..7));
        assert_eq!(range(".."), Some(0..u32::MAX));
        for invalid in ["", "3", "3..3", "5..3", "-1..3", "a..b", "3...7", "1..5000000000"] {
            assert_eq!(range(invalid), None, "{invalid}");
        }
    }

    #[test]
    fn offsets_are_parsed() {
        assert_eq!("1.5,-2".parse(), Ok(Offset([1.5, -2.0])));
        for invalid in ["", "1", "1,2,3", "nan,0", "inf,0", "x,y"] {
            assert!(invalid.parse::<Offset>().is_err(), "{invalid}");
        }
    }

    #[test]
    fn errors_of_numbers_out_of_range_contain_the_range() {
        assert_eq!(decimals("3"), Ok(3));
        assert!(decimals("0").is_err_and(|message| message.contains("1 to 9")));
        assert!(datagram_limit("0").is_err() && datagram_limit("1") == Ok(1));
        assert!(datagram_bytes("65508").is_err_and(|message| message.contains("65507")));
        assert!(seconds("nan").is_err() && seconds("0").is_err() && seconds("-1").is_err());
        assert_eq!(seconds("0.5"), Ok(std::time::Duration::from_millis(500)));
    }
}
