//! The end of the display. winit has no event for it. Its calls panic, or Xlib ends the process
//! while winit waits for events, and the process leaves its data in shared memory.

use std::panic::{self, AssertUnwindSafe, PanicHookInfo};
use std::sync::atomic::{AtomicBool, Ordering};

use regatta_plugin::{Error, Result};

/// Whether a call of winit has panicked because the display has gone.
static IS_GONE: AtomicBool = AtomicBool::new(false);

/// Keeps quiet about panics of winit that [`catch`] turns into an error.
pub fn quiet_panics() {
    let before = panic::take_hook();
    panic::set_hook(Box::new(move |info| match is_end_of_display(info) {
        true => IS_GONE.store(true, Ordering::Relaxed),
        false => before(info),
    }));
}

/// Whether winit panics because it can't talk to the X server.
fn is_end_of_display(info: &PanicHookInfo<'_>) -> bool {
    let message = info.payload().downcast_ref::<String>().map_or("", String::as_str);
    let is_winit = info.location().is_some_and(|location| location.file().contains("winit"));
    is_winit && ["IoError", "UnknownError"].iter().any(|error| message.contains(error))
}

/// Returns the error for the user.
pub fn gone() -> Error {
    Error::new("the display has gone; --headless draws pictures without one")
}

/// Calls winit. Panics that have another reason than the end of the display go on.
///
/// # Errors
/// If the display has gone.
pub fn catch<T>(call: impl FnOnce() -> T) -> Result<T> {
    // State that the call has left half done is only dropped.
    panic::catch_unwind(AssertUnwindSafe(call)).map_err(|payload| {
        match IS_GONE.load(Ordering::Relaxed) {
            true => gone(),
            false => panic::resume_unwind(payload),
        }
    })
}

/// Runs the application on X11 until it exits.
///
/// While winit waits for events, the end of the display would be noticed by Xlib, which ends the
/// process. So this waits instead, and asks the display for something before winit looks for
/// events: then it is a call of winit that panics.
///
/// # Errors
/// If the display has gone.
#[cfg(target_os = "linux")]
pub fn run_on_x11(mut events: super::Events, app: &mut super::app::App<'_>) -> Result {
    use std::time::{Duration, Instant};
    use winit::platform::pump_events::{EventLoopExtPumpEvents, PumpStatus};

    loop {
        let pause = app.wakes_at().saturating_duration_since(Instant::now());
        wait(&events, pause);
        let step = catch(|| {
            app.ask_display();
            events.pump_app_events(Some(Duration::ZERO), app)
        });
        match step {
            Ok(PumpStatus::Continue) => {}
            Ok(PumpStatus::Exit(0)) => return Ok(()),
            Ok(PumpStatus::Exit(_)) => return Err(gone()),
            Err(error) => {
                app.abandon();
                // To close the connection, Xlib would ask the server, and end the process.
                forget(events);
                return Err(error);
            }
        }
    }
}

/// Leaves the connection to a display that has gone as it is.
#[cfg(target_os = "linux")]
#[expect(clippy::disallowed_methods, reason = "it holds no sample of shared memory")]
fn forget(events: super::Events) {
    std::mem::forget(events);
}

/// Waits until there are events, and no longer than this.
#[cfg(target_os = "linux")]
fn wait(events: &super::Events, pause: std::time::Duration) {
    use rustix::event::{PollFd, PollFlags, Timespec, poll};
    let timeout = Timespec { tv_sec: pause.as_secs() as i64, tv_nsec: pause.subsec_nanos().into() };
    // A signal ends it early, which costs one look for events.
    let _ = poll(&mut [PollFd::new(events, PollFlags::IN)], Some(&timeout));
}
