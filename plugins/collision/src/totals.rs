//! Running totals of a run: the number of contacts and warnings, and the worst pairs, robots and
//! edges.

use std::cmp::Reverse;
use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hash, Hasher};

use regatta_plugin::contact::{ContactLevel, ContactRecord};

/// The largest number of pairs, robots or edges whose scores are kept. When it is reached, the half
/// with the lower scores is dropped.
const MAX_SCORES: usize = 1 << 16;

/// The severity of a pair, a robot or an edge. Orders by time of touching, then by number of
/// contacts, then by possible collisions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Score {
    /// Simulated time of touching, in nanoseconds.
    pub touching_nanos: u64,
    /// Number of contacts that began.
    pub contacts: u64,
    /// Simulated time of possible collisions without touching, in nanoseconds.
    pub possible_nanos: u64,
    /// Number of possible collisions that began.
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
            Some(ContactLevel::Touching) => {
                self.touching_nanos = self.touching_nanos.wrapping_add(nanos)
            }
            Some(ContactLevel::Possible) => {
                self.possible_nanos = self.possible_nanos.wrapping_add(nanos)
            }
            None => {}
        }
    }
}

/// Scores by pair, robot or edge.
#[derive(Clone, Debug)]
struct Scores<K>(HashMap<K, Score, BuildHasherDefault<IdHasher>>);

impl<K> Default for Scores<K> {
    fn default() -> Self {
        Self(HashMap::default())
    }
}

/// A hasher that mixes ids in a few instructions (Knuth's multiplicative hashing). Ids come from no
/// attacker.
#[derive(Clone, Copy, Debug, Default)]
struct IdHasher(u64);

impl Hasher for IdHasher {
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
        if self.0.len() >= MAX_SCORES && !self.0.contains_key(&key) {
            self.0 = self.worst(MAX_SCORES / 2).into_iter().collect();
        }
        self.0.entry(key).or_default()
    }

    /// Returns the highest scores, the worst first.
    fn worst(&self, count: usize) -> Vec<(K, Score)> {
        let mut all: Vec<_> = self.0.iter().map(|(key, score)| (*key, *score)).collect();
        all.sort_unstable_by_key(|(key, score)| (Reverse(*score), *key));
        all.truncate(count);
        all
    }
}

/// Totals of a run.
#[derive(Clone, Debug, Default)]
pub struct RunTotals {
    all: Score,
    pairs: Scores<(u32, u32)>,
    robots: Scores<u32>,
    edges: Scores<u32>,
    is_capped: bool,
}

impl RunTotals {
    /// Notes that not all pairs of a frame were examined.
    pub(crate) fn mark_capped(&mut self) {
        self.is_capped = true;
    }

    /// Whether there may have been more contacts than are counted here.
    pub fn is_capped(&self) -> bool {
        self.is_capped
    }

    /// Notes that a pair has reached a level.
    pub(crate) fn began(&mut self, record: &ContactRecord, level: ContactLevel) {
        self.each(record, |score| score.began(level));
    }

    /// Notes that a pair was at its level until now.
    pub(crate) fn lasted(&mut self, record: &ContactRecord, now_nanos: u64) {
        let (level, nanos) =
            (ContactLevel::from_number(record.level), now_nanos.saturating_sub(record.since_nanos));
        self.each(record, |score| score.lasted(level, nanos));
    }

    /// Notes that a pair has come to another edge at the same level. The time until now is credited
    /// to the old edge, and subtracted from the new one, to which the pair's whole time is added in
    /// the end. Until then the new edge's time may be negative, modulo 2^64.
    pub(crate) fn moved(&mut self, record: &ContactRecord, edge: u32, now_nanos: u64) {
        let (level, nanos) =
            (ContactLevel::from_number(record.level), now_nanos.saturating_sub(record.since_nanos));
        self.edges.of(record.edge).lasted(level, nanos);
        self.edges.of(edge).lasted(level, nanos.wrapping_neg());
    }

    fn each(&mut self, record: &ContactRecord, update: impl Fn(&mut Score)) {
        update(&mut self.all);
        let [first, second] = record.robots;
        update(self.pairs.of((first, second)));
        record.robots.iter().for_each(|robot| update(self.robots.of(*robot)));
        update(self.edges.of(record.edge));
    }

    /// Returns the score of the whole run.
    pub fn all(&self) -> Score {
        self.all
    }

    /// Returns the worst pairs, by robots, the worst first.
    pub fn worst_pairs(&self, count: usize) -> Vec<((u32, u32), Score)> {
        self.pairs.worst(count)
    }

    /// Returns the worst robots, by id, the worst first.
    pub fn worst_robots(&self, count: usize) -> Vec<(u32, Score)> {
        self.robots.worst(count)
    }

    /// Returns the worst edges, by index, the worst first. A pair counts for the edge of the robot
    /// with the lower id. Only exact after all pairs have ended.
    pub fn worst_edges(&self, count: usize) -> Vec<(u32, Score)> {
        self.edges.worst(count)
    }
}
