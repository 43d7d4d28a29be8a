//! `SIGHUP` as a request to reopen files.

use std::io;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Set by `SIGHUP` in a process that [reopens its files](reopen_on_hangup) then.
#[cfg(all(unix, feature = "shared-memory"))]
pub(super) static HUNG_UP: std::sync::OnceLock<Arc<AtomicBool>> = std::sync::OnceLock::new();

/// Makes `SIGHUP` set a flag rather than ask this process to end, as a service does that reopens
/// its logs then. To be called before [`Termination::watch`](crate::Termination::watch). `None` if
/// the process has a terminal: there, `SIGHUP` says that it was closed.
///
/// # Errors
/// If the signal can't be watched.
#[cfg(all(unix, feature = "shared-memory"))]
pub fn reopen_on_hangup() -> io::Result<Option<Arc<AtomicBool>>> {
    use std::io::IsTerminal as _;
    if io::stdin().is_terminal() || io::stdout().is_terminal() || io::stderr().is_terminal() {
        return Ok(None);
    }
    if let Some(flag) = HUNG_UP.get() {
        return Ok(Some(Arc::clone(flag)));
    }
    let flag = Arc::default();
    signal_hook::flag::register(signal_hook::consts::SIGHUP, Arc::clone(&flag))?;
    Ok(Some(Arc::clone(HUNG_UP.get_or_init(|| flag))))
}

/// Other systems have no such signal, and a program of local fleets alone handles none.
///
/// # Errors
/// None.
#[cfg(not(all(unix, feature = "shared-memory")))]
pub fn reopen_on_hangup() -> io::Result<Option<Arc<AtomicBool>>> {
    Ok(None)
}
