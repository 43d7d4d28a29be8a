//! The requested speed of a run.

use core::fmt;
use core::str::FromStr;

/// Requested simulated seconds per wall second.
///
/// ```
/// use regatta_plugin::producer::Speed;
///
/// assert_eq!("max".parse::<Speed>().unwrap(), Speed::Max);
/// assert_eq!("0.5".parse::<Speed>().unwrap().as_f32(), 0.5);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Speed {
    /// A factor from 0.001 to 1000.
    Factor(f32),
    /// As fast as the machine can.
    Max,
}

/// The error of parsing a [`Speed`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("invalid speed '{0}': give a factor from 0.001 to 1000, or max")]
pub struct ParseSpeedError(String);

impl Speed {
    /// The factor, or infinity.
    pub fn as_f32(self) -> f32 {
        match self {
            Self::Factor(factor) => factor,
            Self::Max => f32::INFINITY,
        }
    }

    /// Returns the speed of a factor; `None` unless it is in [0.001, 1000] or infinite.
    pub fn from_f32(factor: f32) -> Option<Self> {
        match factor {
            f32::INFINITY => Some(Self::Max),
            0.001..=1000.0 => Some(Self::Factor(factor)),
            _ => None,
        }
    }
}

impl Default for Speed {
    /// As fast as the wall clock.
    fn default() -> Self {
        Self::Factor(1.0)
    }
}

impl FromStr for Speed {
    type Err = ParseSpeedError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let factor =
            if text.eq_ignore_ascii_case("max") { Some(f32::INFINITY) } else { text.parse().ok() };
        factor.and_then(Self::from_f32).ok_or_else(|| ParseSpeedError(text.to_owned()))
    }
}

impl fmt::Display for Speed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Factor(factor) => write!(f, "{factor}"),
            Self::Max => f.write_str("max"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn speeds_are_parsed_as_they_are_printed() {
        for text in ["max", "1", "0.5", "1000"] {
            assert_eq!(text.parse::<Speed>().unwrap().to_string(), text);
        }
        for text in ["0", "-1", "nan", "inf", "fast", "1001"] {
            assert_eq!(text.parse::<Speed>().is_ok(), text == "inf", "{text}");
        }
    }
}
