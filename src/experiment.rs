//! Experiments: an engine process with an attached reader, and the report of the measurements.

pub mod plot;
pub mod report;

use std::fs::{self, File};
use std::io::{Read, Seek};
use std::path::Path;
use std::time::{Duration, Instant};

use clap::builder::RangedU64ValueParser;
use regatta_plugin::control::ControlResponse;
use regatta_plugin::frame::RobotState;
use regatta_plugin::{Control, FleetName, Frame, Subscriber, Termination};

use crate::failure::{Failure, plugin_failure};
use crate::program::Program;
use crate::supervisor::Supervisor;

/// The longest time until the engine can be read.
const START_TIMEOUT: Duration = Duration::from_secs(60);
/// The time between two checks while an experiment waits.
const POLL_INTERVAL: Duration = Duration::from_millis(5);

/// Returns an error if this process was asked to end. Everything that an experiment has made is
/// removed when it is dropped.
pub fn check_interrupt() -> Result<(), Failure> {
    if Termination::watch().map_err(plugin_failure)?.requested() {
        return Err("interrupted; no report was written".into());
    }
    Ok(())
}

/// Waits, but not when this process is asked to end.
pub fn wait(time: Duration) -> Result<(), Failure> {
    let end = Instant::now() + time;
    while Instant::now() < end {
        check_interrupt()?;
        std::thread::sleep(POLL_INTERVAL.min(end.saturating_duration_since(Instant::now())));
    }
    Ok(())
}

/// An engine process, its control client and its reader.
pub struct Experiment {
    fleet: FleetName,
    supervisor: Supervisor,
    control: Control,
    /// The reader of its frames.
    pub reader: Subscriber,
}

impl Experiment {
    /// Starts `regatta engine SCENARIO ARGS` with a fleet name of its own, and waits until the
    /// fleet can be read.
    ///
    /// # Errors
    /// If the engine doesn't start.
    pub fn start(
        program: &Program,
        name: &str,
        scenario: &Path,
        args: &[String],
    ) -> Result<Self, Failure> {
        check_interrupt()?;
        let fleet: FleetName = format!("report-{name}-{}", std::process::id()).parse()?;
        let mut messages = tempfile::tempfile()?;
        let mut command = program.command();
        command.arg("engine").arg(scenario).args(["--fleet", &fleet.to_string()]).args(args);
        let mut supervisor = Supervisor::default();
        supervisor.start("engine", command.stderr(messages.try_clone()?))?;
        let (control, reader) = (Control::open(&fleet)?, Subscriber::open(&fleet)?);
        let started = Instant::now();
        loop {
            check_interrupt()?;
            if control.has_engine() && reader.has_producer() {
                return Ok(Self { fleet, supervisor, control, reader });
            }
            if !supervisor.take_ended().is_empty() || started.elapsed() > START_TIMEOUT {
                return Err(
                    format!("the engine did not start: {}", last_line(&mut messages)?).into()
                );
            }
            std::thread::sleep(POLL_INTERVAL);
        }
    }

    /// Returns the name of its fleet.
    pub fn fleet(&self) -> &FleetName {
        &self.fleet
    }

    /// Asks the engine for its status.
    ///
    /// # Errors
    /// If it doesn't answer.
    pub fn status(&mut self) -> Result<ControlResponse, Failure> {
        Ok(self.control.status()?)
    }

    /// Calls `is_last` with each frame as it arrives, until it returns true.
    ///
    /// # Errors
    /// If the engine ends, or if the time is over.
    pub fn watch(
        &mut self,
        timeout: Duration,
        mut is_last: impl FnMut(&Frame<'_>) -> bool,
    ) -> Result<(), Failure> {
        let started = Instant::now();
        while started.elapsed() < timeout {
            check_interrupt()?;
            if let Some(frame) = self.reader.wait(Duration::from_millis(200))?
                && is_last(&frame)
            {
                return Ok(());
            }
            if let Some(child) = self.supervisor.take_ended().first() {
                // Ctrl-C reaches the engine too.
                check_interrupt()?;
                return Err(child
                    .failure()
                    .unwrap_or_else(|| "the engine ended early".into())
                    .into());
            }
        }
        Err(format!("the experiment did not end within {} s", timeout.as_secs()).into())
    }

    /// Stops the engine, and returns an error if it failed.
    pub fn finish(mut self) -> Result<(), Failure> {
        match self.supervisor.stop().into_iter().next() {
            Some(failure) => Err(failure.into()),
            None => Ok(()),
        }
    }
}

/// Returns the last line that a process wrote, without its name.
fn last_line(messages: &mut File) -> Result<String, Failure> {
    let mut text = String::new();
    messages.rewind()?;
    messages.read_to_string(&mut text)?;
    let line = text.lines().last().unwrap_or("run `regatta doctor`");
    Ok(line.trim_start_matches("regatta: ").to_owned())
}

/// Whether every robot has reached the end of its route.
pub fn all_idle(frame: &Frame<'_>) -> bool {
    frame.state().iter().all(|&state| state == RobotState::Idle as u8)
}

/// Writes a file of an experiment into its temporary folder.
///
/// # Errors
/// If it can't be written.
pub fn write(path: &Path, text: &str) -> Result<(), Failure> {
    fs::write(path, text).map_err(|error| format!("can't write {}: {error}", path.display()).into())
}

/// Returns the parser of the time that a load is measured for, in seconds.
pub fn seconds_parser() -> RangedU64ValueParser {
    clap::value_parser!(u64).range(1..=86_400)
}

/// Creates a folder that is removed when dropped.
pub fn temporary_folder() -> Result<tempfile::TempDir, Failure> {
    tempfile::tempdir().map_err(|error| format!("can't create a temporary folder: {error}").into())
}
