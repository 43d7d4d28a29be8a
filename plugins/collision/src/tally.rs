//! Running totals of a run: how many contacts and warnings, and who and where is worst.

use std::cmp::Reverse;
use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hash, Hasher};

use regatta_plugin::contact::{ContactLevel, ContactRecord};

/// Most pairs, robots or edges of which scores are kept. When more come, the better half is forgotten.
const MOST: usize = 1 << 16;

/// How bad a pair, a robot or an edge is. Sorts by time that it touched, then by how often, then by warnings.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Score {
    /// Simulated time that it touched, in nanoseconds.
    pub touching_nanos: u64,
    /// Times that it came to touch.
    pub contacts: u64,
    /// Simulated time that it was a possible collision without touching, in nanoseconds.
    pub possible_nanos: u64,
    /// Times that it came to be a possible collision.
    pub warnings: u64,
}

impl Score {
    fn began(&mut self, level: ContactLevel) {
        match level {
            ContactLevel::Touching => self.contacts += 1,
            ContactLevel::Possible => self.warnings += 1,
        }
    }

    fn lasted(&mut self, level: Option<ContactLevel>, nanos: u64) {
        match level {
            Some(ContactLevel::Touching) => self.touching_nanos = self.touching_nanos.wrapping_add(nanos),
            Some(ContactLevel::Possible) => self.possible_nanos = self.possible_nanos.wrapping_add(nanos),
            None => {}
        }
    }
}

/// Scores by what they are of.
#[derive(Clone, Debug)]
struct Scores<K>(HashMap<K, Score, BuildHasherDefault<Mix>>);

impl<K> Default for Scores<K> {
    fn default() -> Self {
        Self(HashMap::default())
    }
}

/// Hashes ids, which nobody chooses to collide, in a few instructions (Knuth's multiplicative hashing).
#[derive(Clone, Copy, Debug, Default)]
struct Mix(u64);

impl Hasher for Mix {
    fn write(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|byte| self.write_u32((*byte).into()));
    }

    fn write_u32(&mut self, number: u32) {
        self.0 = (self.0.rotate_left(32) ^ u64::from(number)).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    }

    fn finish(&self) -> u64 {
        self.0 ^ self.0 >> 32
    }
}

impl<K: Copy + Eq + Hash + Ord> Scores<K> {
    fn of(&mut self, key: K) -> &mut Score {
        if self.0.len() >= MOST && !self.0.contains_key(&key) {
            self.0 = self.worst(MOST / 2).into_iter().collect();
        }
        self.0.entry(key).or_default()
    }

    /// The worst first.
    fn worst(&self, count: usize) -> Vec<(K, Score)> {
        let mut all: Vec<_> = self.0.iter().map(|(key, score)| (*key, *score)).collect();
        all.sort_unstable_by_key(|(key, score)| (Reverse(*score), *key));
        all.truncate(count);
        all
    }
}

/// Totals of a run.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    all: Score,
    pairs: Scores<(u32, u32)>,
    robots: Scores<u32>,
    edges: Scores<u32>,
    is_capped: bool,
}

impl Tally {
    /// Of some frame not all pairs were looked at.
    pub(crate) fn cap(&mut self) {
        self.is_capped = true;
    }

    /// Whether there may have been more than is counted here.
    pub fn is_capped(&self) -> bool {
        self.is_capped
    }

    /// A pair has come to a level.
    pub(crate) fn began(&mut self, record: &ContactRecord, level: ContactLevel) {
        self.each(record, |score| score.began(level));
    }

    /// A pair was at a level until now.
    pub(crate) fn lasted(&mut self, record: &ContactRecord, now_nanos: u64) {
        let (level, nanos) = (ContactLevel::from_number(record.level), now_nanos.saturating_sub(record.since_nanos));
        self.each(record, |score| score.lasted(level, nanos));
    }

    /// A pair has come to another edge, at the level that it had. The time until now is taken off the new edge's account,
    /// to which all of the pair's time is added when it leaves: less than nothing, modulo 2^64, until then.
    pub(crate) fn moved(&mut self, record: &ContactRecord, edge: u32, now_nanos: u64) {
        let (level, nanos) = (ContactLevel::from_number(record.level), now_nanos.saturating_sub(record.since_nanos));
        self.edges.of(record.edge).lasted(level, nanos);
        self.edges.of(edge).lasted(level, nanos.wrapping_neg());
    }

    fn each(&mut self, record: &ContactRecord, note: impl Fn(&mut Score)) {
        note(&mut self.all);
        let [first, second] = record.robots;
        note(self.pairs.of((first, second)));
        record.robots.iter().for_each(|robot| note(self.robots.of(*robot)));
        note(self.edges.of(record.edge));
    }

    /// Of the whole run.
    pub fn all(&self) -> Score {
        self.all
    }

    /// The worst pairs, by robots, the worst first.
    pub fn worst_pairs(&self, count: usize) -> Vec<((u32, u32), Score)> {
        self.pairs.worst(count)
    }

    /// The worst robots, by id, the worst first.
    pub fn worst_robots(&self, count: usize) -> Vec<(u32, Score)> {
        self.robots.worst(count)
    }

    /// The worst edges, by index: those that the robot with the lower id was on. To be asked for when all pairs have left.
    pub fn worst_edges(&self, count: usize) -> Vec<(u32, Score)> {
        self.edges.worst(count)
    }
}
