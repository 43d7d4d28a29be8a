//! The limit on open files: shared memory and wake-ups take some of them, and iceoryx2 doesn't say
//! when there are too few.

use core::fmt;

/// The number of open files that a process needs beside those that it has, to join a fleet and open
/// its ports.
#[cfg(unix)]
const NEEDED: u64 = 64;

/// Returns an error of iceoryx2 as text, with the limit on open files if that may be the reason.
pub(crate) fn reason(error: impl fmt::Display) -> String {
    let error = in_words(&error.to_string());
    match shortage() {
        Some(limit) => format!(
            "this process may have only {limit} open files: raise the limit, by `ulimit -n 1024`; \
             {error}"
        ),
        None => error,
    }
}

/// Returns an error of iceoryx2 in words: `internal failure` for
/// `OpenOrCreateError::OpenError(InternalFailure)`, and other texts as they are.
fn in_words(error: &str) -> String {
    let name = error.rsplit(['(', ':']).next().unwrap_or(error).trim_end_matches(')');
    if !error.contains("::") || !name.starts_with(char::is_uppercase) || name.contains(' ') {
        return error.to_owned();
    }
    let mut words = String::new();
    for letter in name.chars() {
        if letter.is_uppercase() && !words.is_empty() {
            words.push(' ');
        }
        words.extend(letter.to_lowercase());
    }
    words
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

#[cfg(test)]
mod tests {
    use super::in_words;

    #[test]
    fn errors_of_iceoryx2_are_told_without_names_of_types() {
        let nested = "RequestResponseOpenOrCreateError::RequestResponseOpenError(VersionMismatch)";
        assert_eq!(in_words(nested), "version mismatch");
        assert_eq!(in_words("NodeCreationFailure::InternalError"), "internal error");
        assert_eq!(in_words("no such file (os error 2)"), "no such file (os error 2)");
    }
}
