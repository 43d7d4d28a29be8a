//! `regatta viewer`: a fleet in 3D, in a window or in pictures. A recording is shown as a fleet,
//! which a replay publishes under a name of its own: the viewer reads the contract only.

use std::path::Path;
use std::process::{Command, ExitCode, Stdio};
use std::time::Duration;

use regatta_plugin::FleetName;
use regatta_record::Recording;
use regatta_viewer::Options;

use crate::failure::{Failure, plugin_failure};
use crate::supervisor::Supervisor;

pub fn run(options: &Options) -> Result<ExitCode, Failure> {
    let Some(file) = &options.recording else {
        regatta_viewer::run(options).map_err(plugin_failure)?;
        return Ok(ExitCode::SUCCESS);
    };
    // One line about a file that is no recording, before a window opens.
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
    regatta_viewer::run(&options).map_err(plugin_failure)?;
    Ok(ExitCode::SUCCESS)
}

/// The command that publishes a recording, which begins at `start`, as a fleet, and stays at its
/// end.
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
    let [from, to, at] =
        [options.from, options.to, options.at].map(|time| time.map(Duration::from));
    for (name, time) in [("--from", from), ("--to", to), ("--at", at)] {
        if let Some(time) = time.filter(|time| !(start..=end).contains(time)) {
            let [time, start, end] = [time, start, end].map(|time| time.as_secs_f64());
            return Err(format!(
                "{name} {time:.3} s is outside of the recording, {start:.3} s to {end:.3} s"
            )
            .into());
        }
    }
    if let (Some(from), Some(to)) = (from, to)
        && from > to
    {
        return Err(format!(
            "--from {:.3} s is after --to {:.3} s",
            from.as_secs_f64(),
            to.as_secs_f64()
        )
        .into());
    }
    Ok(())
}
