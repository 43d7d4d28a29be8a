//! A run in lockstep as processes of this program, which write messages and figures into a
//! temporary folder.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

use regatta_plugin::FleetName;
use serde_json::Value;

use crate::failure::Failure;
use crate::program::Program;
use crate::supervisor::Supervisor;

/// The name of the engine's process.
pub const ENGINE: &str = "engine";
/// The time between two checks of the processes.
pub const POLL_INTERVAL: Duration = Duration::from_millis(5);
/// The longest time that the engine waits for a tick of the others: the first ones of a large fleet
/// take seconds.
const LOCKSTEP_TIMEOUT_SECS: &str = "120";
/// Room that a disk has unless it is full: more than the last messages of all processes.
const PROBE_BYTES: usize = 1 << 16;

/// The error of writing a file of a run.
#[derive(Debug, thiserror::Error)]
#[error("can't write to {}: {reason}", path.display())]
pub struct WriteError {
    /// The file, or the folder that holds the run's.
    pub path: PathBuf,
    /// The reason.
    pub reason: std::io::Error,
}

/// The processes of a run.
pub struct LockstepRun {
    program: Program,
    fleet: FleetName,
    /// Stopped before the folder is removed.
    supervisor: Supervisor,
    folder: tempfile::TempDir,
}

impl LockstepRun {
    /// Makes a run without processes, whose fleet is named after this process. `program` is run by
    /// [`command`](Self::command).
    ///
    /// # Errors
    /// If no temporary folder can be made.
    pub fn new(name: &str, program: Program) -> Result<Self, Failure> {
        let folder = tempfile::tempdir()
            .map_err(|reason| WriteError { path: std::env::temp_dir(), reason })?;
        let fleet = format!("{name}-{}", std::process::id()).parse()?;
        Ok(Self { program, fleet, supervisor: Supervisor::default(), folder })
    }

    /// The name of the fleet.
    pub fn fleet(&self) -> &FleetName {
        &self.fleet
    }

    /// The folder for the files of the processes.
    pub fn folder(&self) -> &Path {
        self.folder.path()
    }

    /// Starts an engine that makes some ticks at full speed with the members in lockstep, and then
    /// ends.
    pub fn start_engine(
        &mut self,
        scenario: &Path,
        ticks: u64,
        members: &[&str],
        args: &[&str],
    ) -> Result<(), Failure> {
        let mut engine = self.command(ENGINE, &[ENGINE])?;
        engine.arg(scenario).args(["--speed", "max", "--ticks", &ticks.to_string()]).args(args);
        engine.args(["--lockstep-timeout", LOCKSTEP_TIMEOUT_SECS]);
        engine.args(members.iter().flat_map(|member| ["--lockstep", member]));
        self.start(ENGINE, &mut engine).map(drop)
    }

    /// Starts a process, and returns its id.
    pub fn start(&mut self, name: &str, command: &mut Command) -> Result<u32, Failure> {
        self.supervisor.start(name, command)
    }

    /// Returns a command of the program.
    pub fn command(&self, name: &str, args: &[&str]) -> Result<Command, Failure> {
        let mut command = self.program.command();
        command.args(args);
        self.joined(name, command)
    }

    /// Gives a command the fleet, and a file for its messages: `NAME.log`.
    pub fn joined(&self, name: &str, mut command: Command) -> Result<Command, Failure> {
        command.args(["--fleet", self.fleet.as_str()]);
        self.logged(name, command)
    }

    /// Gives a command a file for its messages: `NAME.log`.
    pub fn logged(&self, name: &str, mut command: Command) -> Result<Command, Failure> {
        let path = self.folder().join(format!("{name}.log"));
        let log = match File::create(&path) {
            Ok(log) => log,
            Err(reason) => return Err(WriteError { path, reason }.into()),
        };
        command.stdin(Stdio::null()).stdout(log.try_clone()?).stderr(log);
        Ok(command)
    }

    /// The file for the figures of a process.
    pub fn json_file(&self, name: &str) -> PathBuf {
        self.folder().join(format!("{name}.json"))
    }

    /// Whether the engine has made all ticks.
    ///
    /// # Errors
    /// If a process has ended too early.
    pub fn engine_has_ended(&mut self) -> Result<bool, Failure> {
        let ended = self.supervisor.take_ended();
        let faults = ended.iter().filter(|child| child.name != ENGINE || !child.status.success());
        // If another process has failed, the engine has failed for that reason.
        match faults.max_by_key(|child| child.name != ENGINE) {
            Some(child) => {
                let failure =
                    child.failure().unwrap_or_else(|| format!("{} ended early", child.name));
                Err(self.failure(&failure, &child.name))
            }
            None => Ok(!ended.is_empty()),
        }
    }

    /// Stops the other processes, and returns the failures of those that failed.
    pub fn stop(&mut self) -> Vec<String> {
        self.supervisor.stop()
    }

    /// A failure of a process with the last line that it wrote.
    pub fn failure(&self, failure: &str, name: &str) -> Failure {
        let folder = self.folder();
        // The logs are of no use on a full disk: the last messages found no room.
        if let Err(reason) = fs::write(folder.join("probe"), [0; PROBE_BYTES]) {
            return WriteError { path: folder.parent().unwrap_or(folder).to_owned(), reason }
                .into();
        }
        let log = self.log(name);
        let line =
            log.lines().rfind(|line| !line.trim().is_empty()).unwrap_or("it printed nothing");
        // The files of a run that is over are gone.
        let line =
            line.trim_start_matches("regatta: ").replace(&format!("{}/", folder.display()), "");
        format!("{failure}: {line}").into()
    }

    /// The text that a process wrote to standard output and standard error.
    pub fn log(&self, name: &str) -> String {
        fs::read_to_string(self.folder().join(format!("{name}.log"))).unwrap_or_default()
    }

    /// The figures in the file of a process, which may have written several.
    pub fn json(&self, name: &str, process: &str) -> Result<Value, Failure> {
        let text = fs::read_to_string(self.json_file(name)).unwrap_or_default();
        serde_json::from_str(&text)
            .map_err(|_| self.failure(&format!("{name} wrote no figures"), process))
    }
}

/// Returns the kinds of findings that the validator's figures have, with their counts.
pub fn findings(validator: &Value) -> impl Iterator<Item = (String, u64)> {
    let kinds = validator["kinds"].as_array().into_iter().flatten();
    let kinds =
        kinds.filter_map(|kind| Some((kind["kind"].as_str()?.to_owned(), kind["count"].as_u64()?)));
    kinds.filter(|(_, count)| *count > 0)
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn only_kinds_that_were_found_are_findings() {
        let report =
            json!({"kinds": [{"kind": "contact", "count": 0}, {"kind": "idle", "count": 2}]});
        assert_eq!(findings(&report).collect::<Vec<_>>(), [("idle".to_owned(), 2)]);
    }

    #[test]
    fn a_failure_has_the_last_line_and_no_temporary_folder() {
        let run = LockstepRun::new("test", Program::this().expect("a path")).expect("a run");
        assert_eq!(
            run.failure("engine failed", ENGINE).to_string(),
            "engine failed: it printed nothing"
        );
        let path = run.folder().join("scenario.yaml");
        let log = format!("a warning\nregatta: {}: no robots\n\n", path.display());
        fs::write(run.folder().join("engine.log"), log).expect("written");
        assert_eq!(
            run.failure("engine failed", ENGINE).to_string(),
            "engine failed: scenario.yaml: no robots"
        );
    }
}
