//! What is known of pairs from frame to frame: who has which level since when, what changed, and totals.

use regatta_plugin::contact::{ContactChange, ContactEvent, ContactLevel, ContactRecord};

use crate::pair::Signs;
use crate::tally::Tally;

/// When a frame was.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Moment {
    pub run_id: u64,
    pub tick: u64,
    pub nanos: u64,
}

/// A pair, and what a frame says about it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Found {
    /// The lower id first.
    pub robots: [u32; 2],
    /// Where they touch or come nearest, in metres.
    pub place: [f32; 2],
    /// Metres per second.
    pub relative_speed: f32,
    pub signs: Signs,
}

/// All pairs of a run.
#[derive(Debug, Default)]
pub(crate) struct Ledger {
    now: Moment,
    /// Those that touch, then those that may, each by robots.
    contacts: Vec<ContactRecord>,
    touching: usize,
    events: Vec<ContactEvent>,
    tally: Tally,
    /// Memory for the next list.
    before: Vec<ContactRecord>,
    possible: Vec<ContactRecord>,
}

impl Ledger {
    /// Turns to another frame. A new run, or a step back in time, begins a new list.
    pub(crate) fn open(&mut self, now: Moment) {
        if now.run_id != self.now.run_id || now.tick < self.now.tick {
            self.contacts.clear();
            self.touching = 0;
            self.tally = Tally::default();
        }
        self.now = now;
        self.events.clear();
    }

    /// Takes in what the frame says, by robots; a pair may come several times. Of pairs that had no level before, only
    /// as many get one as there is room for in a list of `most`. `edges` is the frame's column.
    pub(crate) fn close(&mut self, found: &[Found], most: usize, edges: &[u32]) {
        std::mem::swap(&mut self.contacts, &mut self.before);
        self.contacts.clear();
        self.possible.clear();
        let before = std::mem::take(&mut self.before);
        let (touching, possible) = before.split_at(self.touching);
        let mut known = Known { touching, possible };
        let mut last = None;
        for pair in found {
            let robots = pair.robots;
            if last.replace(robots) == Some(robots) {
                continue;
            }
            while let Some(old) = known.next_if(|next| next < robots) {
                self.end(old);
            }
            let old = known.next_if(|next| next == robots);
            let level = pair.signs.level(old.and_then(|old| ContactLevel::from_number(old.level)));
            let has_room = old.is_some() || self.contacts.len() + self.possible.len() < most;
            match (level.filter(|_| has_room), old) {
                (Some(level), old) => self.note(pair, level, old, edges),
                (None, Some(old)) => self.end(old),
                (None, None) => {}
            }
        }
        while let Some(old) = known.next_if(|_| true) {
            self.end(old);
        }
        self.touching = self.contacts.len();
        self.contacts.append(&mut self.possible);
        self.before = before;
    }

    /// The frame has more pairs than are looked at.
    pub(crate) fn cap(&mut self) {
        self.tally.cap();
    }

    /// A pair has a level.
    fn note(&mut self, pair: &Found, level: ContactLevel, old: Option<&ContactRecord>, edges: &[u32]) {
        let since = old.filter(|old| old.level == level as u32);
        let record = ContactRecord {
            since_tick: since.map_or(self.now.tick, |old| old.since_tick),
            since_nanos: since.map_or(self.now.nanos, |old| old.since_nanos),
            robots: pair.robots,
            level: level as u32,
            edge: edges[pair.robots[0] as usize],
            x: pair.place[0],
            y: pair.place[1],
            relative_speed: pair.relative_speed,
            reserved: 0,
        };
        let list = if level == ContactLevel::Touching { &mut self.contacts } else { &mut self.possible };
        list.push(record);
        match since {
            None => self.change(old, record, Some(level)),
            Some(old) if old.edge != record.edge => self.tally.moved(old, record.edge, self.now.nanos),
            Some(_) => {}
        }
    }

    /// A pair has no level any more; it ended where it was last seen.
    fn end(&mut self, old: &ContactRecord) {
        self.change(Some(old), *old, None);
    }

    /// Tells which levels a pair has come to or left.
    fn change(&mut self, old: Option<&ContactRecord>, record: ContactRecord, level: Option<ContactLevel>) {
        use ContactLevel::{Possible, Touching};
        let before = old.and_then(|old| ContactLevel::from_number(old.level));
        for step in [Possible, Touching].into_iter().filter(|step| before < Some(*step) && Some(*step) <= level) {
            self.tell(record, step, ContactChange::Began);
        }
        for step in [Touching, Possible].into_iter().filter(|step| level < Some(*step) && Some(*step) <= before) {
            self.tell(record, step, ContactChange::Ended);
        }
        if let Some(old) = old {
            self.tally.lasted(old, self.now.nanos);
        }
    }

    fn tell(&mut self, record: ContactRecord, level: ContactLevel, change: ContactChange) {
        if change == ContactChange::Began {
            self.tally.began(&record, level);
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

    /// How many of them touch: the first ones.
    pub(crate) fn touching(&self) -> usize {
        self.touching
    }

    pub(crate) fn events(&self) -> &[ContactEvent] {
        &self.events
    }

    /// Totals up to the last change.
    pub(crate) fn tally(&self) -> &Tally {
        &self.tally
    }
}

/// The pairs of the last frame, to be taken by robots.
struct Known<'list> {
    touching: &'list [ContactRecord],
    possible: &'list [ContactRecord],
}

impl<'list> Known<'list> {
    /// Takes the next pair, if its robots are as asked for.
    fn next_if(&mut self, is_wanted: impl Fn([u32; 2]) -> bool) -> Option<&'list ContactRecord> {
        let touches_next = match (self.touching.first(), self.possible.first()) {
            (Some(touching), Some(possible)) => touching.robots < possible.robots,
            (touching, _) => touching.is_some(),
        };
        let list = if touches_next { &mut self.touching } else { &mut self.possible };
        let (next, rest) = list.split_first()?;
        if !is_wanted(next.robots) {
            return None;
        }
        *list = rest;
        Some(next)
    }
}
