//! `regatta … | head`: the reader of our output goes away. `println!` panics then, which unwinds so that nothing is
//! left behind in shared memory; here it is kept from looking like a fault.

use std::any::Any;
use std::io::Write;
use std::process::ExitCode;

/// What a shell reports for a program that `SIGPIPE` ended.
const SIGPIPE: u8 = 128 + 13;

/// Keeps such a panic from printing a message.
pub fn hush_broken() {
    let print = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |info| {
        if !is_broken(info.payload()) {
            print(info);
        }
    }));
}

/// Whether a panic says that standard output or error can't be written to.
pub fn is_broken(panic: &(dyn Any + Send)) -> bool {
    reason(panic).is_some()
}

/// How the program ends then: silently if nobody reads it any more, else (a full disk, say) with a message.
pub fn exit_code(panic: &(dyn Any + Send)) -> ExitCode {
    let reason = reason(panic).unwrap_or_default();
    if reason.to_ascii_lowercase().contains("broken pipe") {
        return ExitCode::from(SIGPIPE);
    }
    // Standard error may be what can't be written to.
    let _ = writeln!(std::io::stderr(), "regatta: can't write to {reason}");
    ExitCode::FAILURE
}

/// `stdout: No space left on device`, say.
fn reason(panic: &(dyn Any + Send)) -> Option<&str> {
    panic.downcast_ref::<String>()?.strip_prefix("failed printing to ")
}
