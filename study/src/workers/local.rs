//! Processes on this machine.

use std::io::Read;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use super::{NO_ROOM, Report, RunFailure, Task, UNWRITABLE, Workers, WorkersError};

/// The time between two checks of the processes.
const POLL_INTERVAL: Duration = Duration::from_millis(5);

/// Processes on this machine, some at a time.
#[derive(Clone, Debug)]
pub struct Local {
    /// This program.
    program: PathBuf,
    /// Further arguments of `study-run`.
    args: Vec<String>,
    size: usize,
}

struct Running<'a> {
    task: &'a Task,
    child: Child,
    started: Instant,
}

impl Local {
    /// Makes workers of a program that knows `study-run`, with further arguments for it.
    pub fn new(program: PathBuf, args: Vec<String>, size: usize) -> Self {
        Self { program, args, size: size.max(1) }
    }

    /// Returns the command that does a task.
    fn command(&self, task: &Task) -> Command {
        let mut command = Command::new(&self.program);
        command.arg("study-run").arg(&task.job).arg("--layout").arg(&task.layout);
        command.arg("--output").arg(&task.result).args(&self.args);
        // The job follows from the user's own plant and options.
        command.arg("--trust");
        command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped());
        command
    }

    fn start<'a>(&self, task: &'a Task) -> Result<Running<'a>, WorkersError> {
        match self.command(task).spawn() {
            Ok(child) => Ok(Running { task, child, started: Instant::now() }),
            Err(reason) => {
                Err(WorkersError::Start { program: self.program.display().to_string(), reason })
            }
        }
    }
}

impl Running<'_> {
    /// Returns the report of a process that has ended.
    fn report(&mut self) -> Option<Result<Report, WorkersError>> {
        let status = self.child.try_wait().ok()??;
        let id = self.task.id.clone();
        let wall_secs = Some(self.started.elapsed().as_secs_f64());
        if status.success() {
            return Some(Ok(Report { id, failure: None, wall_secs }));
        }
        let mut text = String::new();
        if let Some(mut stderr) = self.child.stderr.take() {
            // A few lines, which fit into the pipe: they are there as a whole.
            let _ = stderr.read_to_string(&mut text);
        }
        let line = text
            .lines()
            .rfind(|line| !line.trim().is_empty())
            .unwrap_or("it ended without a message");
        let line = line.trim_start_matches("regatta: ").to_owned();
        Some(match status.code() {
            Some(code) if code == i32::from(UNWRITABLE) => Err(WorkersError::Output(line)),
            Some(code) if code == i32::from(NO_ROOM) => {
                Ok(Report { id, failure: Some(RunFailure::NoRoom(line)), wall_secs })
            }
            _ => Ok(Report { id, failure: Some(RunFailure::Failed(line)), wall_secs }),
        })
    }
}

impl Drop for Running<'_> {
    fn drop(&mut self) {
        if self.child.try_wait().is_ok_and(|status| status.is_none()) {
            request_end(&mut self.child);
            let _ = self.child.wait();
        }
    }
}

impl Workers for Local {
    fn run(
        &mut self,
        tasks: &[Task],
        is_interrupted: &dyn Fn() -> bool,
        on_report: &mut dyn FnMut(Report),
    ) -> Result<(), WorkersError> {
        let mut left = tasks.iter();
        let mut running: Vec<Running<'_>> = Vec::new();
        loop {
            while running.len() < self.size
                && let Some(task) = left.next()
            {
                running.push(self.start(task)?);
            }
            if running.is_empty() {
                return Ok(());
            }
            std::thread::sleep(POLL_INTERVAL);
            // An interrupt reaches the processes, too: their messages then are no failures.
            if is_interrupted() {
                return Err(WorkersError::Interrupted);
            }
            let mut index = 0;
            while let Some(process) = running.get_mut(index) {
                match process.report() {
                    Some(report) => {
                        on_report(report?);
                        drop(running.swap_remove(index));
                    }
                    None => index += 1,
                }
            }
        }
    }

    fn size(&self) -> usize {
        self.size
    }
}

/// Asks a process to end, so that it removes its shared memory.
#[cfg(unix)]
fn request_end(child: &mut Child) {
    use rustix::process::{Pid, Signal, kill_process};
    if let Some(pid) = Pid::from_raw(child.id() as i32) {
        // An error means that it has just ended by itself.
        let _ = kill_process(pid, Signal::TERM);
    }
}

/// Kills a process: there are no signals.
#[cfg(not(unix))]
fn request_end(child: &mut Child) {
    let _ = child.kill();
}
