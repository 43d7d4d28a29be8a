//! The options and the error of a replay.

use std::path::PathBuf;

use clap::Args;
use regatta_plugin::producer::{LockstepOptions, Speed};
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
    #[command(flatten)]
    pub(super) lockstep: LockstepOptions,
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
