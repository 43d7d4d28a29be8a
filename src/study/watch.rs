//! The progress of a study: runs done, running and remaining, and the remaining time.

use std::cell::{Cell, RefCell};
use std::collections::BTreeSet;
use std::io::IsTerminal;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
use regatta_plugin::Termination;
use regatta_study::conduct::Watcher;
use regatta_study::workers::RunFailure;

/// The time between two lines where standard error isn't a terminal.
const LINE_TIME: Duration = Duration::from_secs(15);

/// Shows a study on standard error.
pub struct Terminal {
    termination: Termination,
    bar: Option<ProgressBar>,
    started: Instant,
    /// The time when the last line was written.
    told: Cell<Instant>,
    round: Cell<u64>,
    round_started: Cell<Instant>,
    /// The number of runs of this round.
    runs: Cell<u64>,
    /// The number of runs that have ended.
    done: Cell<u64>,
    finished: Cell<u64>,
    side_by_side: Cell<u64>,
    /// The failures of runs that were reported.
    failures: RefCell<BTreeSet<String>>,
}

impl Terminal {
    /// Begins to watch. The study is interrupted when this process is asked to end.
    pub fn new(termination: Termination) -> Self {
        let bar = std::io::stderr().is_terminal().then(|| {
            let bar = ProgressBar::new(0);
            let template = "{spinner} [{bar:24}] {msg}, {pos} of {len} runs done, {elapsed}, \
                            {eta} to go in this round";
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
            round: Cell::new(0),
            round_started: Cell::new(now),
            runs: Cell::new(0),
            done: Cell::new(0),
            finished: Cell::new(0),
            side_by_side: Cell::new(1),
            failures: RefCell::default(),
        }
    }

    /// Returns the number of runs that ended.
    pub fn finished(&self) -> u64 {
        self.finished.get()
    }

    fn tell(&self) {
        let (runs, done, round) = (self.runs.get(), self.done.get(), self.round.get());
        let running = (runs - done).min(self.side_by_side.get());
        if let Some(bar) = &self.bar {
            bar.set_length(runs);
            bar.set_position(done);
            bar.set_message(format!("round {round}, {running} running"));
            return;
        }
        if done == 0 || self.told.get().elapsed() >= LINE_TIME {
            self.told.set(Instant::now());
            let secs = self.started.elapsed().as_secs();
            let of_round = self.round_started.get().elapsed().as_secs_f64();
            let to_go = if done > 0 {
                let left = of_round / done as f64 * (runs - done) as f64;
                format!(", {left:.0} s to go in this round")
            } else {
                String::new()
            };
            regatta_plugin::tell!(
                "round {round}: {done} of {runs} runs done, {running} running, {secs} s so \
                 far{to_go}"
            );
        }
    }
}

impl Terminal {
    /// Writes a line above the bar.
    fn say(&self, line: &str) {
        match &self.bar {
            Some(bar) => bar.suspend(|| regatta_plugin::tell!("{line}")),
            None => regatta_plugin::tell!("{line}"),
        }
    }
}

impl Watcher for Terminal {
    fn is_interrupted(&self) -> bool {
        self.termination.requested()
    }

    fn begin(&self, runs: usize, side_by_side: usize) {
        self.side_by_side.set(side_by_side as u64);
        self.round.set(self.round.get() + 1);
        self.runs.set(runs as u64);
        self.done.set(0);
        self.round_started.set(Instant::now());
        if let Some(bar) = &self.bar {
            bar.reset_eta();
        }
        self.tell();
    }

    fn end(&self) {
        self.done.set(self.done.get() + 1);
        self.finished.set(self.finished.get() + 1);
        self.tell();
    }

    fn fail(&self, run: &str, failure: &RunFailure) {
        // Many runs mostly fail for the same reason.
        if self.failures.borrow_mut().insert(failure.to_string()) {
            let line = match failure {
                RunFailure::NoRoom(reason) => format!("{run}: no room: {reason}"),
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
