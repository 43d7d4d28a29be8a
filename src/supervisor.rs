//! Child processes: starts them, watches them and stops them together.

use std::process::{Child, Command, ExitStatus};
use std::time::{Duration, Instant};

use regatta_plugin::{FINISHING_VARIABLE, NAME_VARIABLE, PARENT_VARIABLE, health};
use tempfile::NamedTempFile;

use crate::failure::Failure;

/// The longest time after a request to end in which a child neither ends nor says that it still
/// saves its work.
const GRACE_PERIOD: Duration = Duration::from_secs(5);
/// The longest time that a child may save its work.
const LONGEST_SAVING: Duration = Duration::from_mins(10);

/// The time after which the user is told that a child saves its work.
const TELL_AFTER: Duration = Duration::from_secs(1);
/// The time between two looks at children that were asked to end.
const POLL_INTERVAL: Duration = Duration::from_millis(5);

/// A running child process, and its name in messages.
struct NamedChild {
    name: String,
    child: Child,
    /// The file that grows while it saves its work.
    signs: Option<NamedTempFile>,
    /// The length of that file.
    seen: u64,
    /// The last time when it grew, or the child was asked to end.
    seen_at: Instant,
    /// Whether the user knows that it still saves its work.
    is_told: bool,
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

impl NamedChild {
    fn ask_to_end(&mut self) {
        self.seen_at = Instant::now();
        request_end(&self.child);
    }

    /// Notes whether it still saves its work, and tells the user if that takes long.
    fn look_for_signs(&mut self, asked: Instant) {
        let signs = self.signs.as_ref().and_then(|file| file.as_file().metadata().ok());
        let length = signs.map_or(0, |signs| signs.len());
        if length == self.seen {
            return;
        }
        if asked.elapsed() >= TELL_AFTER && !std::mem::replace(&mut self.is_told, true) {
            regatta_plugin::tell!(
                "regatta: {} is still saving its work; another Ctrl-C kills it",
                self.name
            );
        }
        (self.seen, self.seen_at) = (length, Instant::now());
    }

    /// Kills it if it is too late, and returns the message for the user.
    fn kill_if_late(&mut self, asked: Instant) -> Option<String> {
        self.look_for_signs(asked);
        let message = if asked.elapsed() >= LONGEST_SAVING {
            format!("did not end within {} s", LONGEST_SAVING.as_secs())
        } else if self.seen_at.elapsed() < GRACE_PERIOD {
            return None;
        } else if self.seen > 0 {
            format!("made no progress for {} s at its end", GRACE_PERIOD.as_secs())
        } else {
            format!("did not end within {} s", GRACE_PERIOD.as_secs())
        };
        // An error means that the child has just ended by itself.
        let _ = self.child.kill();
        let _ = self.child.wait();
        Some(format!("{} {message} and was killed", self.name))
    }
}

impl Supervisor {
    /// Starts a child process and returns its process id.
    pub fn start(&mut self, name: &str, command: &mut Command) -> Result<u32, Failure> {
        let signs = NamedTempFile::new().ok();
        command.env_remove(FINISHING_VARIABLE);
        command.envs(signs.as_ref().map(|file| (FINISHING_VARIABLE, file.path())));
        let child = command
            .env(PARENT_VARIABLE, std::process::id().to_string())
            .env(NAME_VARIABLE, name)
            .spawn()
            .map_err(|error| {
                format!("can't start {name} ({}): {error}", command.get_program().to_string_lossy())
            })?;
        let id = child.id();
        let (name, seen_at) = (name.into(), Instant::now());
        self.children.push(NamedChild { name, child, signs, seen: 0, seen_at, is_told: false });
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

    /// Asks all children to end, kills those that neither end nor save their work, and returns a
    /// message for each failure.
    pub fn stop(&mut self) -> Vec<String> {
        self.children.iter_mut().for_each(NamedChild::ask_to_end);
        let asked = Instant::now();
        let (mut failures, mut killed) = (Vec::new(), Vec::new());
        while !self.children.is_empty() {
            failures.extend(self.take_ended().iter().filter_map(EndedChild::failure));
            self.children.retain_mut(|named| {
                let message = named.kill_if_late(asked);
                let stays = message.is_none();
                killed.extend(message);
                stays
            });
            std::thread::sleep(POLL_INTERVAL);
        }
        if !killed.is_empty() {
            // A killed process can't remove its own shared memory. If this fails, `regatta doctor`
            // shows why.
            let _ = health::clean();
        }
        failures.append(&mut killed);
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
