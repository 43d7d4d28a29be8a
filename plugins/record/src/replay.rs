//! A replay: a producer like the engine, whose frames come from a recording.

mod annotations;
mod closures;
mod history;
mod producer;
mod search;
mod stage;

use std::path::PathBuf;
use std::time::Duration;

use clap::Args;
use regatta_plugin::producer::{LockstepOptions, Session, Speed};
use regatta_plugin::{
    FleetName, LockstepError, OpenError, Participant, ProducerPorts, PublishError, ReadError,
    Termination,
};

use crate::reading::{ReadingError, Recording};
use crate::schema::Topic;
use annotations::Annotations;
use producer::Replay;
use search::ContactSearch;
use stage::Stage;

/// Options of `regatta replay`.
#[derive(Args, Clone, Debug)]
pub struct ReplayArgs {
    /// Recording
    file: PathBuf,
    /// Fleet to publish it as
    #[arg(long, value_name = "NAME", default_value_t)]
    fleet: FleetName,
    /// Recorded seconds per wall second: a factor from 0.001 to 1000, or max
    #[arg(long, default_value = "1")]
    speed: Speed,
    /// Start at this time of the recording: 12.5s, 3min …
    #[arg(long, value_name = "TIME")]
    from: Option<humantime::Duration>,
    /// Start again from the beginning at the end
    #[arg(long = "loop")]
    repeat: bool,
    /// Stay at the end, for `regatta seek`
    #[arg(long, conflicts_with = "repeat")]
    hold: bool,
    /// Start paused
    #[arg(long)]
    paused: bool,
    /// Leave out the recorded columns and contacts, for plugins that compute them again
    #[arg(long)]
    no_columns: bool,
    #[command(flatten)]
    lockstep: LockstepOptions,
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

/// Replays a recording until it is over or Ctrl-C.
///
/// # Errors
/// Returns a [`ReplayError`] if the recording can't be read or published.
pub fn replay(args: &ReplayArgs) -> Result<(), ReplayError> {
    let termination =
        Termination::watch().map_err(|error| ReplayError::Signals(error.to_string()))?;
    let recording = Recording::open_frames(&args.file)?;
    let (start, end) = recording.span();
    if !recording.is_closed() {
        regatta_plugin::tell!(
            "replay: {} was never closed; `regatta record --repair` closes it",
            args.file.display()
        );
    }
    let mut topics = recording.topics();
    topics.retain(|topic| !args.no_columns || !topic.is_from_plugin());
    let mut ports = ProducerPorts::create_on(Participant::join(&args.fleet, "replay")?, 0)?;
    // In lockstep, nothing may depend on how fast a search is.
    let with_history = !args.no_columns && args.lockstep.names.is_empty();
    let annotations = Annotations::open(ports.participant(), &recording, with_history)?;
    let stage = Stage::open(&mut ports, &topics, annotations);
    regatta_plugin::tell!(
        "replay: fleet '{}': {} frames from {:.2} s to {:.2} s of {}; Ctrl-C stops",
        args.fleet,
        recording.count(&Topic::Frames),
        start.as_secs_f64(),
        end.as_secs_f64(),
        args.file.display()
    );
    // The times between the messages of a recording are kept.
    let mut session = Session::new(ports, Duration::ZERO, args.speed, args.lockstep.clone());
    if args.paused {
        session.pause();
    }
    let mut replay = Replay::new(&recording, stage, args)?;
    if recording.is_closed() && !session.is_lockstep() {
        replay.contact_search = ContactSearch::start(&args.file).ok();
    }
    session.run(&mut replay, &termination)
}
