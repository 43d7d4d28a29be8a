//! The levels of a building: robots on different ones don't touch.

use std::collections::BTreeMap;

use crate::model::route_graph::RouteGraph;
use crate::model::tags::Tags;

/// The number of a level; 0 for none in particular, such as that of a lift.
type Level = u32;

/// The levels of a graph's nodes and edges.
#[derive(Debug)]
pub struct Levels {
    nodes: Vec<Level>,
    edges: Vec<Level>,
    /// Whether no level is named at all.
    is_flat: bool,
}

impl Levels {
    /// Reads the levels of a graph. An edge is on the level that it names, or else on that of both
    /// its ends; an edge whose ends are on different levels is on none in particular.
    pub fn new(graph: &RouteGraph) -> Self {
        let mut numbers = BTreeMap::new();
        let mut nodes: Vec<Level> = Vec::new();
        for node in graph.nodes() {
            nodes.push(number(&mut numbers, node.tags.as_deref()));
        }
        let edges = graph.edges().iter().map(|edge| {
            let own = number(&mut numbers, edge.tags.as_deref());
            let [from, to] = [edge.origin, edge.destination].map(|node| nodes[node.0 as usize]);
            match own {
                _ if from != to && from != 0 && to != 0 => 0,
                0 if from == to => from,
                own => own,
            }
        });
        let edges = edges.collect();
        Self { nodes, edges, is_flat: numbers.is_empty() }
    }

    /// Whether robots at two nodes aren't on different levels.
    pub fn join_nodes(&self, a: u32, b: u32) -> bool {
        may_meet(self.nodes[a as usize], self.nodes[b as usize])
    }

    /// Whether robots at a node and on an edge aren't on different levels.
    pub fn join_edge(&self, node: u32, edge: u32) -> bool {
        may_meet(self.nodes[node as usize], self.edges[edge as usize])
    }

    /// Whether robots on two edges are on one level for sure.
    pub fn are_shared(&self, a: u32, b: u32) -> bool {
        let [of_a, of_b] = [a, b].map(|edge| self.edges[edge as usize]);
        a == b || of_a == of_b && (of_a != 0 || self.is_flat)
    }
}

/// Returns the number of the level that tags name.
fn number<'graph>(numbers: &mut BTreeMap<&'graph str, Level>, tags: Option<&'graph Tags>) -> Level {
    let Some(name) = tags.and_then(|tags| tags.level.as_deref()) else { return 0 };
    let next = numbers.len() as Level + 1;
    *numbers.entry(name).or_insert(next)
}

fn may_meet(a: Level, b: Level) -> bool {
    a == b || a == 0 || b == 0
}
