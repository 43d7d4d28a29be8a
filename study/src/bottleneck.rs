//! Bottlenecks: the places that robots wait for.

use std::collections::BTreeMap;

use regatta_layout::{EdgeIndex, NodeIndex, RouteGraph};
use serde::Serialize;

use crate::outcome::EdgeOutcome;
use crate::plan::Variant;
use crate::relief::Remedy;

/// The number of bottlenecks in an answer.
const LISTED: usize = 10;
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
    /// The doors and lifts that all of these edges lead through: robots wait for them, too.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub facilities: Vec<String>,
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
            let facilities = facilities(graph, &waited);
            Bottleneck {
                node: place.id,
                name: place.name().map(str::to_owned),
                position: [place.position.x, place.position.y],
                edges: waited.iter().map(|edge| edge.edge).collect(),
                robots_waiting: sum / secs as f64,
                share: sum / total,
                facilities,
            }
        })
        .collect();
    found.sort_by(|a, b| b.robots_waiting.total_cmp(&a.robots_waiting));
    found.truncate(LISTED);
    found
}

/// Returns the doors and lifts that lie on edges out of which robots are kept; none if one of the
/// edges has neither.
fn facilities(graph: &RouteGraph, kept_out: &[EdgeOutcome]) -> Vec<String> {
    let mut found = Vec::new();
    for edge in kept_out {
        let Some(index) = graph.edge_by_id(edge.edge) else { return Vec::new() };
        let names = on_edge(graph, index);
        if names.is_empty() {
            return Vec::new();
        }
        found.extend(names);
    }
    found.sort();
    found.dedup();
    found
}

/// Returns the doors and the lift of an edge: the lift that it enters or leaves.
fn on_edge(graph: &RouteGraph, index: EdgeIndex) -> Vec<String> {
    let edge = graph.edge(index);
    let doors = graph.doors().iter().filter(|door| door.edges.contains(&index));
    let mut names: Vec<String> = doors.map(|door| format!("door `{}`", door.name)).collect();
    for lift in graph.lifts() {
        let mut nodes = lift.levels.iter().flat_map(|level| &level.nodes);
        if nodes.any(|node| [edge.origin, edge.destination].contains(node)) {
            names.push(format!("lift `{}`", lift.name));
        }
    }
    names
}

/// Whether an edge is a ride of a lift, whose time is that of the cabin.
fn is_ride(graph: &RouteGraph, index: EdgeIndex) -> bool {
    graph.lifts().iter().any(|lift| lift.rides.contains(&index))
}

/// Returns a remedy for the roads at a bottleneck: faster edges, if robots can drive faster than
/// these allow, or else a second edge beside the one that robots are kept out of the most, or else
/// beside the one by which most robots leave the node. `None` behind a door or a lift: faster edges
/// don't open a door, nor call a cabin.
pub(crate) fn remedy(
    variant: &Variant,
    bottleneck: &Bottleneck,
    edges: &BTreeMap<u32, EdgeOutcome>,
) -> Option<Remedy> {
    let graph: &RouteGraph = &variant.graph;
    let node = graph.node_by_id(bottleneck.node)?;
    if !bottleneck.facilities.is_empty() {
        return None;
    }
    let max_speed = variant.max_speed();
    let mut slow = Vec::new();
    for (index, edge) in (0..).map(EdgeIndex).zip(graph.edges()) {
        let is_at_node = edge.origin == node || edge.destination == node;
        if is_at_node && edge.speed < 0.95 * max_speed && !is_ride(graph, index) {
            slow.push(edge.id);
        }
    }
    if !slow.is_empty() {
        return Some(Remedy::Faster(slow));
    }
    // An edge of several curves can't be doubled.
    for id in &bottleneck.edges {
        let edge = graph.edge(graph.edge_by_id(*id)?);
        if edge.path.single().is_some() {
            return Some(Remedy::Second(edge.id));
        }
    }
    let entered = |id: u32| edges.get(&id).map_or(0.0, |edge| edge.entered_per_hour);
    let leaving =
        graph.edges().iter().filter(|edge| edge.origin == node && edge.path.single().is_some());
    let busiest = leaving.max_by(|a, b| entered(a.id).total_cmp(&entered(b.id)))?;
    Some(Remedy::Second(busiest.id))
}

impl Bottleneck {
    /// Returns the place in words, with the doors and lifts there.
    pub fn place(&self) -> String {
        let name = self.name.clone().unwrap_or_else(|| format!("node {}", self.node));
        match self.facilities.is_empty() {
            true => name,
            false => format!("{name} (behind {})", self.facilities.join(", ")),
        }
    }
}

#[cfg(test)]
mod tests {
    use regatta_layout::{ReadOptions, parse};

    use super::*;

    #[test]
    fn a_place_behind_a_door_or_a_lift_names_them() {
        let text = include_str!("../../graphs/two-levels.yaml");
        let (graph, _) = parse(text, "plant.yaml", &ReadOptions::default()).expect("a layout");
        let kept_out = |ids: &[u32]| {
            let edges = ids.iter().map(|id| EdgeOutcome::new(*id));
            facilities(&graph, &edges.collect::<Vec<_>>())
        };
        assert_eq!(kept_out(&[7]), ["door `hall`"]);
        assert_eq!(kept_out(&[7, 20]), ["door `hall`", "door `store`"]);
        assert!(kept_out(&[7, 1]).is_empty(), "robots wait elsewhere, too");
        let into_cabin = graph.edges().iter().find(|edge| graph.node(edge.destination).id == 11);
        assert_eq!(kept_out(&[into_cabin.expect("an edge").id]), ["lift `lift`"]);
    }
}
