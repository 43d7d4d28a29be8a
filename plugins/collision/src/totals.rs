//! Running totals of a run: the number of contacts and warnings, and the worst pairs, robots and
//! edges; and the summary of them that is printed at the end of the run.

use std::cmp::Reverse;
use std::fmt::Write;
use std::hash::Hash;

use regatta_plugin::contact::{ContactLevel, ContactRecord};
use rustc_hash::FxHashMap;

use crate::detector::Detector;

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
        let sum = match level {
            Some(ContactLevel::Touching) => &mut self.touching_nanos,
            Some(ContactLevel::Possible) => &mut self.possible_nanos,
            None => return,
        };
        *sum = sum.wrapping_add(nanos);
    }
}

/// Scores by pair, robot or edge.
#[derive(Clone, Debug, Default)]
struct Scores<K>(FxHashMap<K, Score>);

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
    pairs: Scores<[u32; 2]>,
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
        update(self.pairs.of(record.robots));
        for robot in record.robots {
            update(self.robots.of(robot));
        }
        update(self.edges.of(record.edge));
    }

    /// Returns the score of the whole run.
    pub fn all(&self) -> Score {
        self.all
    }

    /// Returns the worst pairs, by robots, the worst first.
    pub fn worst_pairs(&self, count: usize) -> Vec<([u32; 2], Score)> {
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

/// Number of rows in each list.
const ROWS: usize = 10;

/// Formats the totals of a run that ended at `now_nanos`, and its worst pairs, robots and edges.
/// `edges` are ids by index.
pub(crate) fn summarize(detector: &Detector, edges: &[u32], now_nanos: u64) -> String {
    // Contacts that have not ended have lasted until now.
    let mut totals = detector.totals().clone();
    for contact in detector.contacts() {
        totals.lasted(contact, now_nanos);
    }
    let all = totals.all();
    let mut text = format!(
        "after {:.1} s: {}{} contacts ({} touch now), {} warnings ({} now)\n",
        now_nanos as f64 * 1e-9,
        // The totals are lower bounds if not all pairs of some frame were examined.
        if totals.is_capped() { "at least " } else { "" },
        all.contacts,
        detector.touching(),
        all.warnings,
        detector.contacts().len() - detector.touching()
    );
    list(&mut text, "worst pairs", &totals.pairs, |[a, b]| format!("robots {a} and {b}"));
    list(&mut text, "worst robots", &totals.robots, |robot| format!("robot {robot}"));
    list(&mut text, "worst edges", &totals.edges, |edge| match edges.get(edge as usize) {
        Some(id) => format!("edge {id}"),
        None => "on no edge".to_owned(),
    });
    text
}

fn list<K: Copy + Eq + Hash + Ord>(
    text: &mut String,
    title: &str,
    scores: &Scores<K>,
    name: impl Fn(K) -> String,
) {
    let rows = scores.worst(ROWS);
    if rows.is_empty() {
        return;
    }
    // Writing to a string can't fail.
    let _ = writeln!(
        text,
        "\n{title:<26}{:>10}{:>12}{:>10}{:>12}",
        "contacts", "touching", "warnings", "possible"
    );
    for (key, score) in rows {
        let name = name(key);
        let [touching, possible] =
            [score.touching_nanos, score.possible_nanos].map(|nanos| nanos as f64 * 1e-9);
        let Score { contacts, warnings, .. } = score;
        let _ = writeln!(
            text,
            "{name:<26}{contacts:>10}{touching:>10.2} s{warnings:>10}{possible:>10.2} s"
        );
    }
}
