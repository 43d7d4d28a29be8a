//! The sweep for the least number of robots that meets some targets: doubling until a number meets
//! them, then halving the distance to the largest one below that doesn't, then the neighbours, as
//! more robots needn't be better. A number whose intervals contain a limit gets more seeds.

use std::collections::{BTreeMap, BTreeSet};

use serde::Serialize;

use super::{Curve, Known, Point, Run, Step, Trend, missing, points};
use crate::outcome::{Measured, RunEnd, Service};
use crate::plan::{Precision, Robots, Side, Statistic, Target, TargetFigure};
use crate::statistics::Interval;

/// The distance up to which the neighbours of the answer are run.
const NEIGHBOURS: u32 = 2;
/// The largest number of rounds, of numbers of robots or of seeds.
const MAX_ROUNDS: usize = 1000;

/// The answer of a sweep for the least number of robots, as indices of points.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Least {
    /// The least number that meets all targets.
    pub found: Option<usize>,
    /// The largest number below it.
    pub fewer: Option<usize>,
    /// The number that came closest to the targets.
    pub closest: Option<usize>,
}

impl Least {
    /// Returns the index of the point that the answer is about.
    pub fn chosen(&self) -> Option<usize> {
        self.found.or(self.closest)
    }
}

/// A number of robots against a target.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Standing {
    /// It meets it, with 95 % confidence.
    Met,
    /// The interval contains the limit, or the backlog may grow.
    Open,
    /// It misses it, with 95 % confidence; or a run had no end or no progress, or orders come as fast
    /// as they are carried, or faster.
    Missed,
}

/// Returns the figure of a target in a run; `None` if the run has none.
pub fn value(target: &Target, run: &Measured) -> Option<f64> {
    match target.figure {
        TargetFigure::Service(statistic) => Some(of_service(statistic, run.service.as_ref()?)),
        TargetFigure::Late => run.late,
        TargetFigure::Waiting => Some(run.waiting),
        TargetFigure::Utilisation => Some(run.utilisation),
        TargetFigure::Throughput => Some(run.orders_per_hour),
    }
}

fn of_service(statistic: Statistic, service: &Service) -> f64 {
    match statistic {
        Statistic::Mean => service.mean_secs,
        Statistic::P50 => service.p50_secs,
        Statistic::P90 => service.p90_secs,
        Statistic::P95 => service.p95_secs,
        Statistic::P99 => service.p99_secs,
        Statistic::Longest => service.longest_secs,
    }
}

/// Returns the figure of a target over the runs of a point; `None` if a run has none.
pub fn interval(target: &Target, point: &Point) -> Option<Interval> {
    let values: Option<Vec<f64>> = point.runs.iter().map(|run| value(target, run)).collect();
    let interval = Interval::of(&values?)?;
    match target.figure {
        // Equal counts of few orders have no spread, but aren't exact.
        TargetFigure::Throughput => point.counted_throughput(),
        _ => Some(interval),
    }
}

/// Returns the standing of a point against a target. As long as the backlog grows, orders take the
/// longer the longer a run is.
pub fn standing(target: &Target, point: &Point) -> Standing {
    if point.is_stalled() || is_overdue(point) {
        return Standing::Missed;
    }
    let of_figure = of_figure(target, point);
    if !target.is_of_orders() {
        return of_figure;
    }
    of_figure.max(match point.trend() {
        Trend::Steady => Standing::Met,
        Trend::Unclear => Standing::Open,
        Trend::Saturated | Trend::Growing(_) => Standing::Missed,
    })
}

/// Returns the standing of the figure alone.
pub fn of_figure(target: &Target, point: &Point) -> Standing {
    let Some(interval) = interval(target, point) else { return Standing::Missed };
    let Some(half_width) = interval.half_width else { return Standing::Open };
    let [low, high] = [-half_width, half_width].map(|half| target.margin(interval.mean + half));
    // `late < 25%` excludes 25 %, `400 orders/h` includes 400: without spread, that is certain.
    if half_width == 0.0 && low == 0.0 {
        return match target.side() {
            Side::AtMost => Standing::Missed,
            Side::AtLeast => Standing::Met,
        };
    }
    match (low.min(high) > 0.0, low.max(high) < 0.0) {
        (true, _) => Standing::Met,
        (_, true) => Standing::Missed,
        _ => Standing::Open,
    }
}

/// Whether a day wasn't over at its limit in a run.
fn is_overdue(point: &Point) -> bool {
    point.runs.iter().any(|run| run.end == RunEnd::Overdue)
}

/// Returns the standing of a point against all targets.
fn of_all(targets: &[Target], point: &Point) -> Standing {
    targets.iter().map(|target| standing(target, point)).max().unwrap_or(Standing::Met)
}

/// Returns the next step of the sweep.
pub(super) fn next(
    targets: &[Target],
    robots: &Robots,
    precision: &Precision,
    known: &Known,
) -> Step {
    let first = match robots {
        Robots::Range(from, _) => vec![*from],
        Robots::List(list) => list.clone(),
    };
    let mut wanted: BTreeMap<u32, u64> =
        first.into_iter().map(|robots| (robots, precision.least_seeds)).collect();
    for _ in 0..MAX_ROUNDS {
        let missing = missing(&wanted, known);
        if !missing.is_empty() {
            return Step::Needs(missing);
        }
        let curve = points(&wanted, known);
        let seeds = more_seeds(targets, &curve, precision);
        if !seeds.is_empty() {
            wanted.extend(seeds);
            continue;
        }
        let more = match robots {
            Robots::Range(from, to) => {
                Search { targets, from: *from, to: *to, precision, curve: &curve }.next()
            }
            Robots::List(_) => Vec::new(),
        };
        if more.is_empty() {
            return Step::Done(judged(targets, curve));
        }
        wanted.extend(more.into_iter().map(|robots| (robots, precision.least_seeds)));
    }
    Step::Done(judged(targets, points(&wanted, known)))
}

/// Returns the numbers of robots whose standing is open, with the numbers of their seeds.
fn more_seeds(targets: &[Target], curve: &Curve, precision: &Precision) -> Vec<Run> {
    let mut more = Vec::new();
    for point in curve.points.iter().filter(|point| !has_failed(curve, point.robots)) {
        let seeds = point.runs.len() as u64;
        if of_all(targets, point) == Standing::Open && seeds < precision.most_seeds {
            more.push((point.robots, (seeds + 2).min(precision.most_seeds)));
        }
    }
    more
}

fn has_failed(curve: &Curve, robots: u32) -> bool {
    curve.failed.iter().any(|(failed, _)| *failed == robots)
}

/// Whether a point meets all targets.
fn meets(targets: &[Target], curve: &Curve, point: &Point) -> bool {
    !has_failed(curve, point.robots) && of_all(targets, point) == Standing::Met
}

/// Returns the curve with its answer.
fn judged(targets: &[Target], mut curve: Curve) -> Curve {
    let found = curve.points.iter().position(|point| meets(targets, &curve, point));
    let fewer = found.and_then(|found| found.checked_sub(1));
    curve.least = Some(Least { found, fewer, closest: closest(targets, &curve) });
    curve
}

/// Returns the index of the point that comes closest to the targets: one that may meet all of them
/// before one that misses some, and then that with the best margin of the target which it misses
/// the most. Runs without an end or progress come last.
fn closest(targets: &[Target], curve: &Curve) -> Option<usize> {
    let scores = curve.points.iter().map(|point| score(targets, point));
    let best = scores.enumerate().max_by(|(_, a), (_, b)| {
        a.iter().zip(b).map(|(a, b)| a.total_cmp(b)).find(|order| order.is_ne()).unwrap_or(
            // Of equal ones, the first.
            std::cmp::Ordering::Greater,
        )
    });
    best.map(|(index, _)| index)
}

/// Returns whether a point may meet all targets, as 1 or 0, its worst margin, and its throughput
/// if it has no margin. Of numbers of robots with equal scores the smallest comes closest.
fn score(targets: &[Target], point: &Point) -> [f64; 3] {
    let intervals = targets.iter().map(|target| (target, interval(target, point)));
    let margins = intervals.map(|(target, interval)| {
        interval.map_or(f64::NEG_INFINITY, |interval| target.margin(interval.mean))
    });
    let worst = margins.fold(f64::INFINITY, f64::min);
    let is_behind = targets.iter().any(Target::is_of_orders)
        && matches!(point.trend(), Trend::Saturated | Trend::Growing(_));
    let is_whole = !point.is_stalled() && !is_overdue(point) && !is_behind;
    let worst = if is_whole { worst } else { f64::NEG_INFINITY };
    let throughput = match worst.is_finite() {
        true => 0.0,
        false => point.throughput().map_or(0.0, |interval| interval.mean),
    };
    let may_meet = f64::from(u8::from(of_all(targets, point) < Standing::Missed));
    [may_meet, worst, throughput]
}

/// The search among the numbers that were tried.
struct Search<'a> {
    targets: &'a [Target],
    from: u32,
    to: u32,
    precision: &'a Precision,
    curve: &'a Curve,
}

impl Search<'_> {
    /// Returns the next numbers of robots; none if the answer is known.
    fn next(&self) -> Vec<u32> {
        let points = &self.curve.points;
        let met = points.iter().find(|point| meets(self.targets, self.curve, point));
        match (met, self.largest()) {
            (Some(met), _) => self.below(met.robots),
            (None, None) => Vec::new(),
            (None, Some(largest)) => self.above(largest),
        }
    }

    /// The largest number of robots that has figures.
    fn largest(&self) -> Option<u32> {
        let mut points = self.curve.points.iter().rev().map(|point| point.robots);
        points.find(|robots| !has_failed(self.curve, *robots))
    }

    /// Returns the numbers between one that meets the targets and the next one that was tried, or
    /// its neighbours.
    fn below(&self, met: u32) -> Vec<u32> {
        let tried = self.tried();
        match tried.range(..met).next_back() {
            Some(fewer) if met - fewer > 1 => vec![fewer.midpoint(met)],
            _ => {
                let near = met.saturating_sub(NEIGHBOURS)..=met.saturating_add(NEIGHBOURS);
                near.filter(|robots| self.is_new(&tried, *robots)).collect()
            }
        }
    }

    /// Returns the next numbers if none meets the targets: twice as many robots, or some between
    /// the largest number that has figures and one that has none, or some beside the closest.
    fn above(&self, largest: u32) -> Vec<u32> {
        let tried = self.tried();
        let Some(failed) = tried.range(largest + 1..).next() else {
            let twice = largest.saturating_mul(2).min(self.to);
            return if largest < self.to { vec![twice] } else { self.beside_closest(&tried) };
        };
        if failed - largest > self.near(largest) {
            return vec![largest.midpoint(*failed)];
        }
        self.beside_closest(&tried)
    }

    /// Returns the numbers halfway from the closest one to its neighbours, unless these are near.
    fn beside_closest(&self, tried: &BTreeSet<u32>) -> Vec<u32> {
        let Some(index) = closest(self.targets, self.curve) else { return Vec::new() };
        let robots = self.curve.points[index].robots;
        let before = tried.range(..robots).next_back();
        let after = tried.range(robots + 1..).next();
        let far = before.into_iter().chain(after);
        let far = far.filter(|other| robots.abs_diff(**other) > self.near(robots));
        let middles = far.map(|other| robots.midpoint(*other));
        middles.filter(|robots| self.is_new(tried, *robots)).collect()
    }

    /// The distance of numbers that are near enough where there is no answer.
    fn near(&self, robots: u32) -> u32 {
        ((f64::from(robots) * self.precision.resolution) as u32).max(1)
    }

    /// All numbers that were tried.
    fn tried(&self) -> BTreeSet<u32> {
        let points = self.curve.points.iter().map(|point| point.robots);
        points.chain(self.curve.failed.iter().map(|(robots, _)| *robots)).collect()
    }

    fn is_new(&self, tried: &BTreeSet<u32>, robots: u32) -> bool {
        (self.from..=self.to).contains(&robots) && !tried.contains(&robots)
    }
}

#[cfg(test)]
mod tests;
