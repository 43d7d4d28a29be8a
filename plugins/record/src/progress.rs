//! Shows the progress of long tasks, and ends them on Ctrl-C.

use std::io::{IsTerminal, stderr};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
use regatta_plugin::Termination;

/// A task that takes no longer than this shows no progress.
const PATIENCE: Duration = Duration::from_secs(2);
/// The time between two pictures of the bar.
const REFRESH: Duration = Duration::from_millis(100);
/// The time between two lines, if standard error isn't a terminal.
const LINE_PERIOD: Duration = Duration::from_secs(10);
/// The length of the bar.
const STEPS: u64 = 1000;

/// The process was asked to end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Interrupted;

/// The progress of one task. On a terminal it is a bar, elsewhere a line now and then.
#[derive(Debug)]
pub(crate) struct Progress {
    name: &'static str,
    /// The time of the next picture; `None` if none is shown.
    next: Option<Instant>,
    bar: Option<ProgressBar>,
    termination: Option<Termination>,
}

impl Progress {
    /// Starts a task. Ctrl-C and `SIGTERM` no longer end the process, but the task.
    pub fn start(name: &'static str) -> Self {
        // Without signal handlers the process ends at once, as any program does.
        let termination = Termination::watch().ok();
        Self { name, next: Some(Instant::now() + PATIENCE), bar: None, termination }
    }

    /// Returns the progress of a task that shows nothing and isn't interrupted.
    pub fn hidden() -> Self {
        Self { name: "", next: None, bar: None, termination: None }
    }

    /// Reports the part of the task that is done, from 0 to 1.
    pub fn report(&mut self, done: f64) -> Result<(), Interrupted> {
        if self.termination.as_ref().is_some_and(Termination::requested) {
            return Err(Interrupted);
        }
        let now = Instant::now();
        if self.next.is_some_and(|next| now >= next) {
            self.next = Some(now + self.show(done.clamp(0.0, 1.0)));
        }
        Ok(())
    }

    /// Shows the progress, and returns the time until the next picture of it.
    fn show(&mut self, done: f64) -> Duration {
        if !stderr().is_terminal() {
            regatta_plugin::tell!("regatta: {}: {:.0} % done", self.name, done * 100.0);
            return LINE_PERIOD;
        }
        let bar = self.bar.get_or_insert_with(|| {
            let style = ProgressStyle::with_template("{prefix} {wide_bar} {percent} %, {eta} left");
            ProgressBar::new(STEPS)
                .with_prefix(self.name)
                .with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
        });
        bar.set_position((done * STEPS as f64) as u64);
        REFRESH
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

impl From<Interrupted> for std::io::Error {
    fn from(_: Interrupted) -> Self {
        Self::new(std::io::ErrorKind::Interrupted, "interrupted")
    }
}
