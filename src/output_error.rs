//! Errors while writing to standard output or standard error: the reader of a pipe is gone
//! (`regatta … | head`), or a disk is full. `println!` panics in that case. The panic unwinds, so
//! that nothing is left behind in shared memory; this module turns it into an exit code instead of
//! a panic message.

use std::any::Any;
use std::process::ExitCode;

/// The exit code that a shell reports for a program that `SIGPIPE` ended.
const SIGPIPE_EXIT_CODE: u8 = 128 + 13;

/// Keeps panics of `println!` and `eprintln!` from printing a panic message.
pub fn silence_panics() {
    let print = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |info| {
        if !caused(info.payload()) {
            print(info);
        }
    }));
}

/// Whether standard output or standard error that couldn't be written to caused this panic.
pub fn caused(panic: &(dyn Any + Send)) -> bool {
    reason(panic).is_some()
}

/// Returns the exit code for such a panic. A broken pipe ends the program silently; any other
/// reason (for example a full disk) is printed.
pub fn exit_code(panic: &(dyn Any + Send)) -> ExitCode {
    let reason = reason(panic).unwrap_or_default();
    if reason.to_ascii_lowercase().contains("broken pipe") {
        return ExitCode::from(SIGPIPE_EXIT_CODE);
    }
    // Standard error itself may be the stream that can't be written to.
    regatta_plugin::tell!("regatta: can't write to {reason}");
    ExitCode::FAILURE
}

/// Returns the stream and its error, for example `stdout: No space left on device`.
fn reason(panic: &(dyn Any + Send)) -> Option<&str> {
    panic.downcast_ref::<String>()?.strip_prefix("failed printing to ")
}
