//! The viewer's window: where the fleet's picture and the interface meet a screen, hands and an engine.

mod app;
mod furniture;
mod known;
mod live;
mod pulse;
mod surface;
mod udp;

use regatta_plugin::{Error, Result, Termination};
use winit::event_loop::EventLoop;

use crate::options::Options;
use app::App;

/// Shows a fleet in a window until it is closed, or the process is asked to end.
///
/// # Errors
/// One line that says what is wrong: no display, no adapter, no fleet to be read.
pub fn run(options: &Options) -> Result {
    let termination = Termination::watch()?;
    let events = EventLoop::new().map_err(|error| {
        tracing::info!("{error}");
        Error::new("no display to open a window on; --headless draws pictures without one")
    })?;
    let mut app = App::new(options, termination);
    events.run_app(&mut app).map_err(|error| Error::new(format!("the display is gone: {error}")))?;
    app.finish()
}
