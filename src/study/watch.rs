//! The progress of a study: runs done, running and expected, and the time that is left.

use std::cell::{Cell, RefCell};
use std::collections::BTreeSet;
use std::io::IsTerminal;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
use regatta_plugin::Termination;
use regatta_study::conduct::{Round, Watcher};
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
    round: Cell<u64>,
    round_started: Cell<Instant>,
    /// The round, and the number of its runs that have ended.
    of_round: Cell<Round>,
    done: Cell<u64>,
    finished: Cell<u64>,
    /// The failures of runs that were reported.
    failures: RefCell<BTreeSet<String>>,
}

impl Terminal {
    /// Begins to watch. The study is interrupted when this process is asked to end.
    pub fn new(termination: Termination) -> Self {
        let bar = std::io::stderr().is_terminal().then(|| {
            let bar = ProgressBar::new(0);
            let template = "{spinner} [{bar:24}] {msg}, {elapsed}";
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
            of_round: Cell::new(Round { runs: 0, side_by_side: 1, later: None }),
            done: Cell::new(0),
            finished: Cell::new(0),
            failures: RefCell::default(),
        }
    }

    /// Returns the number of runs that ended.
    pub fn finished(&self) -> u64 {
        self.finished.get()
    }

    fn tell(&self) {
        let Round { runs, later, .. } = self.of_round.get();
        let (runs, done) = (runs as u64, self.done.get());
        if let Some(bar) = &self.bar {
            bar.set_length(self.finished.get() + runs - done + later.unwrap_or(0) as u64);
            bar.set_position(self.finished.get());
            bar.set_message(self.line());
        } else if done == 0 || self.told.get().elapsed() >= LINE_TIME {
            self.told.set(Instant::now());
            let secs = self.started.elapsed().as_secs();
            regatta_plugin::tell!("{}, {secs} s so far", self.line());
        }
    }

    /// The round, its runs, and the estimate of the rest: of the whole study, once something is
    /// known.
    fn line(&self) -> String {
        let Round { runs, side_by_side, later } = self.of_round.get();
        let (runs, done, round) = (runs as u64, self.done.get(), self.round.get());
        let running = (runs - done).min(side_by_side as u64);
        let line = format!("round {round}: {done} of {runs} runs done, {running} running");
        let (ended, elapsed) = match later {
            Some(_) => (self.finished.get(), self.started.elapsed()),
            None => (done, self.round_started.get().elapsed()),
        };
        let left = runs - done + later.unwrap_or(0) as u64;
        let to_go = match ended {
            0 => String::new(),
            ended => format!(", about {}", minutes(elapsed.mul_f64(left as f64 / ended as f64))),
        };
        match (later, to_go.is_empty()) {
            (Some(later), _) => format!("{line}, some {later} later{to_go} to go in all"),
            (None, false) => format!("{line}{to_go} to go in this round"),
            (None, true) => line,
        }
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
            Some(bar) => bar.suspend(|| regatta_plugin::tell!("{line}")),
            None => regatta_plugin::tell!("{line}"),
        }
    }
}

impl Watcher for Terminal {
    fn is_interrupted(&self) -> bool {
        self.termination.requested()
    }

    fn begin(&self, round: Round) {
        self.of_round.set(round);
        self.round.set(self.round.get() + 1);
        self.done.set(0);
        self.round_started.set(Instant::now());
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
