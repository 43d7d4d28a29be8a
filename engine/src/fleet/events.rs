//! The events of a tick, as they are collected.

use regatta_motion::{Event, EventSink};
use regatta_plugin::event::{EventKind, EventRecord};

/// The events of one tick, up to a limit. Events beyond the limit are only counted.
#[derive(Clone, Debug)]
pub struct EventBuffer {
    records: Vec<EventRecord>,
    dropped: u64,
    limit: usize,
    wanted: bool,
}

impl EventBuffer {
    /// Makes room for `limit` events; wanted until [`set_wanted`](Self::set_wanted) changes that.
    pub fn new(limit: usize) -> Self {
        Self { records: Vec::with_capacity(limit), dropped: 0, limit, wanted: true }
    }

    /// Sets whether events have a reader. Without one they are not even counted: in a large fleet
    /// they cost time.
    pub fn set_wanted(&mut self, wanted: bool) {
        self.wanted = wanted;
    }

    /// Events since the last [`clear`](Self::clear).
    pub fn records(&self) -> &[EventRecord] {
        &self.records
    }

    /// Number of events beyond the limit.
    pub fn dropped(&self) -> u64 {
        self.dropped
    }

    /// Removes all events and resets the count.
    pub fn clear(&mut self) {
        self.records.clear();
        self.dropped = 0;
    }

    pub(super) fn push_kind(&mut self, kind: EventKind, robot: u32, id: u32) {
        self.push_record(EventRecord { kind: kind as u32, robot, id, ..EventRecord::default() });
    }

    pub(super) fn push_record(&mut self, record: EventRecord) {
        if !self.wanted {
            return;
        }
        if self.records.len() < self.limit {
            self.records.push(record);
        } else {
            self.dropped += 1;
        }
    }

    /// Clears these events and copies the settings of `other`: its limit, and whether events are
    /// wanted.
    pub(super) fn reset_like(&mut self, other: &Self) {
        self.limit = other.limit;
        self.wanted = other.wanted;
        self.clear();
        self.records.reserve(if self.wanted { self.limit } else { 0 });
    }

    /// Moves the events of `other` behind these.
    pub(super) fn append(&mut self, other: &mut Self) {
        for record in other.records.drain(..) {
            self.push_record(record);
        }
        self.dropped += std::mem::take(&mut other.dropped);
    }
}

impl EventSink for EventBuffer {
    fn wanted(&self) -> bool {
        self.wanted
    }

    fn push(&mut self, robot: u32, event: Event) {
        let (kind, id) = match event {
            Event::ReachedNode(id) => (EventKind::ReachedNode, id),
            Event::RouteDone => (EventKind::RouteDone, 0),
            Event::WaitingForRelease => (EventKind::WaitingForRelease, 0),
            Event::Held => (EventKind::Held, 0),
            Event::Faulted => (EventKind::Faulted, 0),
        };
        self.push_kind(kind, robot, id);
    }
}
