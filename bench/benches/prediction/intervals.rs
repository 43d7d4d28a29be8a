//! The times in which pairs of robots had a level, and what they say about the predictions.

use std::collections::BTreeMap;
use std::fmt;

use regatta_plugin::contact::{ContactChange, ContactEvent, ContactLevel};

/// Ticks from the first to before the second.
type Interval = (u64, u64);

/// All pairs of a run.
#[derive(Default)]
pub struct Pairs(BTreeMap<[u32; 2], Levels>);

/// The intervals in which a pair had each level. An open interval ends with `u64::MAX`.
#[derive(Default)]
struct Levels {
    possible: Vec<Interval>,
    touching: Vec<Interval>,
}

/// The quality of the predictions.
#[derive(Default)]
pub struct Score {
    /// Pair-ticks that were predicted, that came true, and both.
    ticks: [u64; 3],
    /// Warnings that began, and those of them that came true within the horizon or while they
    /// lasted.
    warnings: [u64; 2],
    /// Contacts that began, and those of them that were predicted half a second ahead.
    contacts: [u64; 2],
}

impl Pairs {
    /// Notes a change of a pair's level.
    pub fn note(&mut self, event: &ContactEvent) {
        let levels = self.0.entry(event.robots).or_default();
        let touching = event.level == ContactLevel::Touching as u32;
        let list = if touching { &mut levels.touching } else { &mut levels.possible };
        match list.last_mut() {
            Some(last) if event.change == ContactChange::Ended as u32 => last.1 = event.tick,
            _ => list.push((event.tick, u64::MAX)),
        }
    }

    /// Judges the predictions of a run of that many ticks. The first and the last `horizon` ticks
    /// don't count: robots start inside each other, and what the last predictions came to is not
    /// known.
    pub fn score(&self, ticks: u64, horizon: u64) -> Score {
        let mut score = Score::default();
        let counted = horizon..ticks.saturating_sub(horizon);
        for levels in self.0.values() {
            let touches = |tick| holds(&levels.touching, tick);
            let ends = levels.possible.iter().chain(&levels.touching);
            let first =
                ends.clone().map(|(from, _)| from.saturating_sub(horizon)).min().unwrap_or(0);
            let last = ends.map(|(_, to)| *to).max().unwrap_or(0);
            for tick in
                (counted.start.max(first)..counted.end.min(last)).filter(|tick| !touches(*tick))
            {
                let predicted = holds(&levels.possible, tick);
                let true_soon = begins(&levels.touching, tick + 1..=tick + horizon);
                let both = predicted && true_soon;
                for (count, holds) in score.ticks.iter_mut().zip([predicted, true_soon, both]) {
                    *count += u64::from(holds);
                }
            }
            for (from, to) in
                levels.possible.iter().filter(|(from, _)| counted.contains(from) && !touches(*from))
            {
                let came_true = begins(&levels.touching, from + 1..=(from + horizon).max(*to));
                score.warnings = [score.warnings[0] + 1, score.warnings[1] + u64::from(came_true)];
            }
            for (from, _) in levels.touching.iter().filter(|(from, _)| counted.contains(from)) {
                let predicted = holds(&levels.possible, from.saturating_sub(horizon / 4));
                score.contacts = [score.contacts[0] + 1, score.contacts[1] + u64::from(predicted)];
            }
        }
        score
    }
}

fn holds(intervals: &[Interval], tick: u64) -> bool {
    let after = intervals.partition_point(|(from, _)| *from <= tick);
    after.checked_sub(1).is_some_and(|last| tick < intervals[last].1)
}

fn begins(intervals: &[Interval], ticks: std::ops::RangeInclusive<u64>) -> bool {
    let after = intervals.partition_point(|(from, _)| from < ticks.start());
    intervals.get(after).is_some_and(|(from, _)| ticks.contains(from))
}

impl fmt::Display for Score {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let part = |part: u64, of: u64| part as f64 / of.max(1) as f64;
        let [predicted, true_soon, both] = self.ticks;
        writeln!(f, "precision {:.3}, recall {:.3}", part(both, predicted), part(both, true_soon))?;
        let [warnings, came_true] = self.warnings;
        writeln!(f, "{warnings} warnings, of which {:.3} came true", part(came_true, warnings))?;
        let [contacts, ahead] = self.contacts;
        write!(
            f,
            "{contacts} contacts, of which {:.3} were predicted half a second ahead",
            part(ahead, contacts)
        )
    }
}
