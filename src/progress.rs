//! Progress of long work: nothing for a second, then a bar on a terminal, and a line now and then
//! elsewhere.

use std::io::IsTerminal;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
use parking_lot::Mutex;
use regatta_plugin::visible;

/// The time until progress is shown.
const QUIET_TIME: Duration = Duration::from_secs(1);
/// The time between two updates of a bar.
const FRAME_TIME: Duration = Duration::from_millis(100);
/// The time between two lines where standard error isn't a terminal.
const LINE_TIME: Duration = Duration::from_secs(15);

/// Shows the work of a command on standard error, until it is dropped.
pub struct Progress {
    state: Arc<State>,
    /// Dropped to end the thread.
    end: Option<mpsc::Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

struct State {
    /// The number of steps; 0 if it is unknown.
    steps: u64,
    done: AtomicU64,
    current: Mutex<String>,
    started: Instant,
}

impl Progress {
    /// Begins work of a number of steps, 0 if that isn't known. `current` describes the first step.
    pub fn start(current: impl Into<String>, steps: u64) -> Self {
        let current = Mutex::new(current.into());
        let state =
            Arc::new(State { steps, done: AtomicU64::new(0), current, started: Instant::now() });
        let (end, ended) = mpsc::channel();
        let shown = Arc::clone(&state);
        let thread =
            std::thread::Builder::new().name("progress".into()).spawn(move || show(&shown, &ended));
        // Without a thread, no progress is shown, which isn't a reason to fail.
        Self { state, end: Some(end), thread: thread.ok() }
    }

    /// Ends a step. `next` describes the next one.
    pub fn step(&self, next: impl Into<String>) {
        self.state.done.fetch_add(1, Ordering::Relaxed);
        self.set_current(next);
    }

    /// Sets the description of the present step.
    pub fn set_current(&self, current: impl Into<String>) {
        *self.state.current.lock() = current.into();
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.end = None;
        // The thread can't panic: it prints nothing to a closed standard error.
        let _ = self.thread.take().map(JoinHandle::join);
    }
}

impl State {
    fn current(&self) -> String {
        self.current.lock().clone()
    }

    fn line(&self) -> String {
        let (current, secs) = (self.current(), self.started.elapsed().as_secs());
        match self.steps {
            0 => format!("{current}: {secs} s"),
            steps => format!(
                "{current}: {} of {steps} done after {secs} s",
                self.done.load(Ordering::Relaxed)
            ),
        }
    }
}

fn show(state: &State, ended: &mpsc::Receiver<()>) {
    if is_over(ended, QUIET_TIME) {
        return;
    }
    if !std::io::stderr().is_terminal() {
        regatta_plugin::tell!("regatta: {}", state.line());
        while !is_over(ended, LINE_TIME) {
            regatta_plugin::tell!("regatta: {}", state.line());
        }
        return;
    }
    let bar = bar(state);
    while !is_over(ended, FRAME_TIME) {
        bar.set_position(state.done.load(Ordering::Relaxed));
        bar.set_message(visible(&state.current()).into_owned());
        bar.tick();
    }
    bar.finish_and_clear();
}

/// Waits for the end of the work, and returns whether it came.
fn is_over(ended: &mpsc::Receiver<()>, time: Duration) -> bool {
    ended.recv_timeout(time) != Err(RecvTimeoutError::Timeout)
}

fn bar(state: &State) -> ProgressBar {
    let (bar, template) = match state.steps {
        0 => (ProgressBar::new_spinner(), "{spinner} {msg} {elapsed}"),
        steps => (ProgressBar::new(steps), "{spinner} [{bar:24}] {pos}/{len} {msg} {elapsed}"),
    };
    let bar = bar.with_elapsed(state.started.elapsed());
    match ProgressStyle::with_template(template) {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_names_the_step_and_the_count() {
        let progress = Progress::start("reading", 0);
        assert_eq!(progress.state.line(), "reading: 0 s");
        let progress = Progress::start("first", 2);
        progress.step("second");
        assert_eq!(progress.state.line(), "second: 1 of 2 done after 0 s");
    }
}
