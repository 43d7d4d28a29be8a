//! The reader's side of the states of doors and lifts.

use super::error::{OpenError, ReadError};
use super::receive::Newest;
use super::services;
use crate::process::join::Participant;
use crate::records::facility::{FacilityHeader, FacilityKind, FacilityState};

/// Reads the states of a fleet's doors and lifts. Nothing arrives from a world without any.
///
/// ```
/// use regatta_plugin::facility::{DoorState, FacilityState};
/// use regatta_plugin::{FacilityReader, ProducerPorts, Result};
///
/// # fn main() -> Result {
/// # let fleet = format!("doc-facilities-{}", std::process::id()).parse()?;
/// let mut producer = ProducerPorts::create(&fleet, 1)?;
/// let mut reader = FacilityReader::open_on(producer.participant())?;
/// let door = FacilityState { door: DoorState::Open as u32, ..FacilityState::default() };
/// producer.publish_facilities(5, &[door])?;
/// assert!(reader.take()?);
/// assert_eq!(reader.doors(producer.run_id()), [door]);
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct FacilityReader {
    states: Newest<FacilityState, FacilityHeader>,
}

impl FacilityReader {
    /// Opens the states of a fleet's facilities, whether or not it has a producer.
    ///
    /// # Errors
    /// As [`Subscriber::open`](crate::Subscriber::open).
    pub fn open_on(participant: &Participant) -> Result<Self, OpenError> {
        Ok(Self { states: Newest::open(&services::FACILITIES, participant)? })
    }

    /// Takes the newest sample, and returns whether there was one that this hasn't taken yet.
    ///
    /// # Errors
    /// [`ReadError`] if the connection is broken.
    pub fn take(&mut self) -> Result<bool, ReadError> {
        self.states.take_newest()
    }

    /// The sample that was taken last, with its run and tick: the states of all doors, then of all
    /// lifts.
    pub fn newest(&self) -> Option<(&FacilityHeader, &[FacilityState])> {
        self.states.held()
    }

    /// The states of all doors, then of all lifts, in a run, as of the sample that was taken last.
    pub fn states(&self, run_id: u64) -> &[FacilityState] {
        let held = self.states.held().filter(|(header, _)| header.run_id == run_id);
        held.map_or(&[], |(_, states)| states)
    }

    /// The states of all doors, in the order of the world.
    pub fn doors(&self, run_id: u64) -> &[FacilityState] {
        let states = self.states(run_id);
        &states[..states.partition_point(|state| state.kind == FacilityKind::Door as u32)]
    }

    /// The states of all lifts, in the order of the world.
    pub fn lifts(&self, run_id: u64) -> &[FacilityState] {
        &self.states(run_id)[self.doors(run_id).len()..]
    }
}
