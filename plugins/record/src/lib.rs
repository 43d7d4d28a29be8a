//! Records a fleet to an MCAP file; replays, repairs, exports and plots such recordings.
//!
//! This crate's README describes the file format; the crate `regatta-messages`
//! defines the messages.

mod arguments;
mod contacts;
mod decode;
mod disk;
mod export;
mod info;
mod mcap_file;
mod output;
mod parse;
mod playback;
mod plot;
mod progress;
mod reading;
mod recorded;
mod recorder;
mod repair;
mod replay;
mod scan;
mod sink;
mod sources;
mod table;
mod thinning;
mod timeline;

use std::ffi::OsString;
use std::path::PathBuf;
use std::time::{Duration, SystemTime};

use clap::{Args, CommandFactory, FromArgMatches, Parser};
use regatta_messages::{encode, scene, schema};
use regatta_plugin::frame::CONTRACT_VERSION;
use regatta_plugin::{Error, Options, Plugin, Result, Termination};

pub use arguments::{Limit, RobotIds, TopicSet};
pub use decode::MessageError;
pub use export::{ExportArgs, ExportError, export};
pub use info::{Info, TopicInfo, info};
pub use mcap_file::Compression;
pub use playback::{Published, play};
pub use plot::{PlotArgs, PlotError, plot, png};
pub use reading::{ReadingError, Recording};
pub use repair::{Repair, RepairError, repair, repair_copy};
pub use replay::{ReplayArgs, ReplayError, replay};
pub use schema::Topic;
pub use sink::SinkError;

use arguments::{parse_poses_rate, path_parser};
use recorder::{Recorder, Settings};
use sink::{Division, Sink};

/// The groups of options in the help.
const CONTENT: &str = "Content";
const FILES: &str = "Files";

/// Options of `regatta record`.
#[derive(Args, Clone, Debug)]
pub struct RecordArgs {
    #[command(flatten)]
    options: Options,
    /// File to write [default: the fleet's name and the date and time, with .mcap]
    #[arg(short, long, value_name = "FILE", value_parser = path_parser(), help_heading = FILES)]
    output: Option<PathBuf>,
    /// Replace files that exist
    #[arg(long, help_heading = FILES)]
    force: bool,
    /// Divide the recording into numbered files of this time or size: 10min, 1GB …
    #[arg(long, value_name = "LIMIT", conflicts_with = "ring", help_heading = FILES)]
    split: Option<Limit>,
    /// Keep only the newest part of the recording, of this time or size: 10min, 1GB …
    #[arg(long, value_name = "LIMIT", help_heading = FILES)]
    ring: Option<Limit>,
    /// Record only these topics, and the world: frames, events, commands, orders, contacts,
    /// contact_events, facilities, columns, columns/NAME, poses, robots, graph
    #[arg(long, value_name = "NAMES", help_heading = CONTENT)]
    topics: Option<TopicSet>,
    /// Record only every Nth frame, with the columns and contacts of that frame
    #[arg(long, value_name = "N", default_value = "1", allow_negative_numbers = true)]
    #[arg(value_parser = clap::value_parser!(u64).range(1..), help_heading = CONTENT)]
    every: u64,
    /// Compression of the recording
    #[arg(long, value_enum, default_value_t, help_heading = FILES)]
    compression: Compression,
    /// Poses per second for Foxglove, Rerun and PlotJuggler; 0 for none
    #[arg(long, value_name = "HZ", default_value = "10", allow_negative_numbers = true)]
    #[arg(value_parser = parse_poses_rate, help_heading = CONTENT)]
    poses_rate: f64,
    /// Repair a truncated recording instead of recording; with --output, repair a copy
    #[arg(long, value_name = "FILE", help_heading = FILES)]
    repair: Option<PathBuf>,
}

/// Records a fleet until Ctrl-C, or repairs a recording.
///
/// # Errors
/// Returns an error if the file can't be created or written, or the fleet can't be read.
pub fn record(args: &RecordArgs) -> Result {
    if let Some(path) = &args.repair {
        let (written, repair) = match &args.output {
            Some(copy) => (copy, repair_copy(path, copy, args.force)?),
            None => (path, repair(path)?),
        };
        println!("{}: {repair}", written.display());
        return Ok(());
    }
    // Signals are handled before the file is created: writing beyond the file size limit then
    // returns an error instead of killing the process.
    Termination::watch()?;
    args.options.run(recorder(args)?, "record")
}

/// Creates the file of a recording, and the plugin that writes it.
fn recorder(args: &RecordArgs) -> Result<Recorder> {
    let path = args.output.clone().unwrap_or_else(|| default_path(&args.options));
    let division = match (args.split, args.ring) {
        (Some(limit), _) => Division::Split(limit),
        (None, Some(limit)) => Division::Ring(limit),
        (None, None) => Division::None,
    };
    let settings =
        sink::Settings { overwrite: args.force, compression: args.compression, division };
    let mut sink = Sink::create(&path, settings)?;
    sink.note(
        "regatta",
        &[
            ("fleet", args.options.fleet.to_string()),
            ("version", env!("CARGO_PKG_VERSION").to_owned()),
            ("contract", CONTRACT_VERSION.to_string()),
            ("every", args.every.to_string()),
            ("began", humantime::format_rfc3339_seconds(SystemTime::now()).to_string()),
        ],
    );
    let poses_period =
        (args.poses_rate > 0.0).then(|| Duration::from_secs_f64(1.0 / args.poses_rate));
    let topics = args.topics.clone().unwrap_or_else(TopicSet::all);
    let settings =
        Settings { topics, every: args.every, poses_period, sees_all: args.options.rate.is_none() };
    Ok(Recorder::new(sink, settings))
}

/// The command line of the plugin.
#[derive(Parser)]
#[command(name = "record", about = "Record the fleet to an MCAP file")]
struct Cli {
    #[command(flatten)]
    args: RecordArgs,
}

/// Returns the plugin of a command line, to run it beside others in one process. The first argument
/// is the program's name.
///
/// # Errors
/// Returns an error if an option is invalid, or the file can't be created.
pub fn plugin<A: Into<OsString> + Clone>(args: impl IntoIterator<Item = A>) -> Result<impl Plugin> {
    recorder(&Cli::try_parse_from(args)?.args)
}

/// Runs [`record`] with a command line, whose first argument is the program's name.
///
/// # Errors
/// Returns an error if an option is invalid, or if [`record`] fails.
pub fn record_from(args: Vec<String>) -> Result {
    let parsed = Cli::command()
        .try_get_matches_from(args)
        .and_then(|matches| Cli::from_arg_matches(&matches));
    match parsed {
        Ok(cli) => record(&cli.args),
        Err(error) if error.kind() == clap::error::ErrorKind::DisplayHelp => Ok(error.print()?),
        Err(error) => Err(Error::new(error.to_string().lines().next().unwrap_or_default())),
    }
}

/// Returns a file name like `default-2026-11-22T10-15-00Z.mcap`.
fn default_path(options: &Options) -> PathBuf {
    let time = humantime::format_rfc3339_seconds(SystemTime::now()).to_string().replace(':', "-");
    PathBuf::from(format!("{}-{time}.mcap", options.fleet))
}
