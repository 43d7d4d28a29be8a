//! The sweep of a variant: which numbers of robots and which seeds come next.
//!
//! Each step is a function of the finished runs, and asks only for runs that it needs whatever the
//! others give. There are two kinds of sweeps: for the knee of the curve ([`knee`]), and for the
//! least number of robots that meets some targets ([`least`]). All variants use the same seeds
//! 1, 2, 3 …, which are common random numbers: differences between variants have narrower
//! intervals than the variants themselves.

mod knee;
pub mod least;
mod outlook;

use std::collections::BTreeMap;

use serde::Serialize;

use crate::outcome::{Measured, RunEnd, Service};
use crate::plan::{Precision, Question, Robots};
use crate::statistics::Interval;
use crate::workers::RunFailure;

pub use least::Least;
pub use outlook::{Outlook, outlook};

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
    /// The index of the last point up to which each additional robot brings at least 90 % of what one
    /// brings alone.
    pub most_of: Option<usize>,
    /// The index of the point that carries the most.
    pub most: Option<usize>,
    /// Whether the knee is the last point, so that the real one may be beyond it. Beyond a point
    /// with a stall, no knee is looked for.
    pub is_open: bool,
    /// The answer of a sweep for the least number of robots.
    pub least: Option<Least>,
    /// The numbers of robots whose runs failed, with the reasons.
    pub failed: Vec<(u32, RunFailure)>,
}

/// A number of robots and its runs.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// The number of robots.
    pub robots: u32,
    /// The seeds of the runs that succeeded, in ascending order.
    pub seeds: Vec<u64>,
    /// The runs with these seeds.
    pub runs: Vec<Measured>,
}

/// The development of the backlog in runs with a load that comes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Trend {
    /// Robots carry what comes.
    Steady,
    /// It may grow, or be chance.
    Unclear,
    /// Robots have an order nearly all the time while more orders wait: orders come as fast as they
    /// are carried, or faster.
    Saturated,
    /// Orders come faster than they are carried, with 95 % confidence: the growth in half of a run's
    /// time, in orders.
    Growing(Interval),
}

impl Point {
    /// Returns a figure of all runs that have it as a mean with its interval.
    pub fn interval(&self, figure: impl Fn(&Measured) -> Option<f64>) -> Option<Interval> {
        Interval::of(&self.runs.iter().filter_map(figure).collect::<Vec<_>>())
    }

    /// Returns a statistic of the service times of all runs that have them.
    pub fn service(&self, statistic: fn(&Service) -> f64) -> Option<Interval> {
        self.interval(|run| run.service.as_ref().map(statistic))
    }

    /// Whether robots made no progress in one of the runs.
    pub fn is_stalled(&self) -> bool {
        self.runs.iter().any(Measured::is_stalled)
    }

    /// Returns the development of the backlog. A day ends with its orders, and is steady.
    pub fn trend(&self) -> Trend {
        let growth = self.interval(|run| Some(run.backlog_growth));
        let finished = self.interval(|run| Some(run.finished_orders as f64));
        let (Some(growth), Some(finished)) = (growth, finished) else { return Trend::Steady };
        if self.runs.iter().any(|run| run.end != RunEnd::AtTime) {
            return Trend::Steady;
        }
        let least = LEAST_GROWTH.max(LEAST_GROWTH_PART * finished.mean);
        // A single run has a spread as counts of independent orders have.
        let half_width = growth.half_width.unwrap_or(2.0 * finished.mean.sqrt());
        if growth.mean >= least && growth.mean - half_width >= 1.0 {
            return Trend::Growing(growth);
        }
        if self.is_saturated() {
            return Trend::Saturated;
        }
        let most = LEAST_GROWTH.max(MOST_GROWTH_PART * finished.mean);
        let is_steady = growth.mean < LEAST_GROWTH || growth.mean + half_width <= most;
        if is_steady { Trend::Steady } else { Trend::Unclear }
    }

    /// Whether robots have an order nearly all the time while more orders wait.
    fn is_saturated(&self) -> bool {
        let utilisation = self.interval(|run| Some(run.utilisation));
        let open = self.interval(|run| Some(run.carriable_orders()));
        let (Some(utilisation), Some(open)) = (utilisation, open) else { return false };
        let waiting = open.mean - f64::from(self.robots);
        utilisation.mean >= ALWAYS_BUSY && waiting >= LEAST_GROWTH
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

impl Curve {
    /// Returns the index of the point that the answer is about: the knee, or the least number of
    /// robots, or the one that came closest to the targets.
    pub fn chosen(&self) -> Option<usize> {
        self.knee.or_else(|| self.least.as_ref()?.chosen())
    }

    /// Returns the number of robots of a point.
    pub fn robots(&self, index: Option<usize>) -> Option<u32> {
        Some(self.points.get(index?)?.robots)
    }

    /// Returns the index of the point that shows why fewer robots, or any, don't meet the targets.
    pub fn binding(&self) -> Option<usize> {
        let least = self.least.as_ref()?;
        if least.found.is_some() { least.fewer } else { least.closest }
    }
}

/// The least growth of a backlog that isn't chance, in orders, and as a part of those that were
/// finished.
const LEAST_GROWTH: f64 = 2.0;
const LEAST_GROWTH_PART: f64 = 0.01;
/// The part of the finished orders by which the backlog may grow in half of the time until it isn't
/// known to be steady: 10 % of those that come then.
const MOST_GROWTH_PART: f64 = 0.05;

/// The part of the time with an order from which on robots are busy all the time.
const ALWAYS_BUSY: f64 = 0.98;

/// The largest number of rounds of refinement. Each at least halves a distance, so fewer are
/// needed.
const MAX_ROUNDS: usize = 64;

/// Returns the next step of a sweep.
pub fn next(question: &Question, robots: &Robots, precision: &Precision, known: &Known) -> Step {
    match question {
        Question::Knee => knee::next(robots, precision, known),
        Question::Least(targets) => least::next(targets, robots, precision, known),
    }
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

/// Returns the points of the wanted runs that are finished.
fn points(wanted: &BTreeMap<u32, u64>, known: &Known) -> Curve {
    let mut curve = Curve::default();
    for (&robots, &seeds) in wanted {
        let mut point = Point { robots, seeds: Vec::new(), runs: Vec::new() };
        for seed in 1..=seeds {
            match known.get(&(robots, seed)) {
                Some(Ok(measured)) => {
                    point.seeds.push(seed);
                    point.runs.push(measured.clone());
                }
                Some(Err(reason))
                    if curve.failed.last().is_none_or(|(last, _)| *last != robots) =>
                {
                    curve.failed.push((robots, reason.clone()));
                }
                _ => {}
            }
        }
        if !point.runs.is_empty() {
            curve.points.push(point);
        }
    }
    curve
}

#[cfg(test)]
pub(crate) mod tests;
