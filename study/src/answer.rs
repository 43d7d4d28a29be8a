//! The answer of a study: curves, their knees, bottlenecks with their reliefs, and comparisons.

mod comparison;
mod least;
mod no_room;
mod time;

use std::collections::BTreeMap;

use serde::Serialize;

use crate::bottleneck::Bottleneck;
use crate::certificate::certificate;
use crate::job::{Ending, Manager};
use crate::outcome::{EdgeOutcome, Example, RunEnd, Stall};
use crate::plan::{FleetType, Plan, Precision, Target, Variant};
use crate::statistics::Interval;
use crate::sweep::{Curve, Known, Point};
use crate::workers::RunFailure;

pub use comparison::{Comparison, Difference};
pub use least::{Binding, LeastAnswer, TargetAnswer};
pub use no_room::NoRoom;
pub use time::{GroupTime, PartAnswer, TimeAnswer};

/// The answer of a study. As JSON it is the same, byte by byte, for the same study on any machine.
#[derive(Clone, Debug, Serialize)]
pub struct Answer {
    /// The name of the plant.
    pub title: String,
    /// The version of the program.
    pub program: String,
    /// The method of the study.
    pub method: Method,
    /// The traffic that the roads of the first variant allow its robots, in sentences.
    pub certificate: Vec<String>,
    /// The variants. The others are compared with the first.
    pub variants: Vec<VariantAnswer>,
    /// The comparisons of the other variants with the first one.
    pub comparisons: Vec<Comparison>,
    /// The places that the first variant's robots wait for at its knee, the worst first.
    pub bottlenecks: Vec<Bottleneck>,
    /// The edges of the first variant at its knee: means over the runs there.
    pub edges: Vec<EdgeOutcome>,
    /// The time of the first variant's orders with the number of robots of the answer.
    pub time: TimeAnswer,
}

/// The method of a study.
#[derive(Clone, Debug, Serialize)]
pub struct Method {
    /// Simulated seconds of a run, the warm-up included; of a day, at most.
    pub secs: u64,
    /// Whether a run is a day, which ends with its last order.
    pub is_day: bool,
    /// Ticks and frames per simulated second.
    pub rate_hz: u32,
    /// The numbers of robots that were asked for.
    pub robots: String,
    /// The targets that a fleet must meet.
    pub targets: Vec<String>,
    /// The least and the largest number of seeds.
    pub seeds: [u64; 2],
    /// The wanted half of the 95 % interval at the knee, as a part of the throughput.
    pub interval: f64,
    /// The part of a lone robot's throughput that one more robot brings at the knee.
    pub knee: f64,
}

/// The answer of a variant.
#[derive(Clone, Debug, Serialize)]
pub struct VariantAnswer {
    /// The variant's name; empty if there are no others.
    pub name: String,
    /// The stops of the orders, in words.
    pub load: String,
    /// The stations and nodes that are cut off from the other roads, in words: they take no part.
    pub left_out: Vec<String>,
    /// Whether the load was made for the layout: each robot has an order at any time.
    pub is_load_made_up: bool,
    /// Whether orders are always open, so that the load is never the limit.
    pub is_load_endless: bool,
    /// Whether Regatta's fleet manager steers the robots.
    pub is_managed_by_regatta: bool,
    /// The reason why orders have other stops than the layout's stations suggest.
    pub other_stops: Option<String>,
    /// The robot types in use, with their numbers at the answer.
    pub robot_types: Vec<FleetType>,
    /// Edges of the layout.
    pub edges: usize,
    /// Nodes of the layout.
    pub nodes: usize,
    /// The points of the curve, by ascending robots.
    pub points: Vec<PointAnswer>,
    /// The knee.
    pub knee: Option<KneeAnswer>,
    /// The least number of robots that meets the targets.
    pub least: Option<LeastAnswer>,
    /// Numbers of robots of which a run failed, with the reasons.
    pub failed: Vec<(u32, String)>,
    /// Numbers of robots that don't fit on the layout.
    pub no_room: Vec<NoRoom>,
    /// Contacts in all runs; 0 unless the manager is wrong.
    pub contacts: u64,
    /// Orders that waited for a long time, in all runs.
    pub unserved: u64,
    /// Other findings of the validator in all runs, by kind.
    pub other_findings: BTreeMap<String, u64>,
}

/// The knee of a curve.
#[derive(Clone, Debug, Serialize)]
pub struct KneeAnswer {
    /// The number of robots.
    pub robots: u32,
    /// Orders an hour.
    pub orders_per_hour: Interval,
    /// The number of robots up to which each additional one brings at least half of what one
    /// brings alone.
    pub half: u32,
    /// The number of robots up to which each additional one brings at least 90 % of what one brings
    /// alone.
    pub most_of: u32,
    /// The number of robots that carries the most of those that were tried.
    pub most: u32,
    /// Whether it is the largest number of robots that was tried, so that more may bring more.
    pub is_open: bool,
    /// The least number of robots, above that of the knee, that stalled in a run.
    pub stalls_from: Option<u32>,
}

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
    /// The median of it.
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
    /// Runs of a day that weren't over at their limit.
    pub overdue_runs: usize,
}

/// Adds numbers by kind.
fn sums<'a>(parts: impl Iterator<Item = &'a BTreeMap<String, u64>>) -> BTreeMap<String, u64> {
    let mut sums = BTreeMap::new();
    for (kind, count) in parts.flatten() {
        *sums.entry(kind.clone()).or_default() += count;
    }
    sums
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

impl Answer {
    /// Combines the results. `known` has the runs of all variants, in their order, and `places`
    /// the place that robots wait for the most in the runs that miss a target.
    pub fn new(
        plan: &Plan,
        curves: &[Curve],
        known: &[Known],
        places: &[Option<String>],
        bottlenecks: Vec<Bottleneck>,
        edges: Vec<EdgeOutcome>,
        time: TimeAnswer,
    ) -> Self {
        let Precision { least_seeds, most_seeds, interval, knee, .. } = plan.precision;
        let method = Method {
            secs: plan.time.secs,
            is_day: plan.variants.iter().any(|variant| variant.ending() == Ending::AfterOrders),
            rate_hz: plan.time.rate_hz,
            robots: plan.robots.to_string(),
            targets: plan.question.targets().iter().map(Target::to_string).collect(),
            seeds: [least_seeds, most_seeds],
            interval,
            knee,
        };
        let targets = plan.question.targets();
        let mut variants = Vec::new();
        for ((variant, curve), (known, place)) in
            plan.variants.iter().zip(curves).zip(known.iter().zip(places))
        {
            let mut answer = VariantAnswer::new(variant, targets, curve, known);
            answer.least = LeastAnswer::new(targets, curve, place.clone());
            answer.robot_types = variant.types_of(answer.robots());
            variants.push(answer);
        }
        let mut comparisons = Vec::new();
        // The least numbers of variants are compared, and no numbers that happened to be tried.
        if let Some((base, others)) = known.split_first().filter(|_| targets.is_empty()) {
            for (variant, other) in plan.variants.iter().skip(1).zip(others) {
                comparisons.push(Comparison::of(&variant.name, base, other));
            }
        }
        let (title, program) = (plan.title.clone(), plan.program.clone());
        let certificate = plan.variants.first().map(certificate).unwrap_or_default();
        Self {
            title,
            program,
            method,
            certificate,
            variants,
            comparisons,
            bottlenecks,
            edges,
            time,
        }
    }

    /// Whether a run failed, so that a part of the answer is missing or less precise. Robots that
    /// don't fit on the layout are an answer.
    pub fn has_failures(&self) -> bool {
        self.variants.iter().any(|variant| !variant.failed.is_empty())
            || self.bottlenecks.iter().any(|bottleneck| bottleneck.failure.is_some())
    }
}

impl VariantAnswer {
    /// Returns the failure of the runs if none of them has succeeded.
    pub fn failure(&self) -> Option<&str> {
        let mut no_room = self.no_room.iter().map(|no_room| &no_room.reason);
        let failed = self.failed.first().map(|(_, reason)| reason);
        failed.or_else(|| no_room.next()).map(String::as_str).filter(|_| self.points.is_empty())
    }

    /// Returns the number of robots that the answer is about, if there is one.
    pub fn robots(&self) -> Option<u32> {
        let least = self.least.as_ref().and_then(LeastAnswer::chosen);
        self.knee.as_ref().map(|knee| knee.robots).or(least)
    }

    /// Whether there is an answer to the question.
    pub fn is_known(&self) -> bool {
        let least = self.least.as_ref().and_then(|least| least.robots);
        self.knee.is_some() || least.is_some()
    }

    fn new(variant: &Variant, targets: &[Target], curve: &Curve, known: &Known) -> Self {
        let mut failed = BTreeMap::new();
        for ((robots, _), run) in known {
            if let Err(RunFailure::Failed(reason)) = run {
                failed.entry(*robots).or_insert(reason);
            }
        }
        let points: Vec<PointAnswer> =
            curve.points.iter().map(|point| PointAnswer::new(targets, point)).collect();
        let knee = curve.knee.and_then(|index| {
            let point = &curve.points[index];
            Some(KneeAnswer {
                robots: point.robots,
                orders_per_hour: point.counted_throughput()?,
                half: curve.robots(curve.half).unwrap_or(point.robots),
                most_of: curve.robots(curve.most_of).unwrap_or(point.robots),
                most: curve.robots(curve.most).unwrap_or(point.robots),
                is_open: curve.is_open,
                stalls_from: curve.points[index..]
                    .iter()
                    .find(|point| point.is_stalled())
                    .map(|point| point.robots),
            })
        });
        Self {
            name: variant.name.clone(),
            load: variant.load_in_words(),
            left_out: variant.left_out.clone(),
            is_load_made_up: variant.is_load_made_up(),
            is_load_endless: variant.is_load_endless(),
            is_managed_by_regatta: matches!(variant.manager, Manager::BuiltIn(_)),
            other_stops: variant.other_stops.clone(),
            robot_types: Vec::new(),
            edges: variant.graph.edges().len(),
            nodes: variant.graph.nodes().len(),
            contacts: points.iter().map(|point| point.contacts).sum(),
            unserved: points.iter().map(|point| point.unserved).sum(),
            other_findings: sums(points.iter().map(|point| &point.other_findings)),
            points,
            knee,
            least: None,
            failed: failed.into_iter().map(|(robots, reason)| (robots, reason.clone())).collect(),
            no_room: NoRoom::of(known),
        }
    }
}

impl PointAnswer {
    /// The runs in which robots made no progress.
    pub fn stalled(&self) -> impl Iterator<Item = &RunAnswer> {
        self.runs.iter().filter(|run| !run.stalls.is_empty())
    }

    fn new(targets: &[Target], point: &Point) -> Self {
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
            order_time: time::order_time(point),
            robot_time: time::robot_time(point),
            warm_up_secs: point.interval(|run| Some(run.warm_up_secs)),
            contacts: point.runs.iter().map(|run| run.contacts).sum(),
            unserved: point.runs.iter().map(|run| run.unserved).sum(),
            other_findings: sums(point.runs.iter().map(|run| &run.other_findings)),
            finished_orders: point.runs.iter().map(|run| run.finished_orders).sum(),
            failed_orders: point.runs.iter().map(|run| run.failed_orders).sum(),
            open_orders: point.interval(|run| Some(run.open_orders as f64)),
        }
    }
}
