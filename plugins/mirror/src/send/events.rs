//! Sends events: they wait for the link, in a thread of their own. While it is slow, up to
//! `EVENT_BUFFER` ticks wait in shared memory; then the oldest are lost, and counted.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use regatta_plugin::event::EventHeader;
use regatta_plugin::{EventReader, FleetName, Participant, Result};

use crate::link::Outlet;
use crate::wire::encode_events;

/// The time between two looks at events.
const POLL: Duration = Duration::from_millis(3);

/// Sends a fleet's events while somebody listens, until it is to stop.
pub fn send(fleet: &FleetName, outlet: &Outlet, stop: &AtomicBool) {
    if let Err(error) = try_send(fleet, outlet, stop) {
        regatta_plugin::tell!("mirror: events are no longer sent: {error}");
    }
}

fn try_send(fleet: &FleetName, outlet: &Outlet, stop: &AtomicBool) -> Result {
    let participant = Participant::join(fleet, "mirror-events")?;
    // An engine makes events only for readers: without a peer there is none.
    let mut reader: Option<EventReader> = None;
    while !stop.load(Ordering::Relaxed) {
        if !outlet.is_wanted() {
            reader = None;
        } else if reader.is_none() {
            reader = Some(EventReader::open_on(&participant)?);
        }
        if let Some(reader) = &mut reader {
            reader.take(|tick| -> Result {
                let dropped = tick.header.dropped + tick.missed;
                let header = EventHeader { dropped, ..*tick.header };
                outlet.put(encode_events(&header, tick.records));
                Ok(())
            })?;
        }
        std::thread::sleep(POLL);
    }
    Ok(())
}
