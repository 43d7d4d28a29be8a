//! The answer of a study: curves, their knees, bottlenecks, reliefs, and comparisons.

mod comparison;
mod cost;
mod least;
mod no_room;
mod peaks;
mod point;
mod time;

use std::collections::{BTreeMap, BTreeSet};

use serde::Serialize;

use crate::bottleneck::Bottleneck;
use crate::certificate::certificate;
use crate::job::{Ending, Manager, layout_name};
use crate::outcome::EdgeOutcome;
use crate::plan::{FleetType, Input, Plan, Precision, Prices, Target, Variant};
use crate::relief::Reliefs;
use crate::statistics::Interval;
use crate::sweep::{Curve, Known};
use crate::workers::RunFailure;

pub use comparison::{Comparison, Difference};
pub use cost::{Cheapest, CostAnswer, CostFigure, Missing, PointCost};
pub use least::{Binding, LeastAnswer, TargetAnswer};
pub use no_room::NoRoom;
pub use peaks::{BacklogAnswer, HourAnswer, MeanHour, PeaksAnswer, Spread};
pub use point::{BUSY, PointAnswer, RunAnswer, StorageLack, StuckOrders};
pub(crate) use time::node_name;
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
    /// The traffic that the roads of the first variant allow its robots, in sentences. Of several
    /// robot types, a sentence names the one that it is about, unless it is about all.
    pub certificate: Vec<String>,
    /// The files that the study was made of.
    pub inputs: Vec<Input>,
    /// The prices, if the user gave any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub prices: Option<Prices>,
    /// The variants. The others are compared with the first.
    pub variants: Vec<VariantAnswer>,
    /// The comparisons of the other variants with the first one.
    pub comparisons: Vec<Comparison>,
    /// The first variant with the number of robots of the answer.
    #[serde(flatten)]
    pub chosen: Chosen,
}

/// The first variant with the number of robots of the answer, in detail; nothing without an answer.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Chosen {
    /// The places that robots wait for, the worst first.
    pub bottlenecks: Vec<Bottleneck>,
    /// The changes that were tried to relieve it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reliefs: Option<Reliefs>,
    /// The edges: means over the runs.
    pub edges: Vec<EdgeOutcome>,
    /// The time of the orders.
    pub time: TimeAnswer,
    /// The hours of a day, and its backlog.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub peaks: Option<PeaksAnswer>,
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
    /// The ids of those of these nodes where orders could have stops.
    #[serde(skip)]
    pub left_out_stops: BTreeSet<u32>,
    /// Whether the load was made for the layout: each robot has an order at any time.
    pub is_load_made_up: bool,
    /// Whether orders are always open, so that the load is never the limit.
    pub is_load_endless: bool,
    /// Whether Regatta's fleet manager steers the robots.
    pub is_managed_by_regatta: bool,
    /// Whether it is the bound: robots drive through each other, and no validator judges them.
    pub is_bound: bool,
    /// The reason why orders have other stops than the layout's stations suggest.
    pub other_stops: Option<String>,
    /// The assumptions of reading the layout, in words: on speeds, edges, and who drives on them.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub assumptions: Vec<String>,
    /// The robot types in use, with their numbers at the answer.
    pub robot_types: Vec<FleetType>,
    /// Edges of the layout.
    pub edges: usize,
    /// Nodes of the layout.
    pub nodes: usize,
    /// The file of the layout in the study's folder `files`: the hash of its content.
    pub layout_file: String,
    /// The points of the curve, by ascending robots.
    pub points: Vec<PointAnswer>,
    /// The knee.
    pub knee: Option<KneeAnswer>,
    /// The least number of robots that meets the targets.
    pub least: Option<LeastAnswer>,
    /// The cost of its fleets, if there are prices.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cost: Option<CostAnswer>,
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

impl Answer {
    /// Combines the results. `known` has the runs of all variants, in their order, and `places`
    /// the place that robots wait for the most in the runs that miss a target.
    pub fn new(
        plan: &Plan,
        curves: &[Curve],
        known: &[Known],
        places: &[Option<String>],
        chosen: Chosen,
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
            answer.cost = plan.prices.as_ref().map(|prices| {
                CostAnswer::new(prices, variant, targets, curve, answer.least.as_ref())
            });
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
            inputs: plan.inputs.clone(),
            prices: plan.prices.clone(),
            variants,
            comparisons,
            chosen,
        }
    }

    /// Whether a run failed, so that a part of the answer is missing or less precise. Robots that
    /// don't fit on the layout are an answer.
    pub fn has_failures(&self) -> bool {
        self.variants.iter().any(|variant| !variant.failed.is_empty())
            || self.chosen.reliefs.iter().any(Reliefs::has_failures)
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
                // It is told within sentences, and may be the last line of another program.
                failed.entry(*robots).or_insert(reason.trim_end_matches('.'));
            }
        }
        let points: Vec<PointAnswer> = curve
            .points
            .iter()
            .map(|point| PointAnswer::new(targets, point, &variant.graph))
            .collect();
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
            left_out_stops: variant.left_out_stops.clone(),
            is_load_made_up: variant.is_load_made_up(),
            is_load_endless: variant.is_load_endless(),
            is_managed_by_regatta: matches!(variant.manager, Manager::BuiltIn(_)),
            is_bound: matches!(variant.manager, Manager::Bound(_)),
            other_stops: variant.other_stops.clone(),
            assumptions: variant.assumptions.clone(),
            robot_types: Vec::new(),
            edges: variant.graph.edges().len(),
            nodes: variant.graph.nodes().len(),
            layout_file: layout_name(&variant.layout_text()),
            contacts: points.iter().map(|point| point.contacts).sum(),
            unserved: points.iter().map(|point| point.unserved).sum(),
            other_findings: sums(points.iter().map(|point| &point.other_findings)),
            points,
            knee,
            least: None,
            cost: None,
            failed: failed
                .into_iter()
                .map(|(robots, reason)| (robots, reason.to_owned()))
                .collect(),
            no_room: NoRoom::of(known),
        }
    }
}

/// Adds numbers by kind.
fn sums<'a>(parts: impl Iterator<Item = &'a BTreeMap<String, u64>>) -> BTreeMap<String, u64> {
    let mut sums = BTreeMap::new();
    for (kind, count) in parts.flatten() {
        *sums.entry(kind.clone()).or_default() += count;
    }
    sums
}
