//! Events of a tick, as they are collected.

use regatta_plugin::event::{EventKind, EventRecord};

/// The events of one tick, up to a limit; those beyond it are counted.
#[derive(Clone, Debug)]
pub struct Events {
    records: Vec<EventRecord>,
    dropped: u64,
    limit: usize,
    wanted: bool,
}

impl Events {
    /// Room for that many; wanted until told otherwise.
    pub fn new(limit: usize) -> Self {
        Self { records: Vec::with_capacity(limit), dropped: 0, limit, wanted: true }
    }

    /// Whether anybody listens. If not, events are not even counted: in a large fleet they cost time.
    pub fn set_wanted(&mut self, wanted: bool) {
        self.wanted = wanted;
    }

    /// Whether anybody listens.
    pub fn wanted(&self) -> bool {
        self.wanted
    }

    /// What has happened since [`clear`](Self::clear).
    pub fn records(&self) -> &[EventRecord] {
        &self.records
    }

    /// How many were left out.
    pub fn dropped(&self) -> u64 {
        self.dropped
    }

    /// Forgets them all.
    pub fn clear(&mut self) {
        self.records.clear();
        self.dropped = 0;
    }

    pub(crate) fn push(&mut self, kind: EventKind, robot: u32, id: u32) {
        self.push_record(EventRecord { kind: kind as u32, robot, id, ..EventRecord::default() });
    }

    pub(crate) fn push_record(&mut self, record: EventRecord) {
        if !self.wanted {
            return;
        }
        if self.records.len() < self.limit {
            self.records.push(record);
        } else {
            self.dropped += 1;
        }
    }

    /// Gets ready to collect on behalf of another: as many, and only if they are wanted.
    pub(crate) fn take_over(&mut self, other: &Self) {
        self.limit = other.limit;
        self.wanted = other.wanted;
        self.clear();
        self.records.reserve(if self.wanted { self.limit } else { 0 });
    }

    /// Adds another's events after these, and empties it.
    pub(crate) fn append(&mut self, other: &mut Self) {
        other.records.drain(..).for_each(|record| self.push_record(record));
        self.dropped += std::mem::take(&mut other.dropped);
    }
}
