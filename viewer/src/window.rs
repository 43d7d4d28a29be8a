//! The viewer's window: the picture of the fleet and the interface on a screen, with input from the
//! user and a link to the engine.

mod app;
mod assets;
mod child;
mod display;
mod file_dialog;
mod fleet_state;
mod frame_pacing;
mod opened;
mod picture_request;
mod settings_store;
mod surface;
mod udp;
mod viewer_window;

use egui_winit::accesskit_winit;
use regatta_plugin::{Error, Result, Termination};
use winit::event_loop::EventLoop;

use crate::options::Options;
use app::App;

/// The event loop, in which assistive programs take part.
type Events = EventLoop<accesskit_winit::Event>;

/// Shows a fleet in a window until the window is closed or the process is asked to end.
///
/// # Errors
/// One line about the problem: no display, no adapter, or no readable fleet.
pub fn run(options: &Options) -> Result {
    let termination = Termination::watch()?;
    let events = Events::with_user_event().build().map_err(|error| {
        tracing::info!("{error}");
        Error::new("no display to open a window on; --headless draws pictures without one")
    })?;
    display::quiet_panics();
    let mut app = App::new(options, termination, events.create_proxy());
    #[cfg(target_os = "linux")]
    if winit::platform::x11::EventLoopExtX11::is_x11(&events) {
        display::run_on_x11(events, &mut app)?;
        return app.finish();
    }
    events
        .run_app(&mut app)
        .map_err(|error| Error::new(format!("lost the connection to the display: {error}")))?;
    app.finish()
}
