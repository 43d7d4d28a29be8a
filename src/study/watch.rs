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
    estimate: RefCell<Estimate>,
    /// The failures of runs that were reported.
    failures: RefCell<BTreeSet<String>>,
    no_room: RefCell<NoRoom>,
}

/// The time of the study's end, as it is expected. Each run changes what is expected of later ones:
/// the shown time follows slowly, so that it doesn't jump.
#[derive(Default)]
struct Estimate(Option<Instant>);

/// The part of the way to a new estimate that the shown one goes, while runs of later rounds are
/// guessed, and in the last round.
const GUESSED: f64 = 0.2;
const LAST: f64 = 0.5;

impl Estimate {
    /// Takes a new estimate of the time that is left, and returns the shown one.
    fn follow(&mut self, now: Instant, to_go: Duration, is_last_round: bool) -> Duration {
        let new = now + to_go;
        let part = if is_last_round { LAST } else { GUESSED };
        let end = match self.0.map(|end| end.max(now)) {
            None => new,
            Some(end) if new > end => end + (new - end).mul_f64(part),
            Some(end) => end - (end - new).mul_f64(part),
        };
        self.0 = Some(end);
        end - now
    }
}

/// The runs of a round in which not all robots found a place: one line tells them all.
#[derive(Default)]
struct NoRoom {
    /// The first of them, and its reason.
    first: Option<(String, String)>,
    runs: u64,
}

impl NoRoom {
    fn add(&mut self, run: &str, reason: &str) {
        self.first.get_or_insert_with(|| (run.to_owned(), reason.to_owned()));
        self.runs += 1;
    }

    /// Takes the line, if there is anything to tell.
    fn take(&mut self) -> Option<String> {
        let Self { first, runs } = std::mem::take(self);
        let (run, reason) = first?;
        Some(match runs {
            1 => format!("{run}: {NOT_ALL_PLACED}: {reason}"),
            runs => format!("in {runs} runs, {NOT_ALL_PLACED}; {run}: {reason}"),
        })
    }
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
            estimate: RefCell::default(),
            failures: RefCell::default(),
            no_room: RefCell::default(),
        }
    }

    /// Returns the number of runs that ended.
    pub fn finished(&self) -> u64 {
        self.finished.get()
    }
}

/// Returns the round, its runs, and the estimate of the rest of the whole study.
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
    /// Tells of runs in which not all robots found a place.
    fn tell_no_room(&self) {
        let line = self.no_room.borrow_mut().take();
        if let Some(line) = line {
            self.say(&line);
        }
    }

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
        self.tell_no_room();
        let is_last = progress.later == Some(0);
        let to_go = progress
            .to_go
            .map(|to_go| self.estimate.borrow_mut().follow(Instant::now(), to_go, is_last));
        let progress = &Progress { to_go, ..*progress };
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
        match failure {
            RunFailure::NoRoom(reason) => self.no_room.borrow_mut().add(run, reason),
            // Many runs mostly fail for the same reason.
            RunFailure::Failed(reason) => {
                if self.failures.borrow_mut().insert(failure.to_string()) {
                    self.say(&format!("{run} failed: {reason}"));
                }
            }
        }
    }

    fn doubt(&self, line: &str) {
        self.say(line);
    }
}

impl Drop for Terminal {
    fn drop(&mut self) {
        self.tell_no_room();
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_estimate_goes_without_jumps_to_what_is_expected() {
        let (mut estimate, start) = (Estimate::default(), Instant::now());
        let mut minutes = |at: u64, to_go: u64, is_last| {
            let now = start + Duration::from_secs(60 * at);
            let to_go = Duration::from_secs(60 * to_go);
            (estimate.follow(now, to_go, is_last).as_secs_f64() / 60.0).round() as u64
        };
        let shown = [(0, 18), (1, 15), (2, 14), (3, 18), (4, 21), (5, 19)]
            .map(|(at, left)| minutes(at, left, false));
        assert_eq!(shown, [18, 17, 15, 15, 15, 15]);
        // The last round is sure of its runs.
        assert_eq!([6, 7, 8].map(|at| minutes(at, 12 - at, true)), [10, 7, 5]);
        assert_eq!(minutes(30, 0, true), 0);
    }

    #[test]
    fn runs_without_room_are_told_at_once() {
        let mut no_room = NoRoom::default();
        assert_eq!(no_room.take(), None);
        for robots in [64, 128] {
            no_room.add(&format!("{robots} robots, seed 1"), &format!("48 of {robots} robots fit"));
        }
        let line = "in 2 runs, not all found a place; 64 robots, seed 1: 48 of 64 robots fit";
        assert_eq!(no_room.take().as_deref(), Some(line));
        assert_eq!(no_room.take(), None);
    }
}
