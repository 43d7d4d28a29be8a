//! `regatta … | head`: the reader of our output goes away. `println!` panics then, which unwinds so that nothing is
//! left behind in shared memory; here it is kept from looking like a fault.

use std::any::Any;

/// Exit code: what a shell reports for a program that `SIGPIPE` ended.
pub const BROKEN: u8 = 128 + 13;

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
    panic.downcast_ref::<String>().is_some_and(|message| {
        message.starts_with("failed printing to std") && message.to_lowercase().contains("broken pipe")
    })
}
