//! The options and the error of a replay.

use std::path::PathBuf;
use std::time::Duration;

use clap::Args;
use regatta_plugin::producer::Speed;
use regatta_plugin::{FleetName, LockstepError, OpenError, PublishError, ReadError};

use crate::reading::ReadingError;

/// Options of `regatta replay`.
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
    /// Start again from the beginning at the end
    #[arg(long = "loop")]
    pub(super) repeat: bool,
    /// Stay at the end, for `regatta seek`
    #[arg(long, conflicts_with = "repeat")]
    pub(super) hold: bool,
    /// Start paused
    #[arg(long)]
    pub(super) paused: bool,
    /// Leave out the recorded columns and contacts, for plugins that compute them again
    #[arg(long)]
    pub(super) no_columns: bool,
    /// Wait for these plugins to finish each frame, so that they see every one
    #[arg(long, value_name = "NAME", num_args = 1..)]
    pub(super) lockstep: Vec<String>,
    /// How many seconds to wait for a plugin in lockstep
    #[arg(long, value_name = "SECONDS", default_value = "10", value_parser = parse_seconds)]
    pub(super) lockstep_timeout: Duration,
}

fn parse_seconds(text: &str) -> Result<Duration, String> {
    let seconds = text.parse().ok().and_then(|seconds| Duration::try_from_secs_f64(seconds).ok());
    seconds.ok_or_else(|| "give seconds, for example 10".to_owned())
}

/// The error that ends a replay.
#[derive(Debug, thiserror::Error)]
pub enum ReplayError {
    /// The recording can't be read.
    #[error(transparent)]
    Reading(#[from] ReadingError),
    /// The fleet's services can't be opened.
    #[error(transparent)]
    Open(#[from] OpenError),
    /// A message can't be published.
    #[error(transparent)]
    Publish(#[from] PublishError),
    /// Requests can't be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// A plugin in lockstep didn't finish a frame.
    #[error(transparent)]
    Lockstep(#[from] LockstepError),
    /// A time is outside of the recording.
    #[error("{0}")]
    Time(String),
    /// Signals can't be watched.
    #[error("can't watch for Ctrl-C ({0})")]
    Signals(String),
}
