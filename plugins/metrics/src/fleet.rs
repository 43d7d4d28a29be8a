//! The readers of all that a fleet publishes, and the state that they collect.

use std::sync::Arc;

use regatta_plugin::{FleetName, Frame, Participant, ReadError, Result};

use crate::aggregator::{Aggregator, wall_time_nanos};
use crate::collisions::CollisionReader;
use crate::jams::JamReader;
use crate::snapshot::{Collisions, Jam, Process, Snapshot};
use crate::work::{WorkReader, WorkTally};

/// The ports to the results of other plugins.
#[derive(Debug)]
pub struct FleetReader {
    collisions: CollisionReader,
    work: WorkReader,
    jams: JamReader,
}

/// The known state of a fleet.
#[derive(Debug, Default)]
pub struct FleetState {
    /// Aggregate of all frames.
    pub aggregator: Aggregator,
    collisions: Collisions,
    work: WorkTally,
    jams: Option<Arc<[Jam]>>,
}

impl FleetReader {
    /// Opens all ports, whether or not anything is published yet.
    ///
    /// # Errors
    /// Fails if the fleet uses another version of the contract, or has no room for another reader.
    pub fn open_on(participant: &Participant) -> Result<Self> {
        Ok(Self {
            collisions: CollisionReader::open_on(participant)?,
            work: WorkReader::open_on(participant)?,
            jams: JamReader::open_on(participant)?,
        })
    }

    /// Adds a frame that was read at the wall time `now`, in nanoseconds.
    pub fn add_frame(&mut self, state: &mut FleetState, frame: &Frame<'_>, now: u64) {
        state.aggregator.add_frame(frame, now);
        self.work.add_frame(&mut state.work, frame);
    }

    /// Reads new results at the wall time `now`, in nanoseconds. Results that can't be read are
    /// another program's error: they are counted and skipped.
    pub fn update(&mut self, state: &mut FleetState, now: u64) {
        let FleetState { aggregator, collisions, work, jams } = state;
        let clock = aggregator.clock();
        let outcomes = [
            self.collisions.read_levels(now),
            self.collisions.read_pairs(now),
            self.work.read_robots(work, now),
            self.work.read_orders(work, clock),
            self.work.read_figures(work, clock),
            self.jams.read_world(),
            self.jams.read_traffic(),
        ];
        for _ in outcomes.iter().filter(|outcome: &&Result<(), ReadError>| outcome.is_err()) {
            aggregator.count_read_error();
        }
        *collisions = self.collisions.collisions(aggregator.newest());
        *jams = self.jams.jams(clock);
    }
}

impl FleetState {
    /// Returns a snapshot of a fleet with these processes.
    pub fn snapshot(&self, fleet: &FleetName, processes: Vec<Process>) -> Snapshot {
        Snapshot {
            collisions: self.collisions.clone(),
            work: self.work.work(&self.aggregator),
            jams: self.jams.clone(),
            processes,
            ..self.aggregator.snapshot(fleet, wall_time_nanos())
        }
    }
}

/// The largest age of results relative to the newest frame, in nanoseconds of wall time. With older
/// results, their publisher has died or hangs.
const MAX_AGE_NANOS: u64 = 2_000_000_000;

/// A value of a run, with the wall time in nanoseconds at which it was received.
#[derive(Clone, Debug)]
pub(crate) struct Received<T> {
    run_id: u64,
    received_nanos: u64,
    value: T,
}

impl<T> Received<T> {
    pub fn new(run_id: u64, received_nanos: u64, value: T) -> Self {
        Self { run_id, received_nanos, value }
    }

    /// Returns the value if it belongs to the newest frame, given its run id and its wall time in
    /// nanoseconds.
    pub fn if_current(&self, (run_id, wall): (u64, u64)) -> Option<&T> {
        (self.run_id == run_id && wall.saturating_sub(self.received_nanos) < MAX_AGE_NANOS)
            .then_some(&self.value)
    }
}
