//! Limits of files on a command line: a time or a size.

use std::fmt;
use std::str::FromStr;
use std::time::Duration;

/// A limit of a file or of several: `10min` or `1GB`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Limit {
    /// Time on the recording's clock.
    Time(Duration),
    /// Bytes in the file.
    Bytes(u64),
}

/// Units of sizes, in bytes.
const UNITS: [(&str, u64); 9] = [
    ("KB", 1_000),
    ("MB", 1_000_000),
    ("GB", 1_000_000_000),
    ("TB", 1_000_000_000_000),
    ("KIB", 1 << 10),
    ("MIB", 1 << 20),
    ("GIB", 1 << 30),
    ("TIB", 1 << 40),
    ("B", 1),
];

/// The smallest limit of size: a chunk.
const LEAST_BYTES: u64 = 1_000_000;
/// The smallest limit of time: a chunk.
const LEAST_TIME: Duration = Duration::from_secs(1);

impl Limit {
    /// Whether an amount of time and bytes has reached this limit.
    pub(crate) fn is_reached(&self, time: Duration, bytes: u64) -> bool {
        match self {
            Self::Time(limit) => time >= *limit,
            Self::Bytes(limit) => bytes >= *limit,
        }
    }

    /// Returns a fraction of the limit.
    pub(crate) fn divided(&self, by: u32) -> Self {
        match self {
            Self::Time(limit) => Self::Time(*limit / by),
            Self::Bytes(limit) => Self::Bytes(limit / u64::from(by)),
        }
    }
}

impl fmt::Display for Limit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Time(limit) => humantime::format_duration(*limit).fmt(f),
            Self::Bytes(limit) => write!(f, "{:.1} MB", *limit as f64 * 1e-6),
        }
    }
}

impl FromStr for Limit {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let invalid = || {
            format!(
                "invalid limit '{text}'; give a time or a size, for example 10min, 90s, 500MB or 1GB"
            )
        };
        let limit = match humantime::parse_duration(text) {
            Ok(time) => Self::Time(time),
            Err(_) => Self::Bytes(bytes(text).ok_or_else(invalid)?),
        };
        match limit {
            Self::Time(time) if time < LEAST_TIME => {
                Err(format!("'{text}' is too short; the least is 1s"))
            }
            Self::Bytes(bytes) if bytes < LEAST_BYTES => {
                Err(format!("'{text}' is too small; the least is 1MB"))
            }
            limit => Ok(limit),
        }
    }
}

fn bytes(text: &str) -> Option<u64> {
    let digits = text.find(|character: char| !character.is_ascii_digit() && character != '.')?;
    let (number, unit) = text.split_at(digits);
    let unit = unit.trim().to_ascii_uppercase();
    let (_, factor) = UNITS.iter().find(|(name, _)| *name == unit)?;
    let bytes = number.parse::<f64>().ok()? * *factor as f64;
    bytes.is_finite().then_some(bytes as u64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_and_sizes_are_parsed() {
        let parse = |text: &str| text.parse::<Limit>();
        assert_eq!(parse("10min"), Ok(Limit::Time(Duration::from_secs(600))));
        assert_eq!(parse("1h 30min"), Ok(Limit::Time(Duration::from_secs(5400))));
        assert_eq!(parse("1GB"), Ok(Limit::Bytes(1_000_000_000)));
        assert_eq!(parse("1.5 GiB"), Ok(Limit::Bytes(3 << 29)));
        assert_eq!(parse("500mb"), Ok(Limit::Bytes(500_000_000)));
        for bad in ["", "10", "GB", "10 parrots", "1.2.3GB", "-1GB", "0s", "10ms", "5KB"] {
            assert!(parse(bad).is_err(), "{bad}");
        }
    }
}
