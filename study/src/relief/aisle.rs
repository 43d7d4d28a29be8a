//! Aisles of one direction: the ways that get shorter if one is turned round.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};

use regatta_layout::{EdgeChange, EdgeIndex, Gear, NodeIndex, RouteGraph};

use super::slow::edges_in_words;
use super::{Candidate, Remedy, Site};

/// The largest number of stations from which ways are computed: those with the most orders.
const STATIONS: usize = 30;
/// The number of aisles that are turned round for a look at all ways: those that promise the most.
const LOOKED_AT: usize = 12;
/// The most edges of a layout whose aisles are looked at, which takes some seconds then.
const MOST_EDGES: usize = 50_000;

/// An aisle: edges of one direction, one after the other.
#[derive(Clone, Debug, PartialEq)]
pub struct Aisle {
    /// The edges.
    edges: Vec<EdgeIndex>,
    /// Its first and its last node.
    ends: [NodeIndex; 2],
}

/// The ways of robots between stations, and how often they are driven.
struct Ways {
    /// By the first node and the last one: the number of times an order.
    pairs: BTreeMap<(NodeIndex, NodeIndex), f64>,
}

/// Returns the aisles of a layout: edges that lead one way only, up to the next node where another
/// such edge begins or ends. Two-way edges, such as those of bays, part no aisle.
pub fn aisles(graph: &RouteGraph) -> Vec<Aisle> {
    let nodes = graph.nodes().len();
    let (mut into, mut out_of) = (vec![Vec::new(); nodes], vec![Vec::new(); nodes]);
    let pairs: std::collections::BTreeSet<(NodeIndex, NodeIndex)> =
        graph.edges().iter().map(|edge| (edge.origin, edge.destination)).collect();
    for (edge, index) in graph.edges().iter().zip((0..).map(EdgeIndex)) {
        let is_two_way =
            edge.reverse_speed.is_some() || pairs.contains(&(edge.destination, edge.origin));
        if !is_two_way && !graph.is_ride(index) {
            out_of[edge.origin.0 as usize].push(index);
            into[edge.destination.0 as usize].push(index);
        }
    }
    let is_inner =
        |node: NodeIndex| into[node.0 as usize].len() == 1 && out_of[node.0 as usize].len() == 1;
    let mut aisles = Vec::new();
    for &first in out_of.iter().flatten() {
        let start = graph.edge(first).origin;
        if is_inner(start) {
            continue;
        }
        let (mut edges, mut end) = (vec![first], graph.edge(first).destination);
        while is_inner(end) {
            let next = out_of[end.0 as usize][0];
            edges.push(next);
            end = graph.edge(next).destination;
        }
        aisles.push(Aisle { edges, ends: [start, end] });
    }
    aisles
}

/// Returns the aisles whose other direction makes the ways of the orders shorter.
pub fn candidates(site: &Site<'_>) -> Vec<Candidate> {
    let graph: &RouteGraph = &site.variant.graph;
    if graph.edges().len() > MOST_EDGES {
        return Vec::new();
    }
    let ways = Ways::of(site);
    let max_speed = site.variant.max_speed();
    let Some(now) = ways.secs(graph, max_speed) else { return Vec::new() };
    let mut promising: Vec<(f64, Aisle)> = aisles(graph)
        .into_iter()
        .map(|aisle| (ways.promise(graph, max_speed, &aisle), aisle))
        .filter(|(promise, _)| *promise > 0.0)
        .collect();
    promising.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut candidates = Vec::new();
    for (_, aisle) in promising.into_iter().take(LOOKED_AT) {
        let ids: Vec<u32> = aisle.edges.iter().map(|edge| graph.edge(*edge).id).collect();
        let changes: Vec<_> = ids.iter().map(|id| (*id, EdgeChange::Reverse)).collect();
        let turned = graph.with_changes(&changes).ok();
        let then = turned.and_then(|turned| ways.secs(&turned, max_speed));
        let Some(saved) = then.map(|then| now - then).filter(|saved| *saved > 0.0) else {
            continue;
        };
        let [from, to] = aisle.ends.map(|end| site.name(end));
        candidates.push(Candidate {
            words: format!(
                "the aisle from {from} to {to} the other way round ({})",
                edges_in_words(&ids)
            ),
            remedy: Remedy::Reversed(ids),
            about: "driving round about",
            robots: site.orders_per_hour / 3600.0 * saved,
        });
    }
    candidates
}

impl Ways {
    /// Returns the ways of orders, and those between an order and the next one: from each last stop
    /// to each first one, as often as orders have them.
    fn of(site: &Site<'_>) -> Self {
        let graph: &RouteGraph = &site.variant.graph;
        let mut pairs = BTreeMap::new();
        let (mut firsts, mut lasts) = (BTreeMap::new(), BTreeMap::new());
        let mut relations: Vec<(&[u32; 2], &f64)> = site.relations.iter().collect();
        relations.sort_by(|a, b| b.1.total_cmp(a.1));
        let mut orders = 0.0;
        for ([first, last], &count) in relations {
            let ends = (graph.node_by_id(*first), graph.node_by_id(*last));
            let (Some(first), Some(last)) = ends else { continue };
            let is_known = firsts.contains_key(&first) && lasts.contains_key(&last);
            if !is_known && firsts.len().max(lasts.len()) == STATIONS {
                continue;
            }
            orders += count;
            *pairs.entry((first, last)).or_insert(0.0) += count;
            *firsts.entry(first).or_insert(0.0) += count;
            *lasts.entry(last).or_insert(0.0) += count;
        }
        for (&last, ended) in &lasts {
            for (&first, begun) in &firsts {
                *pairs.entry((last, first)).or_insert(0.0) += ended * begun / orders;
            }
        }
        for count in pairs.values_mut() {
            *count /= orders;
        }
        Self { pairs }
    }

    /// Returns the seconds of the ways of an order on empty roads; `None` if there is none, or if
    /// one has no way.
    fn secs(&self, graph: &RouteGraph, max_speed: f64) -> Option<f64> {
        let mut sum = 0.0;
        let mut from: Option<(NodeIndex, Vec<f64>)> = None;
        for (&(first, last), count) in &self.pairs {
            let secs = match &from {
                Some((node, secs)) if *node == first => secs[last.0 as usize],
                _ => {
                    let secs = secs_from(graph, max_speed, first);
                    let found = secs[last.0 as usize];
                    from = Some((first, secs));
                    found
                }
            };
            sum += secs * count;
        }
        (sum.is_finite() && !self.pairs.is_empty()).then_some(sum)
    }

    /// Returns the seconds that an order would save if robots could drive through an aisle in the
    /// other direction, too.
    fn promise(&self, graph: &RouteGraph, max_speed: f64, aisle: &Aisle) -> f64 {
        let [start, end] = aisle.ends;
        let through: f64 = aisle.edges.iter().map(|edge| secs_of(graph, max_speed, *edge)).sum();
        let (mut saved, mut now) = (0.0, BTreeMap::new());
        let from_start = secs_from(graph, max_speed, start);
        for (&(first, last), count) in &self.pairs {
            let secs = now.entry(first).or_insert_with(|| secs_from(graph, max_speed, first));
            let other = secs[end.0 as usize] + through + from_start[last.0 as usize];
            saved += (secs[last.0 as usize] - other).max(0.0) * count;
        }
        saved
    }
}

fn secs_of(graph: &RouteGraph, max_speed: f64, edge: EdgeIndex) -> f64 {
    let edge = graph.edge(edge);
    edge.path.length() / edge.speed.min(max_speed)
}

/// Returns the seconds from a node to each other one on empty roads (Dijkstra); infinite without a
/// way.
fn secs_from(graph: &RouteGraph, max_speed: f64, from: NodeIndex) -> Vec<f64> {
    let mut secs = vec![f64::INFINITY; graph.nodes().len()];
    let mut open = BinaryHeap::from([(Reverse(0_u64), from)]);
    secs[from.0 as usize] = 0.0;
    while let Some((Reverse(bits), node)) = open.pop() {
        // The bits of numbers from 0 on are in the order of the numbers.
        let so_far = f64::from_bits(bits);
        if so_far > secs[node.0 as usize] {
            continue;
        }
        for leg in graph.departures(node) {
            let speed = match leg.gear {
                Gear::Forward => Some(graph.edge(leg.edge).speed),
                Gear::Reverse => graph.edge(leg.edge).reverse_speed,
            };
            let Some(speed) = speed else { continue };
            let way = graph.edge(leg.edge).path.length() / speed.min(max_speed);
            let end = graph.leg_end(*leg);
            if so_far + way < secs[end.0 as usize] {
                secs[end.0 as usize] = so_far + way;
                open.push((Reverse((so_far + way).to_bits()), end));
            }
        }
    }
    secs
}
