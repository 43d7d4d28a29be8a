//! The progress of a study: runs done, running and expected, and the time that is left.

use std::cell::{Cell, RefCell};
use std::collections::BTreeSet;
use std::io::IsTerminal;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
use regatta_plugin::Termination;
use regatta_study::conduct::{Progress, Watcher};
use regatta_study::workers::{NOT_ALL_PLACED, RunFailure};

/// The time between two lines where standard error isn't a terminal.
const LINE_TIME: Duration = Duration::from_secs(15);

/// Shows a study on standard error.
pub struct Terminal {
    termination: Termination,
    bar: Option<ProgressBar>,
    started: Instant,
    /// The time when the last line was written.
    told: Cell<Instant>,
    finished: Cell<u64>,
    /// The failures of runs that were reported.
    failures: RefCell<BTreeSet<String>>,
}

impl Terminal {
    /// Begins to watch. The study is interrupted when this process is asked to end.
    pub fn new(termination: Termination) -> Self {
        let bar = std::io::stderr().is_terminal().then(|| {
            let bar = ProgressBar::new(0);
            let template = "{spinner} [{bar:24}] {msg}, {elapsed} so far";
            let style = ProgressStyle::with_template(template);
            bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
            bar.enable_steady_tick(Duration::from_millis(200));
            bar
        });
        let now = Instant::now();
        Self {
            termination,
            bar,
            started: now,
            told: Cell::new(now),
            finished: Cell::new(0),
            failures: RefCell::default(),
        }
    }

    /// Returns the number of runs that ended.
    pub fn finished(&self) -> u64 {
        self.finished.get()
    }
}

/// Returns the round, its runs, and the estimate of the rest: of the whole study, once something is
/// known of later rounds.
fn line(progress: &Progress) -> String {
    let Progress { round, runs, done, running, later, to_go, .. } = progress;
    let line = format!("round {round}: {done} of {runs} runs done, {running} running");
    let to_go = to_go.map(|time| format!(", about {} to go", minutes(time))).unwrap_or_default();
    match later {
        Some(0) => format!("{line}{to_go}"),
        Some(later) if to_go.is_empty() => format!("{line}, some {later} later"),
        Some(later) => format!("{line}, some {later} later{to_go} in all"),
        None if to_go.is_empty() => line,
        None => format!("{line}{to_go} in this round"),
    }
}

/// A time that is left, as a text.
fn minutes(time: Duration) -> String {
    match time.as_secs() {
        secs @ ..120 => format!("{secs} s"),
        secs => format!("{} min", secs.div_ceil(60)),
    }
}

impl Terminal {
    /// Writes a line above the bar.
    fn say(&self, line: &str) {
        match &self.bar {
            Some(bar) => bar.suspend(|| regatta_plugin::tell!("study: {line}")),
            None => regatta_plugin::tell!("study: {line}"),
        }
    }
}

impl Watcher for Terminal {
    fn is_interrupted(&self) -> bool {
        self.termination.requested()
    }

    fn progress(&self, progress: &Progress) {
        self.finished.set(progress.finished);
        if let Some(bar) = &self.bar {
            let left = progress.runs - progress.done + progress.later.unwrap_or(0);
            bar.set_length(progress.finished + left as u64);
            bar.set_position(progress.finished);
            bar.set_message(line(progress));
        } else if progress.done == 0 || self.told.get().elapsed() >= LINE_TIME {
            self.told.set(Instant::now());
            let secs = self.started.elapsed().as_secs();
            regatta_plugin::tell!("study: {}, {secs} s so far", line(progress));
        }
    }

    fn fail(&self, run: &str, failure: &RunFailure) {
        // Many runs mostly fail for the same reason.
        if self.failures.borrow_mut().insert(failure.to_string()) {
            let line = match failure {
                RunFailure::NoRoom(reason) => format!("{run}: {NOT_ALL_PLACED}: {reason}"),
                RunFailure::Failed(reason) => format!("{run} failed: {reason}"),
            };
            self.say(&line);
        }
    }

    fn doubt(&self, line: &str) {
        self.say(line);
    }
}

impl Drop for Terminal {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}
