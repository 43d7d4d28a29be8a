//! The limit on open files: shared memory and wake-ups take some of them, and iceoryx2 doesn't say
//! when there are too few.

use core::fmt;

/// The number of open files that a process needs beside those that it has, to join a fleet and open
/// its ports.
#[cfg(unix)]
const NEEDED: u64 = 64;

/// Returns an error of iceoryx2 as text, with the limit on open files if that may be the reason.
pub(crate) fn reason(error: impl fmt::Display) -> String {
    match shortage() {
        Some(limit) => format!(
            "this process may have only {limit} open files: raise the limit, by `ulimit -n 1024`; \
             {error}"
        ),
        None => error.to_string(),
    }
}

/// Returns the limit on open files, if few are left.
#[cfg(unix)]
fn shortage() -> Option<u64> {
    let limit = rustix::process::getrlimit(rustix::process::Resource::Nofile).current?;
    // If it can't be listed, for want of files, there are too few.
    let open = std::fs::read_dir("/proc/self/fd").map_or(limit, |files| files.count() as u64);
    (limit < open + NEEDED).then_some(limit)
}

#[cfg(not(unix))]
fn shortage() -> Option<u64> {
    None
}
