//! The sweep of a variant: which numbers of robots and which seeds come next.
//!
//! Each step is a function of the finished runs, and asks only for runs that it needs whatever the
//! others give: first the grid with the least number of seeds, then the middles between the knee
//! and its neighbours, then seeds at the knee until its interval is narrow enough. All variants use
//! the same seeds 1, 2, 3 …, which are common random numbers: differences between variants have
//! narrower intervals than the variants themselves.

use std::collections::BTreeMap;

use crate::outcome::Measured;
use crate::plan::{Precision, Robots};
use crate::statistics::{Interval, knee};
use crate::workers::RunFailure;

/// The figures of a finished run, or the reason why it failed.
pub type RunResult = Result<Measured, RunFailure>;

/// A run of a variant: the number of robots and the seed.
pub type Run = (u32, u64);

/// The finished runs of a variant.
pub type Known = BTreeMap<Run, RunResult>;

/// The next step.
#[derive(Clone, Debug, PartialEq)]
pub enum Step {
    /// These runs are needed.
    Needs(Vec<Run>),
    /// No runs are needed.
    Done(Curve),
}

/// The result of a sweep.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Curve {
    /// The points, by ascending robots.
    pub points: Vec<Point>,
    /// The index of the knee; `None` if nothing is carried, or not without a stall.
    pub knee: Option<usize>,
    /// The index of the last point up to which each additional robot brings at least half of what
    /// one brings alone.
    pub half: Option<usize>,
    /// Whether the knee is the last point, so that the real one may be beyond it. Beyond a point
    /// with a stall, no knee is looked for.
    pub is_open: bool,
    /// The numbers of robots whose runs failed, with the reasons.
    pub failed: Vec<(u32, RunFailure)>,
}

/// A number of robots and its runs.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// The number of robots.
    pub robots: u32,
    /// The runs, by seed from 1 on.
    pub runs: Vec<Measured>,
}

impl Point {
    /// Returns a figure of all runs that have it as a mean with its interval.
    pub fn interval(&self, figure: impl Fn(&Measured) -> Option<f64>) -> Option<Interval> {
        Interval::of(&self.runs.iter().filter_map(figure).collect::<Vec<_>>())
    }

    /// Whether robots made no progress in one of the runs.
    pub fn is_stalled(&self) -> bool {
        self.runs.iter().any(Measured::is_stalled)
    }

    /// Returns the orders an hour, with the interval of their spread over the runs.
    pub fn throughput(&self) -> Option<Interval> {
        self.interval(|run| Some(run.orders_per_hour))
    }

    /// Returns the orders an hour, with an interval of at least one order a run: equal counts of
    /// few orders have no spread, but aren't exact.
    pub fn counted_throughput(&self) -> Option<Interval> {
        let secs = self.interval(|run| Some(run.secs))?.mean;
        Some(self.throughput()?.at_least(3600.0 / secs.max(1.0)))
    }
}

/// The largest half of an interval of a value that is known, as a part of the value.
const WIDEST: f64 = 1.0;

/// The largest number of rounds of refinement. Each at least halves a distance, so fewer are
/// needed.
const MAX_ROUNDS: usize = 64;

/// Returns the next step of a sweep.
pub fn next(robots: &Robots, precision: &Precision, known: &Known) -> Step {
    let mut wanted: BTreeMap<u32, u64> =
        robots.grid().into_iter().map(|robots| (robots, precision.least_seeds)).collect();
    for _ in 0..MAX_ROUNDS {
        let missing = missing(&wanted, known);
        if !missing.is_empty() {
            return Step::Needs(missing);
        }
        let curve = curve(&wanted, precision, known);
        let more =
            if robots.is_refined() { refined(&curve, precision, &wanted) } else { Vec::new() };
        if !more.is_empty() {
            wanted.extend(more.into_iter().map(|robots| (robots, precision.least_seeds)));
        } else {
            let more = more_seeds(&curve, precision);
            if more.is_empty() {
                return Step::Done(curve);
            }
            wanted.extend(more);
        }
    }
    Step::Done(curve(&wanted, precision, known))
}

/// Returns the wanted runs that aren't finished. Large ones come first: they take the longest.
fn missing(wanted: &BTreeMap<u32, u64>, known: &Known) -> Vec<Run> {
    let mut missing = Vec::new();
    for (&robots, &seeds) in wanted.iter().rev() {
        missing.extend((1..=seeds).map(|seed| (robots, seed)));
    }
    missing.retain(|run| !known.contains_key(run));
    missing
}

fn curve(wanted: &BTreeMap<u32, u64>, precision: &Precision, known: &Known) -> Curve {
    let mut curve = Curve::default();
    for (&robots, &seeds) in wanted {
        let mut runs = Vec::new();
        for seed in 1..=seeds {
            match known.get(&(robots, seed)) {
                Some(Ok(measured)) => runs.push(measured.clone()),
                Some(Err(reason))
                    if curve.failed.last().is_none_or(|(last, _)| *last != robots) =>
                {
                    curve.failed.push((robots, reason.clone()));
                }
                _ => {}
            }
        }
        if !runs.is_empty() {
            curve.points.push(Point { robots, runs });
        }
    }
    // A run with a stall isn't traffic, and a larger fleet isn't safer.
    let (mut points, mut indices) = (Vec::new(), Vec::new());
    let moving = curve.points.iter().enumerate().take_while(|(_, point)| !point.is_stalled());
    for (index, point) in moving {
        if let Some(throughput) = point.throughput() {
            points.push((f64::from(point.robots), throughput.mean));
            indices.push(index);
        }
    }
    curve.half = knee(&points, 0.5).map(|half| indices[half.index]);
    if let Some(found) = knee(&points, precision.knee) {
        let index = indices[found.index];
        (curve.knee, curve.is_open) = (Some(index), index + 1 == curve.points.len());
    }
    curve
}

/// Returns the numbers of robots halfway from the knee to its neighbours, unless these are near
/// enough, or the knee is beyond the range.
fn refined(curve: &Curve, precision: &Precision, wanted: &BTreeMap<u32, u64>) -> Vec<u32> {
    // Beyond the largest number there is nothing to find, and below it nothing that matters.
    let Some(knee) = curve.knee.filter(|_| !curve.is_open || !curve.failed.is_empty()) else {
        return Vec::new();
    };
    let knee = curve.points[knee].robots;
    let near = ((f64::from(knee) * precision.resolution) as u32).max(1);
    // A number of robots whose runs failed is a neighbour, too: the largest that can be is below
    // it.
    let before = wanted.range(..knee).next_back().map(|(robots, _)| *robots);
    let after = wanted.range(knee + 1..).next().map(|(robots, _)| *robots);
    let far = before.into_iter().chain(after).filter(|other| knee.abs_diff(*other) > near);
    far.map(|other| knee.midpoint(other)).filter(|robots| !wanted.contains_key(robots)).collect()
}

/// Returns the numbers of robots that need more seeds, with the numbers of these: the knee if its
/// interval isn't narrow enough, and others whose interval is wider than their value.
fn more_seeds(curve: &Curve, precision: &Precision) -> Vec<Run> {
    let mut more = Vec::new();
    for (index, point) in curve.points.iter().enumerate() {
        let has_failed = curve.failed.iter().any(|(robots, _)| *robots == point.robots);
        if has_failed || point.is_stalled() {
            continue;
        }
        let wanted = if curve.knee == Some(index) { precision.interval } else { WIDEST };
        let Some(interval) = point.throughput() else { continue };
        let seeds = interval.values as u64;
        if !interval.is_within(wanted) && seeds < precision.most_seeds {
            // Two at a time: one more hardly changes an interval, and there are two cores at least.
            more.push((point.robots, (seeds + 2).min(precision.most_seeds)));
        }
    }
    more
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::outcome::{Stall, StallKind};

    fn measured(orders_per_hour: f64) -> Measured {
        Measured {
            digest: String::new(),
            warm_up_secs: 0.0,
            secs: 3600.0,
            orders_per_hour,
            stops_per_hour: orders_per_hour,
            service_mean_secs: None,
            service_p50_secs: None,
            service_p99_secs: None,
            utilisation: 1.0,
            waiting: 0.0,
            empty: None,
            contacts: 0,
            stalls: Vec::new(),
            unserved: 0,
            other_findings: BTreeMap::new(),
            examples: BTreeMap::new(),
            finished_orders: orders_per_hour as u64,
            failed_orders: 0,
            open_orders: 0,
            wall_secs: 1.0,
        }
    }

    /// Sweeps with a plant whose throughput is a function of robots and seed; returns the curve and
    /// the number of rounds.
    fn sweep(
        robots: &str,
        plant: impl Fn(u32, u64) -> Result<f64, String>,
    ) -> (Curve, usize, Known) {
        let (robots, mut known) = (robots.parse().expect("robots"), Known::new());
        for round in 0..100 {
            match next(&robots, &Precision::default(), &known) {
                Step::Done(curve) => return (curve, round, known),
                Step::Needs(runs) => {
                    assert!(!runs.is_empty());
                    for (robots, seed) in runs {
                        let fate = plant(robots, seed).map(measured).map_err(RunFailure::Failed);
                        assert!(
                            known.insert((robots, seed), fate).is_none(),
                            "asked twice for {robots}, {seed}"
                        );
                    }
                }
            }
        }
        panic!("the sweep doesn't end");
    }

    /// Saturates at 180 robots, with a spread of 1 %.
    fn plant(robots: u32, seed: u64) -> Result<f64, String> {
        Ok(f64::from(robots.min(180)) * 20.0 * (1.0 + 0.01 * (seed as f64 - 2.0)))
    }

    #[test]
    fn the_knee_is_found_within_the_resolution() {
        let (curve, rounds, known) = sweep("1..1000", plant);
        let knee = curve.knee.expect("a knee");
        let robots = curve.points[knee].robots;
        assert!((170..=192).contains(&robots), "{robots}");
        assert!(
            curve.points[knee + 1].robots - robots <= 12
                && robots - curve.points[knee - 1].robots <= 12
        );
        assert!(
            !curve.is_open && rounds <= 8 && known.len() < 90,
            "{rounds} rounds, {} runs",
            known.len()
        );
        assert!(
            curve.points[knee].runs.len() > 3,
            "its interval is wider than 2 % with three seeds"
        );
    }

    #[test]
    fn a_curve_that_still_rises_is_open_and_a_list_is_not_refined() {
        let (curve, ..) = sweep("1..100", plant);
        assert!(curve.is_open && curve.knee.is_some_and(|knee| curve.points[knee].robots == 100));
        assert_eq!(curve.points.len(), 8, "1, 2, 4 … 64, 100");
        let (curve, _, known) = sweep("50,100,150", |robots, _| Ok(f64::from(robots.min(100))));
        assert_eq!((curve.points.len(), known.len()), (3, 9));
        assert_eq!((curve.knee, curve.half), (Some(1), Some(1)));
    }

    #[test]
    fn what_does_not_fit_ends_the_range() {
        let (curve, ..) = sweep("1..1000", |robots, seed| {
            if robots > 60 { Err("60 fit".to_owned()) } else { plant(robots, seed) }
        });
        let last = curve.points.last().expect("points").robots;
        assert!((57..=60).contains(&last), "{last}");
        assert!(
            curve
                .failed
                .iter()
                .all(|(robots, reason)| *robots > 60 && reason.to_string() == "60 fit")
        );
    }

    #[test]
    fn nothing_carried_is_no_endless_sweep() {
        let (curve, ..) = sweep("1..8", |_, _| Ok(0.0));
        assert_eq!(curve.knee, None);
        let (curve, ..) = sweep("1..8", |_, _| Err("broken".to_owned()));
        assert_eq!((curve.points.len(), curve.failed.len()), (0, 4));
    }

    /// Robots up to `most` carry 10 orders an hour each; more come to a standstill.
    fn stalling(most: u32) -> (Curve, Known) {
        let (robots, mut known) = ("1..64".parse().expect("robots"), Known::new());
        loop {
            match next(&robots, &Precision::default(), &known) {
                Step::Done(curve) => return (curve, known),
                Step::Needs(runs) => {
                    for (robots, seed) in runs {
                        let mut run = measured(f64::from(robots) * 10.0);
                        if robots > most && seed == 2 {
                            run.stalls.push(Stall {
                                kind: StallKind::Standstill,
                                from_secs: 60.0,
                                until_secs: None,
                                robots: vec![0],
                                place: None,
                                waits_for: BTreeMap::new(),
                                places: BTreeMap::new(),
                            });
                        }
                        known.insert((robots, seed), Ok(run));
                    }
                }
            }
        }
    }

    #[test]
    fn no_knee_is_computed_from_runs_that_stall() {
        let (curve, _) = stalling(11);
        let knee = curve.knee.expect("a knee");
        assert_eq!((curve.points[knee].robots, curve.is_open), (11, false));
        assert!(curve.points[knee + 1].robots == 12 && curve.points[knee + 1].is_stalled());
        let (curve, _) = stalling(0);
        assert_eq!((curve.knee, curve.points.len()), (None, 7));
    }

    #[test]
    fn a_value_narrower_than_its_interval_gets_more_seeds() {
        let wild = |robots, seed: u64| match (robots, seed) {
            (2, 1) => Ok(100.0),
            (2, _) => Ok(0.0),
            _ => Ok(50.0),
        };
        let (curve, ..) = sweep("1,2,4", wild);
        let seeds: Vec<usize> = curve.points.iter().map(|point| point.runs.len()).collect();
        assert_eq!(seeds, [3, 10, 3]);
    }
}
