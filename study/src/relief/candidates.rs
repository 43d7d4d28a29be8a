//! The candidates for reliefs, by where the time of orders and robots goes at the answer.

use std::collections::BTreeMap;

use regatta_layout::{NodeIndex, RouteGraph};

use super::{Candidate, FASTER_REPAIR, Remedy, aisle, slow, stops, track};
use crate::answer::node_name;
use crate::bottleneck::{Bottleneck, remedy};
use crate::outcome::{CHARGING, EdgeOutcome, Outcome, ROBOT_PARTS};
use crate::plan::Variant;
use crate::sweep::Point;

/// The part of the robots from which on a candidate is worth a try.
const LEAST_PART: f64 = 0.005;

/// Robots that wait at a stop, on average.
#[derive(Clone, Copy, Debug, Default)]
pub struct Wait {
    /// Robots at the stop that wait to be served, and in the queue before it.
    pub robots: f64,
    /// Those in the queue.
    pub queued: f64,
}

/// A variant with a number of robots, and where the time goes there.
pub struct Site<'a> {
    /// The variant.
    pub variant: &'a Variant,
    /// The number of robots.
    pub robots: u32,
    /// The seconds of a run, the warm-up included.
    pub secs: f64,
    /// Finished orders an hour.
    pub orders_per_hour: f64,
    /// The mean number of robots that charge, or drive to a charger.
    pub charging: f64,
    /// The mean number of robots that are idle or parked.
    pub idle: f64,
    /// The mean number of robots that are out of service.
    pub down: f64,
    /// The mean number of orders without a robot.
    pub unassigned: f64,
    /// By stop: robots that wait there.
    pub stops: BTreeMap<u32, Wait>,
    /// By first and last stop: orders.
    pub relations: BTreeMap<[u32; 2], f64>,
    /// The places that robots wait for.
    pub bottlenecks: &'a [Bottleneck],
    /// The figures of edges with traffic.
    pub(super) edges: BTreeMap<u32, EdgeOutcome>,
}

impl<'a> Site<'a> {
    /// Adds up the time of the runs of a point.
    pub fn new(
        variant: &'a Variant,
        point: &Point,
        edges: &[EdgeOutcome],
        outcomes: &[Outcome],
        bottlenecks: &'a [Bottleneck],
    ) -> Self {
        let runs = outcomes.len().max(1) as f64;
        let secs = outcomes.iter().map(|outcome| outcome.figures.secs).sum::<f64>() / runs;
        let mean = |name: &str| {
            let part = ROBOT_PARTS.iter().position(|part| *part == name)?;
            point.interval(|run| Some(run.robot_time?[part])).map(|share| share.mean)
        };
        let robots = |name: &str| mean(name).unwrap_or(0.0) * f64::from(point.robots);
        let orders_per_hour = point.throughput().map_or(0.0, |orders| orders.mean);
        let waits = point.interval(|run| Some(run.order_time?[0]));
        Self {
            variant,
            robots: point.robots,
            secs: secs.max(1.0),
            orders_per_hour,
            charging: robots(CHARGING),
            idle: robots("idle") + robots("parked"),
            down: robots("out of service"),
            unassigned: waits.map_or(0.0, |wait| wait.mean * orders_per_hour / 3600.0),
            stops: stops_of(outcomes),
            relations: relations_of(outcomes),
            bottlenecks,
            edges: edges.iter().map(|edge| (edge.edge, *edge)).collect(),
        }
    }

    /// Returns the figures of an edge.
    pub fn edge(&self, id: u32) -> EdgeOutcome {
        self.edges.get(&id).copied().unwrap_or(EdgeOutcome::new(id))
    }

    /// Returns the mean number of robots that are kept out of the edges to a node.
    pub fn kept_out(&self, node: NodeIndex) -> f64 {
        let edges = self.variant.graph.edges().iter().filter(|edge| edge.destination == node);
        edges.map(|edge| self.edge(edge.id).caused_secs).sum::<f64>() / self.secs
    }

    /// Returns the name of a node, or that of its station.
    pub fn name(&self, node: NodeIndex) -> String {
        let graph: &RouteGraph = &self.variant.graph;
        let (name, id) = (node_name(graph, node), graph.node(node).id);
        if name == id.to_string() { format!("node {id}") } else { name }
    }
}

fn stops_of(outcomes: &[Outcome]) -> BTreeMap<u32, Wait> {
    let mut stops: BTreeMap<u32, Wait> = BTreeMap::new();
    for outcome in outcomes {
        let figures = &outcome.figures;
        let part = figures.tick_secs / (figures.secs.max(1.0) * outcomes.len() as f64);
        for stop in &figures.stops {
            let wait = stops.entry(stop.node).or_default();
            wait.robots += (stop.station + stop.queue) as f64 * part;
            wait.queued += stop.queue as f64 * part;
        }
    }
    stops
}

fn relations_of(outcomes: &[Outcome]) -> BTreeMap<[u32; 2], f64> {
    let mut relations = BTreeMap::new();
    for order in outcomes.iter().flat_map(|outcome| &outcome.figures.finished) {
        *relations.entry(order.ends).or_insert(0.0) += 1.0;
    }
    relations
}

/// Returns the candidates in the order in which they are tried: the best of each kind, by the
/// robots whose time they are about; then the second of each kind, and so on.
pub fn candidates(site: &Site<'_>) -> Vec<Candidate> {
    let mut kinds = vec![aisle::candidates(site), slow::slow_edges(site), roads(site)];
    kinds.push(stops::charger(site).into_iter().collect());
    kinds.push(slow::faster_robots(site).into_iter().collect());
    kinds.push(vec![Candidate {
        remedy: Remedy::Repair,
        words: "robots that are repaired in half the time".to_owned(),
        about: "out of service",
        robots: site.down * FASTER_REPAIR,
    }]);
    kinds.extend(by_kind(stops::stations(site)));
    kinds.extend(by_kind(track::candidates(site)));
    let least = LEAST_PART * f64::from(site.robots);
    for kind in &mut kinds {
        kind.retain(|candidate| candidate.robots >= least);
        kind.sort_by(|a, b| b.robots.total_cmp(&a.robots));
    }
    let mut candidates = Vec::new();
    while kinds.iter().any(|kind| !kind.is_empty()) {
        let firsts = kinds.iter_mut().filter(|kind| !kind.is_empty());
        let mut round: Vec<Candidate> = firsts.map(|kind| kind.remove(0)).collect();
        round.sort_by(|a, b| b.robots.total_cmp(&a.robots));
        candidates.extend(round);
    }
    candidates
}

/// Returns candidates by the kind of their remedy.
fn by_kind(candidates: Vec<Candidate>) -> Vec<Vec<Candidate>> {
    let mut kinds: Vec<Vec<Candidate>> = Vec::new();
    for candidate in candidates {
        let is_of = |kind: &&mut Vec<Candidate>| {
            let first = kind.first().map(|first| std::mem::discriminant(&first.remedy));
            first == Some(std::mem::discriminant(&candidate.remedy))
        };
        match kinds.iter_mut().find(is_of) {
            Some(kind) => kind.push(candidate),
            None => kinds.push(vec![candidate]),
        }
    }
    kinds
}

/// Returns other roads at the places that robots wait for: at stops, a station has other remedies.
fn roads(site: &Site<'_>) -> Vec<Candidate> {
    let mut candidates = Vec::new();
    for bottleneck in site.bottlenecks {
        if site.stops.contains_key(&bottleneck.node) {
            continue;
        }
        let Some(remedy) = remedy(site.variant, bottleneck, &site.edges) else { continue };
        let words = match &remedy {
            Remedy::Faster(edges) => format!("{}: speed × 1.5", slow::edges_in_words(edges)),
            Remedy::Second(edge) => format!("a second edge beside {edge}"),
            _ => continue,
        };
        let words = format!("{words}, at {}", bottleneck.place());
        let about = "waiting";
        candidates.push(Candidate { remedy, words, about, robots: bottleneck.robots_waiting });
    }
    candidates
}
