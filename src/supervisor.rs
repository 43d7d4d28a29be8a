//! The child processes of `regatta run`: started together, watched, stopped together.

use std::process::{Child, Command, ExitStatus};
use std::time::{Duration, Instant};

use regatta_plugin::{NAME_VARIABLE, PARENT_VARIABLE, health};

use crate::Failure;

/// How long a child may take to end after it was asked to.
const GRACE: Duration = Duration::from_secs(5);

/// A child process by the name that messages call it.
struct Process {
    name: String,
    child: Child,
}

/// The running children. Dropping it stops them all.
#[derive(Default)]
pub struct Supervisor {
    processes: Vec<Process>,
}

/// A child that ended by itself.
pub struct Ended {
    pub name: String,
    pub status: ExitStatus,
}

impl Ended {
    /// What to tell the user, unless the child ended well.
    pub fn failure(&self) -> Option<String> {
        (!self.status.success()).then(|| format!("{} failed ({})", self.name, self.status))
    }
}

impl Supervisor {
    /// Starts a child, and returns its id.
    pub fn start(&mut self, name: &str, command: &mut Command) -> Result<u32, Failure> {
        let child =
            command.env(PARENT_VARIABLE, std::process::id().to_string()).env(NAME_VARIABLE, name).spawn().map_err(
                |error| format!("can't start {name} ({}): {error}", command.get_program().to_string_lossy()),
            )?;
        let id = child.id();
        self.processes.push(Process { name: name.into(), child });
        Ok(id)
    }

    /// The children that have ended since the last call.
    pub fn ended(&mut self) -> Vec<Ended> {
        let mut ended = Vec::new();
        self.processes.retain_mut(|process| match process.child.try_wait() {
            Ok(Some(status)) => {
                ended.push(Ended { name: std::mem::take(&mut process.name), status });
                false
            }
            _ => true,
        });
        ended
    }

    /// Asks all children to end, waits, kills those that don't, and names what failed.
    pub fn stop(&mut self) -> Vec<String> {
        for process in &self.processes {
            ask_to_end(&process.child);
        }
        let patience = Instant::now() + GRACE;
        let mut failures = Vec::new();
        while !self.processes.is_empty() && Instant::now() < patience {
            failures.extend(self.ended().iter().filter_map(Ended::failure));
            std::thread::sleep(Duration::from_millis(5));
        }
        let hung = !self.processes.is_empty();
        for mut process in self.processes.drain(..) {
            failures.push(format!("{} did not end within {} s and was killed", process.name, GRACE.as_secs()));
            // Errors mean that it has just ended by itself.
            let _ = process.child.kill();
            let _ = process.child.wait();
        }
        if hung {
            // What a killed process leaves in shared memory, it can't clean up itself.
            // Where that fails, `regatta doctor` says why.
            let _ = health::clean();
        }
        failures
    }
}

impl Drop for Supervisor {
    fn drop(&mut self) {
        self.stop();
    }
}

#[cfg(unix)]
fn ask_to_end(child: &Child) {
    use rustix::process::{Pid, Signal, kill_process};
    if let Some(pid) = Pid::from_raw(child.id() as i32) {
        // An error means that it has just ended by itself.
        let _ = kill_process(pid, Signal::TERM);
    }
}

/// Elsewhere there is no gentle way: the grace period ends with a kill.
#[cfg(not(unix))]
fn ask_to_end(_child: &Child) {}
