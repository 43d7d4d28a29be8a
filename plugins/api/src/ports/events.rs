//! The reader's side of events.

use super::error::OpenError;
use super::receive::{TickReader, TickRecords};
use super::services;
use crate::process::join::Participant;
use crate::records::event::{EventHeader, EventRecord};
use crate::records::name::FleetName;

/// The events of one tick, borrowed from shared memory, in the order of their robots' ids.
pub type Events<'sample> = TickRecords<'sample, EventHeader, EventRecord>;

/// Reads a fleet's events.
///
/// ```no_run
/// use regatta_plugin::{EventReader, FleetName, Result};
///
/// # fn main() -> Result {
/// let mut events = EventReader::open(&FleetName::default())?;
/// events.take(|tick| -> Result {
///     for event in tick.records {
///         println!("tick {}: robot {}: {:?}", tick.header.tick, event.robot, event.kind());
///     }
///     Ok(())
/// })?;
/// # Ok(())
/// # }
/// ```
pub type EventReader = TickReader<EventHeader, EventRecord>;

impl EventReader {
    /// Opens the events of a fleet, whether or not it has a producer yet.
    ///
    /// # Errors
    /// As [`Subscriber::open`](crate::Subscriber::open).
    pub fn open(fleet: &FleetName) -> Result<Self, OpenError> {
        Self::open_on(&Participant::join(fleet, "events")?)
    }

    /// Opens the events for a process that has joined the fleet.
    ///
    /// # Errors
    /// As [`Subscriber::open`](crate::Subscriber::open).
    pub fn open_on(participant: &Participant) -> Result<Self, OpenError> {
        Self::of(&services::EVENTS, participant)
    }
}
