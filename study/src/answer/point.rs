//! A point of a curve in an answer.

use std::collections::BTreeMap;

use regatta_layout::RouteGraph;
use regatta_meter::orders::{Lack, Unplaced};
use serde::Serialize;

use super::time::{PartAnswer, order_time, robot_time, station};
use super::{TargetAnswer, sums};
use crate::outcome::{Example, RunEnd, Stall};
use crate::plan::Target;
use crate::statistics::Interval;
use crate::sweep::{Point, Trend};

/// The part of the time with an order from which on robots are busy.
pub const BUSY: f64 = 0.8;
/// The least orders of a busy robot in a run for a throughput: with fewer, those that are under
/// way at the beginning and at the end count too much.
const LEAST_ORDERS: f64 = 3.0;

/// A point of a curve: means over its runs, with intervals.
#[derive(Clone, Debug, Serialize)]
pub struct PointAnswer {
    /// The number of robots.
    pub robots: u32,
    /// The seeds of its runs, with the digests of all frames.
    pub runs: Vec<RunAnswer>,
    /// Its figures against the targets.
    pub targets: Vec<TargetAnswer>,
    /// Finished orders an hour.
    pub orders_per_hour: Option<Interval>,
    /// Finished stops an hour.
    pub stops_per_hour: Option<Interval>,
    /// The mean time from an order's creation to its end, in seconds.
    pub service_mean_secs: Option<Interval>,
    /// The 50th percentile of it.
    pub service_p50_secs: Option<Interval>,
    /// The 90th percentile of it.
    pub service_p90_secs: Option<Interval>,
    /// The 95th percentile of it.
    pub service_p95_secs: Option<Interval>,
    /// The 99th percentile of it.
    pub service_p99_secs: Option<Interval>,
    /// The longest.
    pub service_longest_secs: Option<Interval>,
    /// The part of the orders with a deadline that were late.
    pub late: Option<Interval>,
    /// The part of the robots' time with an order.
    pub utilisation: Option<Interval>,
    /// The part of the robots' time in which they wait for room.
    pub waiting: Option<Interval>,
    /// The part of the way without a load.
    pub empty: Option<Interval>,
    /// The parts of an order's time, which add up to its mean time.
    pub order_time: Vec<PartAnswer>,
    /// The parts of the robots' time, which add up to 1.
    pub robot_time: Vec<PartAnswer>,
    /// The warm-up that was cut off, in seconds: the mean.
    pub warm_up_secs: Option<Interval>,
    /// Contacts in all runs.
    pub contacts: u64,
    /// Orders that waited for a long time, in all runs.
    pub unserved: u64,
    /// Other findings of the validator in all runs, by kind.
    pub other_findings: BTreeMap<String, u64>,
    /// Orders that were finished in all runs, the warm-ups included.
    pub finished_orders: u64,
    /// Orders that the manager gave up, in all runs.
    pub failed_orders: u64,
    /// Orders that weren't over at the end.
    pub open_orders: Option<Interval>,
    /// Those of them that can't be carried.
    pub stuck_orders: StuckOrders,
    /// The development of the backlog.
    pub backlog: Trend,
    /// Storages that are full or empty at the end, with the orders that wait for them.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub storages: Vec<StorageLack>,
    /// Runs of a day that weren't over at their limit.
    pub overdue_runs: usize,
}

/// Orders that can't be carried at the end of a run, whatever the number of robots: means.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct StuckOrders {
    /// No robot of the fleet can carry them out.
    pub unroutable: f64,
    /// They wait for a place or a load of a storage.
    pub unplaced: f64,
}

impl StuckOrders {
    /// Returns those of a point.
    pub fn of(point: &Point) -> Self {
        let runs = point.runs.len().max(1) as f64;
        let unroutable: u64 = point.runs.iter().map(|run| run.unroutable_orders).sum();
        let unplaced = point.runs.iter().flat_map(|run| &run.unplaced);
        let unplaced: u64 = unplaced.map(|unplaced| unplaced.orders).sum();
        Self { unroutable: unroutable as f64 / runs, unplaced: unplaced as f64 / runs }
    }

    /// Whether they are most of so many open orders.
    pub fn are_most_of(&self, open: f64) -> bool {
        self.unroutable + self.unplaced > 0.5 * open
    }

    /// Tells them, for example `12 can't be carried by any robot of the fleet`.
    pub fn in_words(&self) -> Option<String> {
        let mut words = Vec::new();
        if self.unroutable >= 0.5 {
            words
                .push(format!("{:.0} can't be carried by any robot of the fleet", self.unroutable));
        }
        if self.unplaced >= 0.5 {
            let verb = if self.unplaced < 1.5 { "waits" } else { "wait" };
            words.push(format!("{:.0} {verb} for a place or a load of a storage", self.unplaced));
        }
        (!words.is_empty()).then(|| words.join(", and "))
    }
}

/// A storage that is full or empty at the end of runs, for which orders wait.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StorageLack {
    /// The name of its first place.
    pub name: String,
    /// Whether it is full; otherwise it is empty.
    pub is_full: bool,
    /// The number of runs.
    pub runs: u64,
    /// The mean number of orders that wait for it at the end of such a run.
    pub orders: f64,
}

/// A run of a point.
#[derive(Clone, Debug, Serialize)]
pub struct RunAnswer {
    /// The seed.
    pub seed: u64,
    /// The digest of all frames.
    pub digest: String,
    /// Finished orders an hour.
    pub orders_per_hour: f64,
    /// Orders that were finished in the whole run, the warm-up included.
    pub finished_orders: u64,
    /// Orders that waited for a long time.
    pub unserved: u64,
    /// Times in which robots with orders made no progress. The figures of such a run aren't those
    /// of traffic.
    pub stalls: Vec<Stall>,
    /// The first finding of the validator of each kind.
    pub examples: BTreeMap<String, Example>,
}

impl PointAnswer {
    /// The finished orders of a run on average, its warm-up included.
    pub fn orders_of_run(&self) -> f64 {
        self.finished_orders as f64 / self.runs.len() as f64
    }

    /// Whether robots that were busy all the time finished less than some orders each, too few for
    /// a throughput.
    pub fn has_too_few_orders(&self) -> bool {
        let is_busy = self.utilisation.is_some_and(|part| part.mean > BUSY);
        is_busy && self.orders_of_run() < LEAST_ORDERS * f64::from(self.robots)
    }

    /// The runs in which robots made no progress.
    pub fn stalled(&self) -> impl Iterator<Item = &RunAnswer> {
        self.runs.iter().filter(|run| !run.stalls.is_empty())
    }

    pub(super) fn new(targets: &[Target], point: &Point, graph: &RouteGraph) -> Self {
        let overdue = point.runs.iter().filter(|run| run.end == RunEnd::Overdue);
        let runs = point.seeds.iter().zip(&point.runs).map(|(seed, run)| RunAnswer {
            seed: *seed,
            digest: run.digest.clone(),
            orders_per_hour: run.orders_per_hour,
            finished_orders: run.finished_orders,
            unserved: run.unserved,
            stalls: run.stalls.clone(),
            examples: run.examples.clone(),
        });
        Self {
            robots: point.robots,
            runs: runs.collect(),
            targets: targets.iter().map(|target| TargetAnswer::new(target, point)).collect(),
            overdue_runs: overdue.count(),
            orders_per_hour: point.counted_throughput(),
            stops_per_hour: point.interval(|run| Some(run.stops_per_hour)),
            service_mean_secs: point.service(|service| service.mean_secs),
            service_p50_secs: point.service(|service| service.p50_secs),
            service_p90_secs: point.service(|service| service.p90_secs),
            service_p95_secs: point.service(|service| service.p95_secs),
            service_p99_secs: point.service(|service| service.p99_secs),
            service_longest_secs: point.service(|service| service.longest_secs),
            late: point.interval(|run| run.late),
            utilisation: point.interval(|run| Some(run.utilisation)),
            waiting: point.interval(|run| Some(run.waiting)),
            empty: point.interval(|run| run.empty),
            order_time: order_time(point),
            robot_time: robot_time(point),
            warm_up_secs: point.interval(|run| Some(run.warm_up_secs)),
            contacts: point.runs.iter().map(|run| run.contacts).sum(),
            unserved: point.runs.iter().map(|run| run.unserved).sum(),
            other_findings: sums(point.runs.iter().map(|run| &run.other_findings)),
            finished_orders: point.runs.iter().map(|run| run.finished_orders).sum(),
            failed_orders: point.runs.iter().map(|run| run.failed_orders).sum(),
            open_orders: point.interval(|run| Some(run.open_orders as f64)),
            stuck_orders: StuckOrders::of(point),
            backlog: point.trend(),
            storages: storages(point, graph),
        }
    }
}

/// Returns the storages for which orders wait at the end of some runs.
fn storages(point: &Point, graph: &RouteGraph) -> Vec<StorageLack> {
    let mut by_lack: BTreeMap<Lack, (u64, u64)> = BTreeMap::new();
    for Unplaced { lack, orders, .. } in point.runs.iter().flat_map(|run| &run.unplaced) {
        let (runs, sum) = by_lack.entry(*lack).or_default();
        *runs += 1;
        *sum += orders;
    }
    let storages = by_lack.into_iter().map(|(Lack { node, is_full }, (runs, sum))| StorageLack {
        name: station(graph, node),
        is_full,
        runs,
        orders: sum as f64 / runs as f64,
    });
    storages.collect()
}
