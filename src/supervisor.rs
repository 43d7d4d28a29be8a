//! Child processes: starts them, watches them and stops them together.

use std::process::{Child, Command, ExitStatus};
use std::time::{Duration, Instant};

use regatta_plugin::{NAME_VARIABLE, PARENT_VARIABLE, health};

use crate::failure::Failure;

/// The longest time that a child may take to end after a request to end.
const GRACE_PERIOD: Duration = Duration::from_secs(5);

/// A running child process, and its name in messages.
struct NamedChild {
    name: String,
    child: Child,
}

/// The running child processes. Dropping the supervisor stops them all.
#[derive(Default)]
pub struct Supervisor {
    children: Vec<NamedChild>,
}

/// A child process that has ended.
#[derive(Debug)]
pub struct EndedChild {
    /// Its name in messages.
    pub name: String,
    /// Its exit code, or the signal that ended it.
    pub status: ExitStatus,
}

impl EndedChild {
    /// Returns the message for the user if the child failed.
    pub fn failure(&self) -> Option<String> {
        (!self.status.success()).then(|| format!("{} failed ({})", self.name, self.status))
    }
}

impl Supervisor {
    /// Starts a child process and returns its process id.
    pub fn start(&mut self, name: &str, command: &mut Command) -> Result<u32, Failure> {
        let child = command
            .env(PARENT_VARIABLE, std::process::id().to_string())
            .env(NAME_VARIABLE, name)
            .spawn()
            .map_err(|error| {
                format!("can't start {name} ({}): {error}", command.get_program().to_string_lossy())
            })?;
        let id = child.id();
        self.children.push(NamedChild { name: name.into(), child });
        Ok(id)
    }

    /// Removes and returns the children that have ended since the last call.
    pub fn take_ended(&mut self) -> Vec<EndedChild> {
        let mut ended = Vec::new();
        self.children.retain_mut(|named| match named.child.try_wait() {
            Ok(Some(status)) => {
                ended.push(EndedChild { name: std::mem::take(&mut named.name), status });
                false
            }
            _ => true,
        });
        ended
    }

    /// Asks all children to end, kills those that don't end within the grace period, and returns a
    /// message for each failure.
    pub fn stop(&mut self) -> Vec<String> {
        for named in &self.children {
            request_end(&named.child);
        }
        let deadline = Instant::now() + GRACE_PERIOD;
        let mut failures = Vec::new();
        while !self.children.is_empty() && Instant::now() < deadline {
            failures.extend(self.take_ended().iter().filter_map(EndedChild::failure));
            std::thread::sleep(Duration::from_millis(5));
        }
        let any_killed = !self.children.is_empty();
        for mut named in self.children.drain(..) {
            failures.push(format!(
                "{} did not end within {} s and was killed",
                named.name,
                GRACE_PERIOD.as_secs()
            ));
            // An error means that the child has just ended by itself.
            let _ = named.child.kill();
            let _ = named.child.wait();
        }
        if any_killed {
            // A killed process can't remove its own shared memory. If this fails, `regatta doctor`
            // shows why.
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
fn request_end(child: &Child) {
    use rustix::process::{Pid, Signal, kill_process};
    if let Some(pid) = Pid::from_raw(child.id() as i32) {
        // An error means that the child has just ended by itself.
        let _ = kill_process(pid, Signal::TERM);
    }
}

/// Does nothing: without signals, the child is killed at the end of the grace period.
#[cfg(not(unix))]
fn request_end(_child: &Child) {}
