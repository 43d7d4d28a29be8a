//! The answer of a study: curves, the knee, bottlenecks and what their relief brings, and
//! comparisons.

mod bottleneck;
mod comparison;

use serde::Serialize;

pub use bottleneck::{Bottleneck, Relief, Remedy, bottlenecks};
pub use comparison::{Comparison, Difference};

use crate::outcome::{EdgeOutcome, Measured};
use crate::plan::{Plan, Precision, Variant};
use crate::statistics::Interval;
use crate::sweep::{Curve, Known, Point};

/// The answer of a study. As JSON it is the same, byte by byte, for the same study on any machine.
#[derive(Clone, Debug, Serialize)]
pub struct Answer {
    /// What was studied.
    pub title: String,
    /// The version of the program.
    pub program: String,
    /// How it was studied.
    pub method: Method,
    /// The variants. The first is what the others are compared with.
    pub variants: Vec<VariantAnswer>,
    /// The other variants against the first one.
    pub comparisons: Vec<Comparison>,
    /// What the first variant's robots wait for at its knee, the worst first.
    pub bottlenecks: Vec<Bottleneck>,
    /// The edges of the first variant at its knee: means over the runs there.
    pub edges: Vec<EdgeOutcome>,
}

/// How a study was made.
#[derive(Clone, Debug, Serialize)]
pub struct Method {
    /// Simulated seconds of a run, the warm-up included.
    pub secs: u64,
    /// Ticks and frames per simulated second.
    pub rate_hz: u32,
    /// The numbers of robots that were asked for.
    pub robots: String,
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
    /// Where orders go.
    pub load: String,
    /// Edges and nodes of the layout.
    pub edges: usize,
    /// Nodes of the layout.
    pub nodes: usize,
    /// The points of the curve, by ascending robots.
    pub points: Vec<PointAnswer>,
    /// The knee.
    pub knee: Option<KneeAnswer>,
    /// Numbers of robots whose runs failed, and why.
    pub failed: Vec<(u32, String)>,
    /// Contacts in all runs: must be 0.
    pub contacts: u64,
    /// Other findings of the validator in all runs.
    pub other_findings: u64,
}

/// The knee of a curve.
#[derive(Clone, Debug, Serialize)]
pub struct KneeAnswer {
    /// The number of robots.
    pub robots: u32,
    /// Orders an hour.
    pub orders_per_hour: Interval,
    /// Up to so many robots, each more brings at least half of what one brings alone.
    pub half: u32,
    /// Whether it is the largest number of robots that was tried: more may bring more.
    pub is_open: bool,
}

/// A point of a curve: means over its runs, with intervals.
#[derive(Clone, Debug, Serialize)]
pub struct PointAnswer {
    /// The number of robots.
    pub robots: u32,
    /// The seeds of its runs, with the digests of all frames.
    pub runs: Vec<RunAnswer>,
    /// Finished orders an hour.
    pub orders_per_hour: Option<Interval>,
    /// Finished stops an hour.
    pub stops_per_hour: Option<Interval>,
    /// The mean time from an order's creation to its end, in seconds.
    pub service_mean_secs: Option<Interval>,
    /// The median of it.
    pub service_p50_secs: Option<Interval>,
    /// The 99th percentile of it.
    pub service_p99_secs: Option<Interval>,
    /// The part of the robots' time with an order.
    pub utilisation: Option<Interval>,
    /// The part of the robots' time in which they wait for room.
    pub waiting: Option<Interval>,
    /// The part of the way without a load.
    pub empty: Option<Interval>,
    /// The warm-up that was cut off, in seconds: the mean.
    pub warm_up_secs: Option<Interval>,
    /// Contacts in all runs.
    pub contacts: u64,
    /// Other findings of the validator in all runs.
    pub other_findings: u64,
    /// Orders that the manager gave up, in all runs.
    pub failed_orders: u64,
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
}

impl Answer {
    /// Puts the answer together. `known` has the runs of all variants, in their order.
    pub fn new(
        plan: &Plan,
        curves: &[Curve],
        known: &[Known],
        bottlenecks: Vec<Bottleneck>,
        edges: Vec<EdgeOutcome>,
    ) -> Self {
        let Precision { least_seeds, most_seeds, interval, knee, .. } = plan.precision;
        let method = Method {
            secs: plan.secs,
            rate_hz: plan.rate_hz,
            robots: plan.robots.to_string(),
            seeds: [least_seeds, most_seeds],
            interval,
            knee,
        };
        let variants: Vec<VariantAnswer> = plan
            .variants
            .iter()
            .zip(curves)
            .map(|(variant, curve)| VariantAnswer::new(variant, curve))
            .collect();
        let others = plan.variants.iter().zip(known).skip(1);
        let comparisons = match known.first() {
            Some(base) => {
                others.map(|(variant, other)| Comparison::of(&variant.name, base, other)).collect()
            }
            None => Vec::new(),
        };
        let (title, program) = (plan.title.clone(), plan.program.clone());
        Self { title, program, method, variants, comparisons, bottlenecks, edges }
    }
}

impl VariantAnswer {
    /// Returns why there is no figure: none of the runs has succeeded.
    pub fn failure(&self) -> Option<&str> {
        let reason = self.failed.first().map(|(_, reason)| reason.as_str());
        reason.filter(|_| self.points.is_empty())
    }

    fn new(variant: &Variant, curve: &Curve) -> Self {
        let points: Vec<PointAnswer> = curve.points.iter().map(PointAnswer::new).collect();
        let knee = curve.knee.and_then(|index| {
            let point = &curve.points[index];
            Some(KneeAnswer {
                robots: point.robots,
                orders_per_hour: point.throughput()?,
                half: curve.half.map_or(point.robots, |index| curve.points[index].robots),
                is_open: curve.is_open,
            })
        });
        Self {
            name: variant.name.clone(),
            load: variant.load.clone(),
            edges: variant.graph.edges().len(),
            nodes: variant.graph.nodes().len(),
            contacts: points.iter().map(|point| point.contacts).sum(),
            other_findings: points.iter().map(|point| point.other_findings).sum(),
            points,
            knee,
            failed: curve.failed.clone(),
        }
    }
}

impl PointAnswer {
    fn new(point: &Point) -> Self {
        let runs = (1..).zip(&point.runs).map(|(seed, run)| RunAnswer {
            seed,
            digest: run.digest.clone(),
            orders_per_hour: run.orders_per_hour,
        });
        let interval = |figure: fn(&Measured) -> Option<f64>| point.interval(figure);
        Self {
            robots: point.robots,
            runs: runs.collect(),
            orders_per_hour: point.throughput(),
            stops_per_hour: interval(|run| Some(run.stops_per_hour)),
            service_mean_secs: interval(|run| run.service_mean_secs),
            service_p50_secs: interval(|run| run.service_p50_secs),
            service_p99_secs: interval(|run| run.service_p99_secs),
            utilisation: interval(|run| Some(run.utilisation)),
            waiting: interval(|run| Some(run.waiting)),
            empty: interval(|run| run.empty),
            warm_up_secs: interval(|run| Some(run.warm_up_secs)),
            contacts: point.runs.iter().map(|run| run.contacts).sum(),
            other_findings: point.runs.iter().map(|run| run.other_findings).sum(),
            failed_orders: point.runs.iter().map(|run| run.failed_orders).sum(),
        }
    }
}
