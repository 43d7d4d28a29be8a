//! Records a fleet to an MCAP file; replays, repairs, exports and plots such recordings.
//!
//! The file format is in this crate's README; the messages are in `proto/`.

mod decode;
mod encode;
mod export;
mod frames;
mod mcap_file;
mod output;
mod plot;
mod reading;
mod recorded;
mod recorder;
mod repair;
mod replay;
mod robots;
mod scan;
mod scene;
mod schema;
mod sink;
mod sources;
mod table;
mod timeline;

#[cfg(test)]
mod export_tests;
#[cfg(test)]
mod message_tests;
#[cfg(test)]
mod repair_tests;

use std::path::PathBuf;
use std::time::{Duration, SystemTime};

use clap::{Args, CommandFactory, FromArgMatches, Parser};
use regatta_plugin::frame::CONTRACT_VERSION;
use regatta_plugin::{Error, Options, Result, Termination};

pub use decode::MessageError;
pub use export::{ExportArgs, ExportError, export};
pub use mcap_file::Compression;
pub use plot::{PlotArgs, PlotError, plot};
pub use reading::{ReadingError, Recording};
pub use repair::{Repair, RepairError, repair};
pub use replay::{ReplayArgs, ReplayError, replay};
pub use robots::Robots;
pub use schema::Topic;
pub use sink::SinkError;

use recorder::{Recorder, Settings};
use sink::Sink;

/// What to record, and where to.
#[derive(Args, Clone, Debug)]
pub struct RecordArgs {
    #[command(flatten)]
    options: Options,
    /// The file to write [default: the fleet's name and the time of day]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Overwrite the file if it exists
    #[arg(long)]
    force: bool,
    /// Record one frame of so many
    #[arg(long, value_name = "N", default_value = "1", allow_negative_numbers = true)]
    #[arg(value_parser = clap::value_parser!(u64).range(1..))]
    every: u64,
    /// How to compress
    #[arg(long, value_enum, default_value_t)]
    compression: Compression,
    /// Poses a second for Foxglove, Rerun and PlotJuggler; 0 for none
    #[arg(long, value_name = "HZ", default_value = "10", value_parser = parse_poses_rate, allow_negative_numbers = true)]
    poses_rate: f64,
    /// Instead of recording: close a recording that was cut off
    #[arg(long, value_name = "FILE", conflicts_with = "output")]
    repair: Option<PathBuf>,
}

fn parse_poses_rate(text: &str) -> Result<f64, String> {
    let rate = text.parse().ok().filter(|rate| (0.0..=1e6).contains(rate));
    rate.ok_or_else(|| format!("'{text}' is no rate; give a number a second from 0 to 1000000"))
}

/// Records a fleet until Ctrl-C, or repairs a recording.
///
/// # Errors
/// If the file can't be created or written, or the fleet can't be read.
pub fn record(args: &RecordArgs) -> Result {
    if let Some(path) = &args.repair {
        println!("{}: {}", path.display(), repair(path)?);
        return Ok(());
    }
    // Before there is a file: one that may not grow any more is then an error rather than the end.
    Termination::watch()?;
    let path = args.output.clone().unwrap_or_else(|| default_path(&args.options));
    let mut sink = Sink::create(&path, args.force, args.compression)?;
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
    let poses_period = (args.poses_rate > 0.0).then(|| Duration::from_secs_f64(1.0 / args.poses_rate));
    let recorder =
        Recorder::new(path, sink, Settings { every: args.every, poses_period, sees_all: args.options.rate.is_none() });
    args.options.run(recorder, "record")
}

/// The same with a command line from elsewhere, whose first argument is the program.
///
/// # Errors
/// As [`record`]; or an option is wrong.
pub fn record_from(args: Vec<String>) -> Result {
    #[derive(Parser)]
    #[command(name = "record", about = "Records a fleet to an MCAP file")]
    struct Cli {
        #[command(flatten)]
        args: RecordArgs,
    }
    let parsed = Cli::command().try_get_matches_from(args).and_then(|matches| Cli::from_arg_matches(&matches));
    match parsed {
        Ok(cli) => record(&cli.args),
        Err(error) if error.kind() == clap::error::ErrorKind::DisplayHelp => Ok(error.print()?),
        Err(error) => Err(Error::new(error.to_string().lines().next().unwrap_or_default())),
    }
}

/// `default-2026-11-22T10-15-00Z.mcap`.
fn default_path(options: &Options) -> PathBuf {
    let time = humantime::format_rfc3339_seconds(SystemTime::now()).to_string().replace(':', "-");
    PathBuf::from(format!("{}-{time}.mcap", options.fleet))
}
