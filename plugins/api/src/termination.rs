//! Ctrl-C and `SIGTERM`, as a flag.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::Instant;

use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};

use crate::error::Result;

/// Environment variable with the id of the process that started this one and watches over it: when that one dies,
/// however it does, this one is asked to end. `regatta run` sets it.
pub const PARENT_VARIABLE: &str = "REGATTA_PARENT";

static REQUESTED: OnceLock<Arc<AtomicBool>> = OnceLock::new();

/// Least time in milliseconds between two wishes of a person.
const SECOND_WISH_MILLIS: u64 = 200;

/// Ends the process at the second Ctrl-C, whatever it is doing.
#[expect(unsafe_code, reason = "only a handler knows when a signal came while the process hangs")]
fn end_at_second_interrupt() -> Result {
    let start = Instant::now();
    // Milliseconds from the start, and one.
    let first = AtomicU64::new(0);
    let handler = move || {
        let now = u64::try_from(start.elapsed().as_millis()).unwrap_or(u64::MAX - 1) + 1;
        let before = first.compare_exchange(0, now, Ordering::Relaxed, Ordering::Relaxed);
        if before.is_err_and(|first| now.saturating_sub(first) >= SECOND_WISH_MILLIS) {
            signal_hook::low_level::exit(130);
        }
    };
    // SAFETY: it does only what a signal handler may: it reads the monotonic clock (`clock_gettime`), changes an atomic
    // number, and ends the process by `_exit`. It takes no lock, allocates nothing and can't panic.
    unsafe { signal_hook::low_level::register(SIGINT, handler)? };
    Ok(())
}

/// Whether this process was asked to end: by Ctrl-C, `SIGTERM`, or its terminal being closed.
///
/// Only these count: a process that is stopped and continued goes on. A second Ctrl-C, 200 ms or more after the first,
/// ends the process at once, for when it hangs; its shared memory is then cleaned up by the next process to join a fleet.
/// (One person's wish may arrive twice: from the terminal, and from a program that passes it on.)
///
/// A file that has grown to its limit (`ulimit -f`) is an error of writing, no reason to be killed (`SIGXFSZ`).
#[derive(Clone, Debug)]
pub struct Termination(Arc<AtomicBool>);

impl Termination {
    /// Takes over the signals, once per process; from then on they only set the flag.
    ///
    /// # Errors
    /// If the operating system refuses.
    pub fn watch() -> Result<Self> {
        if let Some(requested) = REQUESTED.get() {
            return Ok(Self(Arc::clone(requested)));
        }
        let requested = Arc::new(AtomicBool::new(false));
        end_at_second_interrupt()?;
        // A handler is enough: the write then fails. Nobody looks at the flag.
        #[cfg(unix)]
        signal_hook::flag::register(signal_hook::consts::SIGXFSZ, Arc::default())?;
        for signal in [SIGINT, SIGTERM, SIGHUP] {
            signal_hook::flag::register(signal, Arc::clone(&requested))?;
        }
        let termination = Self(Arc::clone(REQUESTED.get_or_init(|| requested)));
        if let Some(parent) = std::env::var(PARENT_VARIABLE).ok().and_then(|id| id.parse().ok()) {
            termination.follow(parent);
        }
        Ok(termination)
    }

    /// Asks for the end when the process of that id, which started this one, has ended.
    #[cfg(target_os = "linux")]
    fn follow(&self, parent: i32) {
        use rustix::process::{Pid, Signal, getppid, set_parent_process_death_signal, test_kill_process};
        let Some(parent) = Pid::from_raw(parent) else { return };
        if getppid() == Some(parent) {
            // An error leaves a process that has to be ended by hand.
            let _ = set_parent_process_death_signal(Some(Signal::TERM));
        }
        // It may have died before that call, or be an ancestor further up, which is none of our business.
        if getppid() != Some(parent) && test_kill_process(parent).is_err() {
            self.0.store(true, Ordering::Relaxed);
        }
    }

    /// Elsewhere there is no way to be told.
    #[cfg(not(target_os = "linux"))]
    fn follow(&self, _parent: i32) {}

    /// Whether this process [watches](Self::watch) and was asked to end.
    pub(crate) fn was_requested() -> bool {
        REQUESTED.get().is_some_and(|requested| requested.load(Ordering::Relaxed))
    }

    /// Whether the process was asked to end.
    pub fn requested(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}
