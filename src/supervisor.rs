//! The child processes of `regatta run`: started together, watched, stopped together.

use std::process::{Child, Command, ExitStatus};
use std::time::{Duration, Instant};

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
    /// Starts a child.
    pub fn start(&mut self, name: &str, command: &mut Command) -> Result<(), Failure> {
        let child = command
            .spawn()
            .map_err(|error| format!("can't start {name} ({}): {error}", command.get_program().to_string_lossy()))?;
        self.processes.push(Process { name: name.into(), child });
        Ok(())
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
        for mut process in self.processes.drain(..) {
            failures.push(format!("{} did not end within {} s and was killed", process.name, GRACE.as_secs()));
            // Errors mean that it has just ended by itself.
            let _ = process.child.kill();
            let _ = process.child.wait();
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

/// Arguments that make an engine [die with](die_with_parent) this process.
pub fn child_args() -> [String; 2] {
    ["--die-with-parent".to_owned(), std::process::id().to_string()]
}

/// Makes the system end this process when the one of that id, which started it, dies, however that happens.
pub fn die_with_parent(id: u32) -> Result<(), Failure> {
    #[cfg(target_os = "linux")]
    {
        use rustix::process::{Pid, Signal, getppid, set_parent_process_death_signal};
        let _ = set_parent_process_death_signal(Some(Signal::TERM));
        // It may have died before that call: then another process has adopted this one.
        if getppid() != Pid::from_raw(id as i32) {
            return Err(format!("process {id}, which started this one, has ended").into());
        }
    }
    Ok(())
}
