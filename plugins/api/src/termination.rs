//! Ctrl-C and `SIGTERM`, as a flag.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};

use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};

use crate::error::Result;

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
        Ok(Self(Arc::clone(REQUESTED.get_or_init(|| requested))))
    }

    /// Whether the process was asked to end.
    pub fn requested(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}
