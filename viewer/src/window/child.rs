//! Programs that the window starts: child processes of this executable, whose last line on standard
//! error is kept.

use std::ffi::OsString;
use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};
use std::sync::Arc;

use parking_lot::Mutex;
use regatta_plugin::PARENT_VARIABLE;

/// A running program. It ends with this process at the latest.
#[derive(Debug)]
pub struct ChildProcess {
    /// The process.
    pub child: Child,
    /// The last line of its standard error output.
    last_line: Arc<Mutex<String>>,
}

impl ChildProcess {
    /// Starts this executable with arguments. `name` is that of the thread that reads its errors.
    ///
    /// # Errors
    /// If it can't be started.
    pub fn start(name: &str, args: impl IntoIterator<Item = OsString>) -> std::io::Result<Self> {
        let mut child = Command::new(std::env::current_exe()?)
            .args(args)
            .env(PARENT_VARIABLE, std::process::id().to_string())
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()?;
        let last_line = Arc::new(Mutex::new(String::new()));
        if let Some(stderr) = child.stderr.take() {
            let last = Arc::clone(&last_line);
            // The thread ends with the child.
            std::thread::Builder::new().name(name.into()).spawn(move || {
                for line in BufReader::new(stderr).lines().map_while(Result::ok) {
                    *last.lock() = line;
                }
            })?;
        }
        Ok(Self { child, last_line })
    }

    /// Whether it still runs.
    pub fn is_running(&mut self) -> bool {
        matches!(self.child.try_wait(), Ok(None))
    }

    /// Returns the message of a program that has ended: `Some(None)` if it was successful.
    pub fn outcome(&mut self) -> Option<Option<String>> {
        let status = self.child.try_wait().ok()??;
        let line = self.last_line.lock().clone();
        let line = line.trim_start_matches("regatta: ");
        Some((!status.success()).then(|| format!("{line} ({status})")))
    }
}
