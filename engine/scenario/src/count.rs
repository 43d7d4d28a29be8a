//! Numbers of robots as people write them: 500, 10k, 1M.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Deserializer, de};

/// A number of robots. It is written in digits, with `_` between them where that helps, and `k` for
/// thousands or `M` for millions: 500, 10_000, 10k, 2.5k, 1M.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct RobotCount(pub u32);

/// The error of parsing a [`RobotCount`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("invalid number of robots '{0}': give a whole number such as 500, 10k or 1M")]
pub struct ParseRobotCountError(String);

impl FromStr for RobotCount {
    type Err = ParseRobotCountError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let (digits, unit) = match text.as_bytes().last() {
            Some(b'k' | b'K') => (&text[..text.len() - 1], 1_000),
            Some(b'M') => (&text[..text.len() - 1], 1_000_000),
            _ => (text, 1),
        };
        let (whole, fraction) = digits.split_once('.').unwrap_or((digits, ""));
        scaled(whole, fraction, unit).map(Self).ok_or_else(|| ParseRobotCountError(text.to_owned()))
    }
}

/// Returns `whole.fraction` × `unit` if that is a whole number.
fn scaled(whole: &str, fraction: &str, unit: u64) -> Option<u32> {
    let whole: String = whole.chars().filter(|&character| character != '_').collect();
    if !whole.bytes().chain(fraction.bytes()).all(|byte| byte.is_ascii_digit()) {
        return None;
    }
    let mut value = whole.parse::<u64>().ok()?.checked_mul(unit)?;
    let mut place = unit;
    for digit in fraction.bytes() {
        if !place.is_multiple_of(10) {
            return None;
        }
        place /= 10;
        value = value.checked_add(u64::from(digit - b'0') * place)?;
    }
    u32::try_from(value).ok()
}

impl fmt::Display for RobotCount {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl<'de> Deserialize<'de> for RobotCount {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(CountVisitor)
    }
}

struct CountVisitor;

impl de::Visitor<'_> for CountVisitor {
    type Value = RobotCount;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a number of robots such as 500, 10k or 1M")
    }

    fn visit_u64<E: de::Error>(self, number: u64) -> Result<Self::Value, E> {
        let count = u32::try_from(number).map(RobotCount);
        count.map_err(|_| E::invalid_value(de::Unexpected::Unsigned(number), &self))
    }

    fn visit_str<E: de::Error>(self, text: &str) -> Result<Self::Value, E> {
        text.parse().map_err(|_| E::invalid_value(de::Unexpected::Str(text), &self))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_are_parsed_exactly() {
        for (text, count) in [
            ("0", 0),
            ("500", 500),
            ("10k", 10_000),
            ("10K", 10_000),
            ("2.5k", 2_500),
            ("1.234k", 1_234),
            ("2.3M", 2_300_000),
            ("1M", 1_000_000),
            ("10_000", 10_000),
            ("4294967295", u32::MAX),
        ] {
            assert_eq!(text.parse(), Ok(RobotCount(count)), "{text}");
        }
        for text in [
            "",
            "k",
            "M",
            ".",
            "-1",
            "+1",
            "2.5",
            "1.2345k",
            "1e3",
            "1m",
            "1G",
            "10 k",
            "4294967296",
            "5000M",
        ] {
            assert!(text.parse::<RobotCount>().is_err(), "{text}");
        }
    }
}
