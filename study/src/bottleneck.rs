//! Bottlenecks: the places that robots wait for, and the effect of relieving them.

use std::collections::BTreeMap;

use regatta_layout::{EdgeChange, NodeIndex, RouteGraph};
use serde::Serialize;

use crate::answer::Difference;
use crate::outcome::EdgeOutcome;
use crate::plan::Variant;

/// The number of bottlenecks in an answer.
const LISTED: usize = 10;
/// The factor of the speed on edges whose speed is raised.
const FASTER: f64 = 1.5;
/// The room beside a robot on a doubled edge, in metres, so that robots on both edges don't touch
/// in their middles.
const CLEARANCE: f64 = 0.6;

/// A node that robots wait for, wherever they stand.
#[derive(Clone, Debug, Serialize)]
pub struct Bottleneck {
    /// The node's id.
    pub node: u32,
    /// Its name, if it has one.
    pub name: Option<String>,
    /// Metres east and north.
    pub position: [f64; 2],
    /// The edges that they, or the robots before them, are kept out of, by id: those that end at
    /// the node, the worst first.
    pub edges: Vec<u32>,
    /// Robot hours that it costs in an hour.
    pub robots_waiting: f64,
    /// The part of all waiting, from 0 to 1.
    pub share: f64,
    /// The change that may relieve it.
    pub remedy: Option<Remedy>,
    /// The effect of the remedy, if it was tried.
    pub relief: Option<Relief>,
    /// The failure of a run with the remedy.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub failure: Option<String>,
}

/// A change of the layout that may relieve a bottleneck.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Remedy {
    /// The speed limits of these edges are raised by half.
    Faster(Vec<u32>),
    /// There is a second edge beside this one.
    Second(u32),
}

/// The effect of a remedy.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Relief {
    /// The difference at the knee.
    pub difference: Difference,
}

/// Returns the places that robots wait for the most. `edges` are the figures of runs of `secs`
/// simulated seconds, in which `waiting_robots` robots waited on average, for a place or for none.
pub fn bottlenecks(
    variant: &Variant,
    edges: &[EdgeOutcome],
    waiting_robots: f64,
    secs: u64,
) -> Vec<Bottleneck> {
    let graph = &variant.graph;
    let for_places: f64 = edges.iter().map(|edge| edge.caused_secs).sum();
    let total = for_places.max(waiting_robots * secs as f64);
    let mut by_node: BTreeMap<NodeIndex, Vec<EdgeOutcome>> = BTreeMap::new();
    for edge in edges.iter().filter(|edge| edge.caused_secs > 0.0) {
        if let Some(index) = graph.edge_by_id(edge.edge) {
            by_node.entry(graph.edge(index).destination).or_default().push(*edge);
        }
    }
    let mut found: Vec<Bottleneck> = by_node
        .into_iter()
        .map(|(node, mut waited)| {
            waited.sort_by(|a, b| b.caused_secs.total_cmp(&a.caused_secs));
            let sum: f64 = waited.iter().map(|edge| edge.caused_secs).sum();
            let place = graph.node(node);
            Bottleneck {
                node: place.id,
                name: place.name().map(str::to_owned),
                position: [place.position.x, place.position.y],
                edges: waited.iter().map(|edge| edge.edge).collect(),
                robots_waiting: sum / secs as f64,
                share: sum / total,
                remedy: remedy(variant, node, &waited, edges),
                relief: None,
                failure: None,
            }
        })
        .collect();
    found.sort_by(|a, b| b.robots_waiting.total_cmp(&a.robots_waiting));
    found.truncate(LISTED);
    found
}

/// Returns a remedy for a node: faster edges, if robots can drive faster than these allow, or else
/// a second edge beside the one that robots are kept out of the most, or else beside the one by
/// which most robots leave the node.
fn remedy(
    variant: &Variant,
    node: NodeIndex,
    kept_out: &[EdgeOutcome],
    edges: &[EdgeOutcome],
) -> Option<Remedy> {
    let graph: &RouteGraph = &variant.graph;
    let max_speed = variant.max_speed();
    let at_node =
        graph.edges().iter().filter(|edge| edge.origin == node || edge.destination == node);
    let slow: Vec<u32> =
        at_node.filter(|edge| edge.speed < 0.95 * max_speed).map(|edge| edge.id).collect();
    if !slow.is_empty() {
        return Some(Remedy::Faster(slow));
    }
    // An edge of several curves can't be doubled.
    for edge in kept_out {
        let edge = graph.edge(graph.edge_by_id(edge.edge)?);
        if edge.path.single().is_some() {
            return Some(Remedy::Second(edge.id));
        }
    }
    let leaving =
        graph.edges().iter().filter(|edge| edge.origin == node && edge.path.single().is_some());
    let busiest = leaving.max_by(|a, b| entered(edges, a.id).total_cmp(&entered(edges, b.id)))?;
    Some(Remedy::Second(busiest.id))
}

/// Returns the number of robots that entered an edge, an hour.
fn entered(edges: &[EdgeOutcome], id: u32) -> f64 {
    edges.iter().find(|edge| edge.edge == id).map_or(0.0, |edge| edge.entered_per_hour)
}

impl Bottleneck {
    /// Returns a variant in which it is relieved; `None` if there is no remedy.
    pub fn relieved(&self, variant: &Variant) -> Option<Variant> {
        let mut relieved = variant.clone();
        let changed = match self.remedy.as_ref()? {
            Remedy::Faster(edges) => relieved.change(edges, EdgeChange::Speed(FASTER)),
            Remedy::Second(edge) => {
                relieved.change(&[*edge], EdgeChange::Double(variant.max_width() + CLEARANCE))
            }
        };
        relieved.name = format!("relief of node {}", self.node);
        changed.is_ok().then_some(relieved)
    }

    /// Returns the place in words.
    pub fn place(&self) -> String {
        self.name.clone().unwrap_or_else(|| format!("node {}", self.node))
    }
}
