//! The reader's side of events.

use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::*;

use crate::error::{OpenError, ReadError};
use crate::event::{EventHeader, EventKind, EventRecord};
use crate::fleet_name::FleetName;
use crate::participant::Participant;
use crate::qos::{self, Ipc};
use crate::subscribe::receive_error;

/// What happened in one tick, borrowed from shared memory.
#[derive(Clone, Copy, Debug)]
pub struct Events<'sample> {
    /// The tick, and how many were left out of it.
    pub header: &'sample EventHeader,
    /// The events, in order of their robots' ids.
    pub records: &'sample [EventRecord],
    /// Ticks with events that this reader was too slow for, between the last ones it got and these.
    pub missed: u64,
}

/// Reads a fleet's events, tick by tick. A reader that lags more than [`EVENT_BUFFER`](qos::EVENT_BUFFER) ticks
/// with events behind misses the oldest, and is told how many.
#[derive(Debug)]
pub struct EventReader {
    events: Subscriber<Ipc, [EventRecord], EventHeader>,
    gaps: qos::Gaps,
}

impl EventReader {
    /// Opens the events of a fleet, whether or not it has a producer yet.
    ///
    /// # Errors
    /// As [`Subscriber::open`](crate::Subscriber::open).
    pub fn open(fleet: &FleetName) -> Result<Self, OpenError> {
        Self::open_on(&Participant::join(fleet, "events")?)
    }

    /// The same, on a place that the process already has.
    ///
    /// # Errors
    /// As [`Subscriber::open`](crate::Subscriber::open).
    pub fn open_on(participant: &Participant) -> Result<Self, OpenError> {
        let service = qos::events(&participant.node, participant.fleet())?;
        let events =
            service.subscriber_builder().create().map_err(|e| qos::full_or(service.name(), qos::MAX_READERS, e))?;
        Ok(Self { events, gaps: qos::Gaps::default() })
    }

    /// Hands over all ticks' events that have arrived, oldest first.
    ///
    /// # Errors
    /// [`ReadError::Receive`] if the connection to the producer is broken, else what `each` returns.
    pub fn take<E: From<ReadError>>(&mut self, mut each: impl FnMut(&Events<'_>) -> Result<(), E>) -> Result<(), E> {
        // Bounded, so that a producer faster than `each` can't keep a reader from its frames.
        for _ in 0..2 * qos::EVENT_BUFFER {
            let Some(sample) = self.events.receive().map_err(|e| receive_error("events", e))? else { break };
            let header = sample.user_header();
            let missed = self.gaps.before(header.run_id, header.sequence);
            each(&Events { header, records: sample.payload(), missed })?;
        }
        Ok(())
    }
}

impl EventRecord {
    /// What happened; `None` for a kind that this contract doesn't have.
    pub fn kind(&self) -> Option<EventKind> {
        use EventKind::*;
        [ReachedNode, RouteDone, WaitingForRelease, Held, Resumed, Accepted, Refused, Spawned, Removed, Faulted]
            .into_iter()
            .find(|kind| *kind as u32 == self.kind)
    }
}
