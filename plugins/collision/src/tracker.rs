//! The contact tracker: follows pairs from frame to frame, with their levels, events and totals.

use glam::Vec2;
use regatta_plugin::contact::{ContactChange, ContactEvent, ContactLevel, ContactRecord};

use crate::criteria::Criteria;
use crate::totals::RunTotals;

/// The time of a frame.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct FrameTime {
    pub run_id: u64,
    pub tick: u64,
    pub nanos: u64,
}

/// A pair of robots, and the criteria that it meets in a frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PairObservation {
    /// Ids of the robots, the lower one first.
    pub robots: [u32; 2],
    /// Position where they touch or come nearest, in metres.
    pub position: Vec2,
    /// Relative speed, in metres per second.
    pub relative_speed: f32,
    pub criteria: Criteria,
}

/// All pairs of a run.
#[derive(Debug, Default)]
pub(crate) struct ContactTracker {
    now: FrameTime,
    /// Touching pairs, then possible ones, each sorted by robots.
    contacts: Vec<ContactRecord>,
    touching: usize,
    events: Vec<ContactEvent>,
    totals: RunTotals,
    /// Contacts of the frame before, and memory for the next list.
    before: Vec<ContactRecord>,
    possible: Vec<ContactRecord>,
}

impl ContactTracker {
    /// Begins another frame. A new run, or a step back in time, begins a new list.
    pub(crate) fn begin_frame(&mut self, now: FrameTime) {
        if now.run_id != self.now.run_id || now.tick < self.now.tick {
            self.contacts.clear();
            self.touching = 0;
            self.totals = RunTotals::default();
        }
        self.now = now;
        self.events.clear();
    }

    /// Updates the list with a frame's observations, sorted by robots; a pair occurs several times
    /// if its robots may take several ways. Pairs that had no level before get one only while the
    /// list is shorter than `max_pairs`. `edges` is the frame's column.
    pub(crate) fn end_frame(
        &mut self,
        observations: &[PairObservation],
        max_pairs: usize,
        edges: &[u32],
    ) {
        std::mem::swap(&mut self.contacts, &mut self.before);
        self.contacts.clear();
        self.possible.clear();
        let before = std::mem::take(&mut self.before);
        let (touching, possible) = before.split_at(self.touching);
        let mut previous = PreviousPairs { touching, possible };
        for ways in observations.chunk_by(|one, other| one.robots == other.robots) {
            let (pair, robots) = (&ways[0], ways[0].robots);
            let criteria = ways.iter().fold(Criteria::default(), |all, way| all.or(way.criteria));
            while let Some(old) = previous.next_if(|next| next < robots) {
                self.end(old);
            }
            let old = previous.next_if(|next| next == robots);
            let level = criteria.level(old.and_then(|old| ContactLevel::from_number(old.level)));
            let has_room = old.is_some() || self.contacts.len() + self.possible.len() < max_pairs;
            match (level.filter(|_| has_room), old) {
                (Some(level), old) => self.add(pair, level, old, edges),
                (None, Some(old)) => self.end(old),
                (None, None) => {}
            }
        }
        while let Some(old) = previous.next_if(|_| true) {
            self.end(old);
        }
        self.touching = self.contacts.len();
        self.contacts.append(&mut self.possible);
        self.before = before;
    }

    /// Notes that the frame has more pairs than are examined.
    pub(crate) fn mark_capped(&mut self) {
        self.totals.mark_capped();
    }

    /// Adds a pair that has a level to the list.
    fn add(
        &mut self,
        pair: &PairObservation,
        level: ContactLevel,
        old: Option<&ContactRecord>,
        edges: &[u32],
    ) {
        let since = old.filter(|old| old.level == level as u32);
        let record = ContactRecord {
            since_tick: since.map_or(self.now.tick, |old| old.since_tick),
            since_nanos: since.map_or(self.now.nanos, |old| old.since_nanos),
            robots: pair.robots,
            level: level as u32,
            edge: edges[pair.robots[0] as usize],
            x: pair.position.x,
            y: pair.position.y,
            relative_speed: pair.relative_speed,
            reserved: 0,
        };
        let list =
            if level == ContactLevel::Touching { &mut self.contacts } else { &mut self.possible };
        list.push(record);
        match since {
            None => self.record_changes(old, record, Some(level)),
            Some(old) if old.edge != record.edge => {
                self.totals.moved(old, record.edge, self.now.nanos)
            }
            Some(_) => {}
        }
    }

    /// Ends a pair that has no level any more, at the place at which it was last seen.
    fn end(&mut self, old: &ContactRecord) {
        self.record_changes(Some(old), *old, None);
    }

    /// Records the events of the levels that a pair has reached or left.
    fn record_changes(
        &mut self,
        old: Option<&ContactRecord>,
        record: ContactRecord,
        level: Option<ContactLevel>,
    ) {
        use ContactLevel::{Possible, Touching};
        let before = old.and_then(|old| ContactLevel::from_number(old.level));
        for step in [Possible, Touching]
            .into_iter()
            .filter(|step| before < Some(*step) && Some(*step) <= level)
        {
            self.record_event(record, step, ContactChange::Began);
        }
        for step in [Touching, Possible]
            .into_iter()
            .filter(|step| level < Some(*step) && Some(*step) <= before)
        {
            self.record_event(record, step, ContactChange::Ended);
        }
        if let Some(old) = old {
            self.totals.lasted(old, self.now.nanos);
        }
    }

    fn record_event(&mut self, record: ContactRecord, level: ContactLevel, change: ContactChange) {
        if change == ContactChange::Began {
            self.totals.began(&record, level);
        }
        self.events.push(ContactEvent {
            tick: self.now.tick,
            sim_time_nanos: self.now.nanos,
            robots: record.robots,
            level: level as u32,
            change: change as u32,
            edge: record.edge,
            x: record.x,
            y: record.y,
            relative_speed: record.relative_speed,
        });
    }

    pub(crate) fn contacts(&self) -> &[ContactRecord] {
        &self.contacts
    }

    /// Returns the number of touching contacts, which come first.
    pub(crate) fn touching(&self) -> usize {
        self.touching
    }

    pub(crate) fn events(&self) -> &[ContactEvent] {
        &self.events
    }

    /// Returns the totals up to the last change.
    pub(crate) fn totals(&self) -> &RunTotals {
        &self.totals
    }
}

/// A cursor over the pairs of the last frame, sorted by robots.
struct PreviousPairs<'list> {
    touching: &'list [ContactRecord],
    possible: &'list [ContactRecord],
}

impl<'list> PreviousPairs<'list> {
    /// Returns and passes the next pair, if its robots meet the condition.
    fn next_if(&mut self, condition: impl Fn([u32; 2]) -> bool) -> Option<&'list ContactRecord> {
        let touches_next = match (self.touching.first(), self.possible.first()) {
            (Some(touching), Some(possible)) => touching.robots < possible.robots,
            (touching, _) => touching.is_some(),
        };
        let list = if touches_next { &mut self.touching } else { &mut self.possible };
        let (next, rest) = list.split_first()?;
        if !condition(next.robots) {
            return None;
        }
        *list = rest;
        Some(next)
    }
}
