//! The race of reliefs: paired runs, of which those leave that can't win.
//!
//! All candidates begin with the least number of seeds, the same as those of the plant without a
//! relief. After each round, a candidate leaves if the paired difference to the best one is surely
//! against it, or if what it brings is surely under one per cent; the others get one more seed, up
//! to the most. 'Surely' is by intervals that hold for all candidates after all rounds together
//! with 95 % confidence (Bonferroni). The race is that of Maron and Moore (Hoeffding races, 1994),
//! with Student's paired intervals as in Moore and Lee (1994).

use super::{Candidate, Measure, Relief, Verdict};
use crate::outcome::{Measured, RunEnd};
use crate::statistics::Interval;
use crate::sweep::{Known, Run, RunResult};
use crate::workers::RunFailure;

/// The part of the figure under which a relief brings too little.
const LEAST_GAIN: f64 = 0.01;

/// The race of some candidates with a number of robots.
pub struct Race<'a> {
    /// The number of robots.
    pub robots: u32,
    /// The figure.
    pub measure: Measure,
    /// The least and the most seeds.
    pub seeds: [u64; 2],
    /// The finished runs without a relief.
    pub base: &'a Known,
    /// Those of each candidate.
    pub known: Vec<&'a Known>,
}

/// The next step of a race.
#[derive(Clone, Debug, PartialEq)]
pub enum Round {
    /// These runs are needed: those without a relief, and those of candidates by their index.
    Needs {
        /// Without a relief.
        base: Vec<Run>,
        /// The candidates' ones.
        candidates: Vec<(usize, Run)>,
    },
    /// It is over.
    Over(Vec<Standing>),
}

/// A candidate at the end of a race.
#[derive(Clone, Debug, PartialEq)]
pub struct Standing {
    /// The number of its seeds.
    seeds: u64,
    /// Whether it left before the end.
    has_left: bool,
}

impl Race<'_> {
    /// Returns the next round: a function of the finished runs.
    pub fn next(&self) -> Round {
        let [least, most] = self.seeds;
        let mut field: Vec<usize> = (0..self.known.len()).collect();
        let mut standings = vec![Standing { seeds: least, has_left: false }; self.known.len()];
        let mut seeds = least;
        loop {
            if let Some(needs) = self.missing(&field, seeds) {
                return needs;
            }
            field.retain(|candidate| self.failure(*candidate, seeds).is_none());
            for candidate in &field {
                standings[*candidate].seeds = seeds;
            }
            if seeds == most || self.is_decided(&field, seeds) {
                return Round::Over(standings);
            }
            for candidate in self.losers(&field, seeds) {
                standings[candidate].has_left = true;
            }
            field.retain(|candidate| !standings[*candidate].has_left);
            if field.is_empty() {
                return Round::Over(standings);
            }
            seeds += 1;
        }
    }

    /// Returns the number of runs that are expected after the next round: the race is continued on
    /// guesses, by which further seeds repeat the finished ones. Before the first round, each
    /// candidate is expected to get half of the further seeds.
    pub fn outlook(&self) -> usize {
        let [least, most] = self.seeds;
        if self.known.iter().any(|known| known.is_empty()) {
            return self.known.len() * (most - least) as usize / 2;
        }
        let mut base = self.base.clone();
        let mut known: Vec<Known> = self.known.iter().map(|known| (*known).clone()).collect();
        let mut rounds = Vec::new();
        loop {
            let Race { robots, measure, seeds, .. } = *self;
            let known_now = known.iter().collect();
            let race = Race { robots, measure, seeds, base: &base, known: known_now };
            let Round::Needs { base: of_base, candidates } = race.next() else { break };
            rounds.push(of_base.len() + candidates.len());
            for run in of_base {
                base.insert(run, guess(self.base, run));
            }
            for (index, run) in candidates {
                known[index].insert(run, guess(self.known[index], run));
            }
        }
        rounds.iter().skip(1).sum()
    }

    /// Returns the runs up to a seed that aren't finished; `None` if there are none.
    fn missing(&self, field: &[usize], seeds: u64) -> Option<Round> {
        let runs = (1..=seeds).map(|seed| (self.robots, seed));
        let base: Vec<Run> = runs.clone().filter(|run| !self.base.contains_key(run)).collect();
        let mut candidates = Vec::new();
        for candidate in field {
            let known = self.known[*candidate];
            let missing = runs.clone().filter(|run| !known.contains_key(run));
            candidates.extend(missing.map(|run| (*candidate, run)));
        }
        (!base.is_empty() || !candidates.is_empty()).then_some(Round::Needs { base, candidates })
    }

    /// Whether a single candidate is left that surely helps.
    fn is_decided(&self, field: &[usize], seeds: u64) -> bool {
        let [only] = field else { return field.is_empty() };
        self.gain(*only, seeds).is_some_and(|gain| low(&gain) > 0.0)
    }

    /// Returns the candidates that leave.
    fn losers(&self, field: &[usize], seeds: u64) -> Vec<usize> {
        let mean = |candidate: &usize| {
            self.gain(*candidate, seeds).map_or(f64::NEG_INFINITY, |gain| gain.mean)
        };
        let Some(best) = field.iter().copied().max_by(|a, b| mean(a).total_cmp(&mean(b))) else {
            return Vec::new();
        };
        let least = LEAST_GAIN * self.base_mean(seeds).abs();
        let mut losers = Vec::new();
        for &candidate in field {
            let brings_little = self.gain(candidate, seeds).is_none_or(|gain| high(&gain) < least);
            let is_beaten = candidate != best
                && self.ahead(best, candidate, seeds).is_some_and(|ahead| low(&ahead) > 0.0);
            if brings_little || is_beaten {
                losers.push(candidate);
            }
        }
        losers
    }

    /// Returns the mean figure without a relief over the seeds up to one.
    pub fn base_mean(&self, seeds: u64) -> f64 {
        let values: Vec<f64> =
            (1..=seeds).filter_map(|seed| self.figure(self.base, seed)).collect();
        values.iter().sum::<f64>() / values.len().max(1) as f64
    }

    fn gain(&self, candidate: usize, seeds: u64) -> Option<Interval> {
        self.difference(self.base, self.known[candidate], seeds)
    }

    fn ahead(&self, best: usize, other: usize, seeds: u64) -> Option<Interval> {
        self.difference(self.known[other], self.known[best], seeds)
    }

    /// Returns what `other` brings more than `base`, seed by seed: better is above 0.
    fn difference(&self, base: &Known, other: &Known, seeds: u64) -> Option<Interval> {
        let mut differences = Vec::new();
        for seed in 1..=seeds {
            if let (Some(base), Some(other)) = (self.figure(base, seed), self.figure(other, seed)) {
                differences.push(self.measure.sign() * (other - base));
            }
        }
        let [least, most] = self.seeds;
        let looks = most.saturating_sub(least) + 1;
        Interval::joint(&differences, self.known.len() * looks as usize)
    }

    fn figure(&self, known: &Known, seed: u64) -> Option<f64> {
        self.measure.value(run(known, self.robots, seed)?)
    }

    /// Returns the reason why a candidate's runs don't count.
    fn failure(&self, candidate: usize, seeds: u64) -> Option<(Verdict, Option<String>)> {
        for seed in 1..=seeds {
            let base = run(self.base, self.robots, seed);
            match self.known[candidate].get(&(self.robots, seed)) {
                Some(Err(failure)) => return Some((Verdict::NotKnown, Some(failure.to_string()))),
                Some(Ok(run)) if is_stuck(run) && base.is_some_and(|base| !is_stuck(base)) => {
                    return Some((Verdict::Stalls, None));
                }
                _ => {}
            }
        }
        None
    }

    /// Returns a candidate with its finding at the end of the race.
    pub fn relief(&self, index: usize, candidate: Candidate, standing: &Standing) -> Relief {
        let gain = self.gain(index, standing.seeds);
        let (verdict, failure) = match (self.failure(index, standing.seeds), &gain) {
            (Some(failure), _) => failure,
            (None, None) => (Verdict::NotKnown, None),
            (None, Some(gain)) if low(gain) > 0.0 => (Verdict::Helps, None),
            (None, Some(gain)) if high(gain) < 0.0 => (Verdict::Harms, None),
            (None, Some(_)) => (Verdict::WithinChance, None),
        };
        Relief { candidate, gain, verdict, has_left: standing.has_left, failure }
    }
}

impl Standing {
    /// The number of its seeds.
    pub fn seeds(&self) -> u64 {
        self.seeds
    }
}

/// Guesses the result of a run: the finished ones are repeated.
fn guess(known: &Known, (robots, seed): Run) -> RunResult {
    let finished: Vec<&RunResult> =
        known.range((robots, 0)..=(robots, u64::MAX)).map(|(_, result)| result).collect();
    match finished.get(seed as usize % finished.len().max(1)) {
        Some(result) => (*result).clone(),
        None => Err(RunFailure::Failed(String::new())),
    }
}

fn run(known: &Known, robots: u32, seed: u64) -> Option<&Measured> {
    known.get(&(robots, seed))?.as_ref().ok()
}

/// Whether the figures of a run aren't those of traffic: without progress, or a day without an end.
fn is_stuck(run: &Measured) -> bool {
    run.is_stalled() || run.end == RunEnd::Overdue
}

/// The lower end of an interval; that of a single value is unknown.
fn low(interval: &Interval) -> f64 {
    interval.half_width.map_or(f64::NEG_INFINITY, |half| interval.mean - half)
}

fn high(interval: &Interval) -> f64 {
    interval.half_width.map_or(f64::INFINITY, |half| interval.mean + half)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sweep::tests::measured;

    /// Races candidates whose gains are functions of the seed; returns their seeds, and whether
    /// they left.
    fn race(gains: &[fn(u64) -> f64]) -> Vec<(u64, bool)> {
        let (mut base, mut known) = (Known::new(), vec![Known::new(); gains.len()]);
        for _ in 0..100 {
            let race = Race {
                robots: 5,
                measure: Measure::Throughput,
                seeds: [3, 10],
                base: &base,
                known: known.iter().collect(),
            };
            match race.next() {
                Round::Over(standings) => {
                    return standings.iter().map(|it| (it.seeds, it.has_left)).collect();
                }
                Round::Needs { base: more, candidates } => {
                    let noise = |seed: u64| 100.0 + 7.0 * (seed as f64).sin();
                    for run in more {
                        base.insert(run, Ok(measured(noise(run.1))));
                    }
                    for (index, run) in candidates {
                        let orders = noise(run.1) + gains[index](run.1);
                        assert!(known[index].insert(run, Ok(measured(orders))).is_none());
                    }
                }
            }
        }
        panic!("the race doesn't end");
    }

    fn wave(seed: u64) -> f64 {
        0.4 * (3.0 * seed as f64).cos()
    }

    #[test]
    fn the_best_stays_and_those_that_cannot_win_leave() {
        let standings = race(&[
            |seed| 30.0 + wave(seed),
            |seed| 10.0 + wave(seed + 1),
            |seed| wave(seed + 2),
            |seed| -20.0 + wave(seed),
        ]);
        assert!(!standings[0].1);
        assert!(standings[1..].iter().all(|(seeds, left)| *left && *seeds < 10), "{standings:?}");
        assert!(standings[0].0 < 10, "it is decided: {standings:?}");
    }

    #[test]
    fn those_that_cannot_be_told_apart_run_to_the_end() {
        let standings = race(&[|seed| 5.0 + 8.0 * wave(seed), |seed| 5.0 - 8.0 * wave(seed)]);
        assert_eq!(standings, [(10, false), (10, false)]);
    }

    #[test]
    fn what_surely_brings_nothing_ends_the_race() {
        let standings = race(&[|seed| 0.1 * wave(seed), |seed| -0.1 * wave(seed)]);
        assert_eq!(standings, [(3, true), (3, true)]);
    }

    #[test]
    fn a_stall_with_a_relief_is_no_gain() {
        let base: Known = (1..=3).map(|seed| ((5, seed), Ok(measured(100.0)))).collect();
        let mut other: Known = (1..=3).map(|seed| ((5, seed), Ok(measured(150.0)))).collect();
        let mut overdue = measured(150.0);
        overdue.end = RunEnd::Overdue;
        other.insert((5, 2), Ok(overdue));
        let race = Race {
            robots: 5,
            measure: Measure::Throughput,
            seeds: [3, 3],
            base: &base,
            known: vec![&other],
        };
        let Round::Over(standings) = race.next() else { panic!("all runs are there") };
        let candidate = Candidate {
            remedy: super::super::Remedy::Repair,
            words: String::new(),
            about: "",
            robots: 0.0,
        };
        assert_eq!(race.relief(0, candidate, &standings[0]).verdict, Verdict::Stalls);
    }
}
