//! The command line of a program that is a producer.

#[cfg(feature = "shared-memory")]
use std::ffi::OsString;
use std::path::Path;
use std::time::Duration;

use clap::Args;

#[cfg(feature = "shared-memory")]
use super::{Producer, Session, Speed};
#[cfg(feature = "shared-memory")]
use crate::error::{Error, Result};
#[cfg(feature = "shared-memory")]
use crate::ports::producer::ProducerPorts;
#[cfg(feature = "shared-memory")]
use crate::process::{
    log::set_verbosity, options::parse, run::join, scheduling::SchedulingOptions,
    termination::Termination,
};
#[cfg(feature = "shared-memory")]
use crate::records::name::FleetName;

/// The command-line options of a producer. A producer with options of its own flattens these into
/// them (`#[command(flatten)]`) and calls [`run`](Self::run).
#[cfg(feature = "shared-memory")]
#[derive(Args, Clone, Debug)]
pub struct ProducerOptions {
    /// Fleet to publish
    #[arg(long, value_name = "NAME", default_value_t)]
    pub fleet: FleetName,
    /// Ticks per simulated second
    #[arg(long, value_name = "HZ", default_value = "50", value_parser = parse_rate)]
    pub rate: f64,
    /// Simulated seconds per wall second: a factor from 0.001 to 1000, or max
    #[arg(long, default_value = "1")]
    pub speed: Speed,
    /// The plugins to wait for
    #[command(flatten)]
    pub lockstep: LockstepOptions,
    /// Priority and processors
    #[command(flatten)]
    pub scheduling: SchedulingOptions,
    /// Name in `regatta doctor` [default: the program's name]
    #[arg(long, value_name = "NAME")]
    pub name: Option<String>,
    /// Print warnings of the shared-memory library (iceoryx2); -vv for its complete log
    #[arg(short, long, action = clap::ArgAction::Count)]
    pub verbose: u8,
}

/// The plugins that a producer waits for after each frame.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Processes")]
pub struct LockstepOptions {
    /// Wait after each tick until these plugins have finished it, so that runs are equal, bit for
    /// bit; write this option after the scenario, with names separated by commas or spaces; for
    /// `regatta run`, `all` means all plugins of the scenario
    #[arg(id = "lockstep", long = "lockstep", value_name = "NAME", num_args = 1.., value_delimiter = ',', value_parser = parse_plugin)]
    pub names: Vec<String>,
    /// Longest time to wait for a plugin in lockstep
    #[arg(id = "lockstep_timeout", long = "lockstep-timeout", value_name = "SECONDS", default_value = "10", value_parser = parse_seconds)]
    pub timeout: Duration,
}

impl Default for LockstepOptions {
    /// No lockstep.
    fn default() -> Self {
        Self { names: Vec::new(), timeout: Duration::from_secs(10) }
    }
}

fn parse_plugin(text: &str) -> Result<String, String> {
    match Path::new(text).extension() {
        Some(_) => Err("that looks like a file: give it before --lockstep".to_owned()),
        None => Ok(text.to_owned()),
    }
}

#[cfg(feature = "shared-memory")]
fn parse_rate(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(rate) if (0.001..=1e6).contains(&rate) => Ok(rate),
        _ => Err("give ticks per second, from 0.001 to 1000000".to_owned()),
    }
}

fn parse_seconds(text: &str) -> Result<Duration, String> {
    let seconds = text.parse().ok().and_then(|seconds| Duration::try_from_secs_f64(seconds).ok());
    seconds.ok_or_else(|| "give seconds, for example 10".to_owned())
}

/// Runs a producer until Ctrl-C or `SIGTERM`, with the options on this process's command line.
///
/// # Errors
/// If an option is invalid, shared memory can't be used, the fleet has a live producer, or one of
/// the producer's functions returns an error.
#[cfg(feature = "shared-memory")]
pub fn produce<P: Producer>(producer: P) -> Result
where
    Error: From<P::Error>,
{
    produce_from(producer, std::env::args_os())
}

/// Runs a producer with a given command line. Its first argument is the program, whose file name is
/// the producer's name unless `--name` gives one.
///
/// # Errors
/// As [`produce`].
#[cfg(feature = "shared-memory")]
pub fn produce_from<P, A>(producer: P, args: impl IntoIterator<Item = A>) -> Result
where
    P: Producer,
    Error: From<P::Error>,
    A: Into<OsString> + Clone,
{
    let about = "A Regatta producer: publishes the frames of a fleet";
    match parse::<ProducerOptions, A>(args, "producer", about)? {
        Some((options, program)) => options.run(producer, &program),
        None => Ok(()),
    }
}

#[cfg(feature = "shared-memory")]
impl ProducerOptions {
    /// Runs a producer with these options. `program` is its name, unless `--name` gives one.
    ///
    /// # Errors
    /// As [`produce`].
    pub fn run<P: Producer>(&self, mut producer: P, program: &str) -> Result
    where
        Error: From<P::Error>,
    {
        set_verbosity(self.verbose);
        let termination = Termination::watch()?;
        self.scheduling.apply()?;
        let ports = ProducerPorts::create_on(join(&self.fleet, self.name.as_deref(), program)?, 0)?;
        let tick_period = Duration::from_secs_f64(1.0 / self.rate);
        let mut session = Session::new(ports, tick_period, self.speed, self.lockstep.clone());
        Ok(session.run(&mut producer, &termination)?)
    }
}
