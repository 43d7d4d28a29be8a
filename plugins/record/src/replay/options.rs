//! What a replay is asked for, and why it can't be had.

use std::path::PathBuf;

use clap::Args;
use regatta_plugin::lockstep::LockstepError;
use regatta_plugin::{FleetName, OpenError, PublishError, ReadError};

use crate::reading::ReadingError;

/// What to replay, and how.
#[derive(Args, Clone, Debug)]
pub struct ReplayArgs {
    /// The recording
    pub(super) file: PathBuf,
    /// The fleet to publish it as
    #[arg(long, value_name = "NAME", default_value_t)]
    pub(super) fleet: FleetName,
    /// Recorded seconds per wall second: a factor from 0.001 to 1000, or max
    #[arg(long, default_value = "1")]
    pub(super) speed: Speed,
    /// Start at this time of the recording: 12.5s, 3min …
    #[arg(long, value_name = "TIME")]
    pub(super) from: Option<humantime::Duration>,
    /// Start again from the beginning when it is over
    #[arg(long = "loop")]
    pub(super) repeat: bool,
    /// Stay when it is over, for `regatta seek`
    #[arg(long, conflicts_with = "repeat")]
    pub(super) hold: bool,
    /// Start paused
    #[arg(long)]
    pub(super) paused: bool,
    /// Leave out the recorded columns and contacts, for plugins that work them out anew
    #[arg(long)]
    pub(super) no_columns: bool,
    /// Wait for these plugins to finish each frame, so that they see every one
    #[arg(long, value_name = "NAME", num_args = 1..)]
    pub(super) lockstep: Vec<String>,
    /// How many seconds to wait for a plugin in lockstep
    #[arg(long, value_name = "SECONDS", default_value = "10")]
    pub(super) lockstep_timeout: f64,
}

/// Recorded seconds per wall second, infinite for as fast as possible.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Speed(pub(super) f32);

impl Speed {
    pub(super) fn from_f32(factor: f32) -> Option<Self> {
        (factor == f32::INFINITY || (0.001..=1000.0).contains(&factor)).then_some(Self(factor))
    }
}

impl std::str::FromStr for Speed {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let factor = if text.eq_ignore_ascii_case("max") { Some(f32::INFINITY) } else { text.parse().ok() };
        factor
            .and_then(Self::from_f32)
            .ok_or_else(|| format!("'{text}' is no speed: give a factor from 0.001 to 1000, or max"))
    }
}

/// Why a replay ended before its time.
#[derive(Debug, thiserror::Error)]
pub enum ReplayError {
    /// The recording can't be read.
    #[error(transparent)]
    Reading(#[from] ReadingError),
    /// The fleet's services can't be opened.
    #[error(transparent)]
    Open(#[from] OpenError),
    /// Something can't be published.
    #[error(transparent)]
    Publish(#[from] PublishError),
    /// Requests can't be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// A plugin in lockstep didn't finish a frame.
    #[error(transparent)]
    Lockstep(#[from] LockstepError),
    /// A time outside of the recording.
    #[error("{0}")]
    Time(String),
    /// Signals can't be watched.
    #[error("can't watch for Ctrl-C ({0})")]
    Signals(String),
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn speeds_are_factors_or_max() {
        assert_eq!("2.5".parse(), Ok(Speed(2.5)));
        assert_eq!("max".parse(), Ok(Speed(f32::INFINITY)));
        for bad in ["0", "-1", "nan", "1001", "fast"] {
            assert!(bad.parse::<Speed>().is_err(), "{bad}");
        }
    }
}
