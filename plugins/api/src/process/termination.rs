//! Ctrl-C and `SIGTERM` as a flag.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::Instant;

#[cfg(unix)]
use signal_hook::consts::SIGHUP;
use signal_hook::consts::{SIGINT, SIGTERM};

#[cfg(unix)]
use super::hangup::HUNG_UP;
use crate::error::Result;

/// The environment variable with the id of the process that started this one: when that process
/// dies, for any reason, this one is asked to end. `regatta run` sets it.
pub const PARENT_VARIABLE: &str = "REGATTA_PARENT";

static REQUESTED: OnceLock<Arc<AtomicBool>> = OnceLock::new();

/// The shortest time in milliseconds between two requests of a person.
const SECOND_REQUEST_MILLIS: u64 = 200;

/// Ends the process at the second Ctrl-C, even if it hangs.
#[expect(unsafe_code, reason = "only a handler knows when a signal came while the process hangs")]
fn end_at_second_interrupt() -> Result {
    let start = Instant::now();
    // Milliseconds since the start, plus one.
    let first = AtomicU64::new(0);
    let handler = move || {
        let now = u64::try_from(start.elapsed().as_millis()).unwrap_or(u64::MAX - 1) + 1;
        let before = first.compare_exchange(0, now, Ordering::Relaxed, Ordering::Relaxed);
        if before.is_err_and(|first| now.saturating_sub(first) >= SECOND_REQUEST_MILLIS) {
            signal_hook::low_level::exit(130);
        }
    };
    // SAFETY: it does only what a signal handler may: it reads the monotonic clock
    // (`clock_gettime`), changes an atomic number, and ends the process by `_exit`. It takes no
    // lock, allocates nothing and can't panic.
    unsafe { signal_hook::low_level::register(SIGINT, handler)? };
    Ok(())
}

/// Whether this process was asked to end: by Ctrl-C, `SIGTERM`, or its terminal being closed.
///
/// ```no_run
/// # fn main() -> regatta_plugin::Result {
/// let termination = regatta_plugin::Termination::watch()?;
/// while !termination.requested() {
///     // Work for some milliseconds.
/// }
/// # Ok(())
/// # }
/// ```
///
/// Only these count: a process that is stopped and continued goes on. A second Ctrl-C, 200 ms or
/// more after the first, ends the process at once, in case it hangs; the next process to join a
/// fleet then cleans up its shared memory. (One Ctrl-C may arrive twice: from the terminal, and
/// from a program that forwards it.)
///
/// Writing to a file that has grown to its limit (`ulimit -f`) fails with an error rather than with
/// `SIGXFSZ`.
#[derive(Clone, Debug)]
pub struct Termination(Arc<AtomicBool>);

impl Termination {
    /// Installs the signal handlers, once per process; from then on the signals only set the flag.
    ///
    /// # Errors
    /// If the operating system refuses.
    pub fn watch() -> Result<Self> {
        if let Some(requested) = REQUESTED.get() {
            return Ok(Self(Arc::clone(requested)));
        }
        let requested = Arc::new(AtomicBool::new(false));
        end_at_second_interrupt()?;
        // A handler is enough to make the write fail. The flag is never read.
        #[cfg(unix)]
        signal_hook::flag::register(signal_hook::consts::SIGXFSZ, Arc::default())?;
        #[cfg(unix)]
        let hangup = HUNG_UP.get().is_none().then_some(SIGHUP);
        #[cfg(not(unix))]
        let hangup = None;
        for signal in [SIGINT, SIGTERM].into_iter().chain(hangup) {
            signal_hook::flag::register(signal, Arc::clone(&requested))?;
        }
        let termination = Self(Arc::clone(REQUESTED.get_or_init(|| requested)));
        if let Some(parent) = std::env::var(PARENT_VARIABLE).ok().and_then(|id| id.parse().ok()) {
            termination.follow(parent);
        }
        Ok(termination)
    }

    /// Asks this process to end when the process that started it has ended, or an older ancestor
    /// that set [`PARENT_VARIABLE`].
    ///
    /// A thread waits for that end. The kernel's own signal for it (`PR_SET_PDEATHSIG`) comes when
    /// the *thread* that started this process ends, so it is the choice of old kernels alone.
    #[cfg(target_os = "linux")]
    fn follow(&self, parent: i32) {
        use rustix::io::Errno;
        use rustix::process::{
            Pid, PidfdFlags, Signal, getppid, pidfd_open, set_parent_process_death_signal,
        };
        let Some(parent) = Pid::from_raw(parent) else { return };
        match pidfd_open(parent, PidfdFlags::empty()) {
            Ok(parent) => {
                let waiting = std::thread::Builder::new().name("parent".to_owned());
                // On an error, this process has to be ended by hand.
                let _ = waiting.spawn(move || end_after(&parent));
            }
            Err(Errno::SRCH) => self.0.store(true, Ordering::Relaxed),
            Err(_) if getppid() == Some(parent) => {
                let _ = set_parent_process_death_signal(Some(Signal::TERM));
            }
            Err(_) => {}
        }
    }

    /// Other systems don't tell that.
    #[cfg(not(target_os = "linux"))]
    fn follow(&self, _parent: i32) {}

    /// Whether this process [watches](Self::watch) for signals and was asked to end.
    pub fn was_requested() -> bool {
        REQUESTED.get().is_some_and(|requested| requested.load(Ordering::Relaxed))
    }

    /// Whether the process was asked to end.
    pub fn requested(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// Waits until a process has ended, and sends `SIGTERM` to this one, which also wakes a thread that
/// sleeps.
#[cfg(target_os = "linux")]
fn end_after(process: &std::os::fd::OwnedFd) {
    use rustix::event::{PollFd, PollFlags, poll};
    use rustix::process::{Signal, getpid, kill_process};

    while let Err(rustix::io::Errno::INTR) = poll(&mut [PollFd::new(process, PollFlags::IN)], None)
    {
    }
    let _ = kill_process(getpid(), Signal::TERM);
}
