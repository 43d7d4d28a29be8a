//! Types of arguments that several commands have.

use std::str::FromStr;
use std::time::Duration;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use regatta_engine::graph::Handles;
use regatta_engine::motion::Isa;

/// A duration: a number of seconds, or a number with a unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Time(pub Duration);

/// The error of parsing a [`Time`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ParseTimeError;

impl std::error::Error for ParseTimeError {}

impl std::fmt::Display for ParseTimeError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("give seconds, or a number with a unit: 4, 12.5s, 3min, 1h 30min")
    }
}

impl FromStr for Time {
    type Err = ParseTimeError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let seconds = text.trim().parse().ok().and_then(|seconds| Duration::try_from_secs_f64(seconds).ok());
        seconds.or_else(|| humantime::parse_duration(text).ok()).map(Self).ok_or(ParseTimeError)
    }
}

/// Returns the parser of `--isa`, which also names the values for completions.
pub fn isa_parser() -> impl TypedValueParser<Value = Isa> {
    PossibleValuesParser::new(Isa::ALL.map(Isa::name)).try_map(|name| name.parse::<Isa>())
}

/// Returns the parser of `--handles`, which also names the values for completions.
pub fn handles_parser() -> impl TypedValueParser<Value = Handles> {
    let names = [Handles::BAtOrigin, Handles::FAtOrigin].map(Handles::name);
    PossibleValuesParser::new(names).try_map(|name| name.parse::<Handles>())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bare_number_is_seconds() {
        for (text, millis) in [("4", 4_000), ("12.5", 12_500), ("12.5s", 12_500), ("250ms", 250), ("1min 2s", 62_000)] {
            assert_eq!(text.parse(), Ok(Time(Duration::from_millis(millis))), "{text}");
        }
        for text in ["", "-1", "nan", "inf", "4 parsecs", "1e300"] {
            assert_eq!(text.parse::<Time>(), Err(ParseTimeError), "{text}");
        }
    }
}
