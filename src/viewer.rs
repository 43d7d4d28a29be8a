//! `regatta viewer`: a fleet in 3D, in a window or in pictures. A recording is shown as a fleet,
//! which a replay publishes under a name of its own: the viewer reads the contract only.

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use regatta_plugin::FleetName;
use regatta_record::Recording;
use regatta_viewer::Options;

use crate::failure::{Failure, plugin_failure};
use crate::supervisor::Supervisor;

/// Runs `regatta viewer`.
pub fn run(options: &Options) -> Result<(), Failure> {
    options.check().map_err(plugin_failure)?;
    let Some(file) = &options.recording else {
        return regatta_viewer::run(options).map_err(plugin_failure);
    };
    // Fails before a window opens if the file isn't a recording.
    let recording = Recording::open_frames(file)?;
    check_times(&recording, options)?;
    let fleet: FleetName = format!("recording-{}", std::process::id()).parse()?;
    let options = Options { fleet: fleet.clone(), ..options.clone() };
    let mut children = Supervisor::default();
    children.start("replay", &mut replay_command(file, recording.span().0, &options)?)?;
    if options.shows_traffic() {
        let mut traffic = Command::new(std::env::current_exe()?);
        children
            .start("traffic", traffic.args(["plugin", "traffic", "--fleet", fleet.as_str()]))?;
    }
    // They end with the viewer, whatever the outcome.
    regatta_viewer::run(&options).map_err(plugin_failure)
}

/// Returns the command that publishes a recording, which begins at `start`, as a fleet, and stays
/// at its end.
fn replay_command(file: &Path, start: Duration, options: &Options) -> Result<Command, Failure> {
    let mut command = Command::new(std::env::current_exe()?);
    command
        .arg("replay")
        .arg("--fleet")
        .arg(options.fleet.to_string())
        .arg("--hold")
        .stdout(Stdio::null());
    if let Some(from) = options.starts_at() {
        command.arg("--paused");
        if from != Duration::MAX {
            command.args(["--from", &format!("{}ns", from.max(start).as_nanos())]);
        }
    }
    if options.counts_traffic() {
        command.args(["--lockstep", "traffic"]);
    }
    command.arg("--").arg(file);
    Ok(command)
}

/// Returns an error unless the wanted times are in the recording, in the right order.
fn check_times(recording: &Recording, options: &Options) -> Result<(), Failure> {
    let (start, end) = recording.span();
    for (name, time) in [("--from", options.from), ("--to", options.to), ("--at", options.at)] {
        let Some(time) = time.map(Duration::from) else { continue };
        if !(start..=end).contains(&time) {
            let [time, start, end] = [time, start, end].map(|time| time.as_secs_f64());
            return Err(format!(
                "{name} {time:.3} s is outside of the recording, {start:.3} s to {end:.3} s"
            )
            .into());
        }
    }
    if let (Some(from), Some(to)) = (options.from, options.to) {
        let [from, to] = [from, to].map(|time| Duration::from(time).as_secs_f64());
        if from > to {
            return Err(format!("--from {from:.3} s is after --to {to:.3} s").into());
        }
    }
    Ok(())
}
