//! The answer to the question for the least number of robots.

use serde::Serialize;

use super::StuckOrders;
use crate::plan::Target;
use crate::statistics::Interval;
use crate::sweep::least::{Standing, interval, of_figure, standing};
use crate::sweep::{Curve, Point, Trend};

/// The least number of robots that meets all targets.
#[derive(Clone, Debug, Serialize)]
pub struct LeastAnswer {
    /// The number; `None` if none of those that were tried meets them.
    pub robots: Option<u32>,
    /// The number that came closest to the targets.
    pub closest: Option<u32>,
    /// The largest number that was tried and has runs.
    pub most: u32,
    /// Larger numbers that were tried, and miss a target.
    pub worse: Vec<u32>,
    /// Larger numbers that were tried, and of which it isn't known whether they meet all targets.
    pub uncertain: Vec<u32>,
    /// The reason why fewer robots, or any, don't meet the targets.
    pub binding: Option<Binding>,
}

/// A number of robots that misses targets.
#[derive(Clone, Debug, Serialize)]
pub struct Binding {
    /// The number: the largest below the answer, or the closest one if there is no answer.
    pub robots: u32,
    /// The targets that it doesn't meet for sure.
    pub targets: Vec<TargetAnswer>,
    /// The number of its runs.
    pub runs: usize,
    /// The number of those in which robots made no progress: with any, it meets no target.
    pub stalled_runs: usize,
    /// Orders that weren't over at the end of a run.
    pub open_orders: Option<Interval>,
    /// Those of them that can't be carried.
    pub stuck_orders: StuckOrders,
    /// The development of the backlog.
    pub backlog: Trend,
    /// The part of the robots' time with an order.
    pub utilisation: Option<Interval>,
    /// The part of the robots' time in which they waited for room.
    pub waiting: Option<Interval>,
    /// The place that they waited for the most, if they waited for one.
    pub place: Option<String>,
}

/// A figure against its target.
#[derive(Clone, Debug, Serialize)]
pub struct TargetAnswer {
    /// The target.
    pub target: String,
    /// The name of the figure.
    pub name: String,
    /// The figure, over the runs; `None` if a run has none.
    pub value: Option<Interval>,
    /// The figure in words.
    pub words: String,
    /// The distance from the mean to the limit as a part of the limit; above 0 if it is met.
    pub margin: Option<f64>,
    /// The standing.
    pub standing: Standing,
    /// The standing of the figure alone, whatever the backlog and the runs' ends are.
    pub of_figure: Standing,
}

impl LeastAnswer {
    /// Returns the answer of a search; `None` for another question. `place` is the one that the
    /// robots of the binding number waited for the most.
    pub fn new(targets: &[Target], curve: &Curve, place: Option<String>) -> Option<Self> {
        let least = curve.least.as_ref()?;
        let after = least.found.map_or(curve.points.len(), |found| found + 1);
        let larger = &curve.points[after..];
        let ran = curve.points.iter().map(|point| point.robots).max();
        let failed = curve.failed.iter().map(|(robots, _)| *robots).max();
        Some(Self {
            robots: curve.robots(least.found),
            closest: curve.robots(least.closest),
            most: ran.or(failed).unwrap_or_default(),
            worse: of_standing(targets, larger, Standing::Missed),
            uncertain: of_standing(targets, larger, Standing::Open),
            binding: curve
                .binding()
                .map(|index| Binding { place, ..Binding::new(targets, &curve.points[index]) }),
        })
    }

    /// The number that the answer is about.
    pub fn chosen(&self) -> Option<u32> {
        self.robots.or(self.closest)
    }
}

/// Returns the numbers of robots of points whose worst standing against a target is this one.
fn of_standing(targets: &[Target], points: &[Point], wanted: Standing) -> Vec<u32> {
    let mut robots = Vec::new();
    for point in points {
        let worst = targets.iter().map(|target| standing(target, point)).max();
        if worst == Some(wanted) {
            robots.push(point.robots);
        }
    }
    robots
}

impl Binding {
    fn new(targets: &[Target], point: &Point) -> Self {
        let mut targets: Vec<TargetAnswer> =
            targets.iter().map(|target| TargetAnswer::new(target, point)).collect();
        targets.retain(|target| target.standing != Standing::Met);
        Self {
            robots: point.robots,
            targets,
            runs: point.runs.len(),
            stalled_runs: point.runs.iter().filter(|run| run.is_stalled()).count(),
            open_orders: point.interval(|run| Some(run.open_orders as f64)),
            stuck_orders: StuckOrders::of(point),
            backlog: point.trend(),
            utilisation: point.interval(|run| Some(run.utilisation)),
            waiting: point.interval(|run| Some(run.waiting)),
            place: None,
        }
    }
}

impl TargetAnswer {
    /// Compares the runs of a point with a target.
    pub fn new(target: &Target, point: &Point) -> Self {
        let value = interval(target, point);
        Self {
            target: target.to_string(),
            name: target.name(),
            value,
            words: value.map_or_else(|| "no figure".to_owned(), |value| target.in_words(&value)),
            margin: value.map(|value| target.margin(value.mean)),
            standing: standing(target, point),
            of_figure: of_figure(target, point),
        }
    }
}
