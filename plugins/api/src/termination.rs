//! Ctrl-C and `SIGTERM`, as a flag.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};

use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};

use crate::error::Result;

/// Environment variable with the id of the process that started this one and watches over it: when that one dies,
/// however it does, this one is asked to end. `regatta run` sets it.
pub const PARENT_VARIABLE: &str = "REGATTA_PARENT";

static REQUESTED: OnceLock<Arc<AtomicBool>> = OnceLock::new();

/// Whether this process was asked to end: by Ctrl-C, `SIGTERM`, or its terminal being closed.
///
/// Only these count: a process that is stopped and continued goes on. A second Ctrl-C ends the process at
/// once, for when it hangs; its shared memory is then cleaned up by the next process to join a fleet.
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
        let interrupted = Arc::new(AtomicBool::new(false));
        // First, so that the first Ctrl-C finds `interrupted` unset.
        signal_hook::flag::register_conditional_shutdown(SIGINT, 130, Arc::clone(&interrupted))?;
        signal_hook::flag::register(SIGINT, interrupted)?;
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
