//! The levels of a building: robots on different ones don't touch.

use std::collections::BTreeMap;

use regatta_base::graph::NodeIndex;

use crate::model::route_graph::RouteGraph;
use crate::model::tags::Tags;

/// The number of a level; 0 for none in particular, such as that of a lift.
type Level = u32;

/// The levels of a graph's nodes and edges.
#[derive(Debug)]
pub struct Levels {
    nodes: Vec<Level>,
    edges: Vec<Level>,
}

impl Levels {
    /// Reads the levels of a graph. An edge is on the level that it names, or else on that of both
    /// its ends; an edge whose ends are on different levels is on none in particular.
    pub fn new(graph: &RouteGraph) -> Self {
        let mut numbers = BTreeMap::new();
        let mut level = |tags: Option<&Tags>| {
            let name = tags.and_then(|tags| tags.level.clone());
            let next = numbers.len() as Level + 1;
            name.map_or(0, |name| *numbers.entry(name).or_insert(next))
        };
        let nodes: Vec<Level> =
            graph.nodes().iter().map(|node| level(node.tags.as_deref())).collect();
        let of_node = |node: NodeIndex| nodes[node.0 as usize];
        let edges = graph.edges().iter().map(|edge| {
            let own = level(edge.tags.as_deref());
            let (from, to) = (of_node(edge.origin), of_node(edge.destination));
            match own {
                _ if from != to && from != 0 && to != 0 => 0,
                0 if from == to => from,
                own => own,
            }
        });
        Self { edges: edges.collect(), nodes }
    }

    /// Whether robots at two nodes aren't on different levels.
    pub fn join_nodes(&self, a: u32, b: u32) -> bool {
        may_meet(self.nodes[a as usize], self.nodes[b as usize])
    }

    /// Whether robots at a node and on an edge aren't on different levels.
    pub fn join_edge(&self, node: u32, edge: u32) -> bool {
        may_meet(self.nodes[node as usize], self.edges[edge as usize])
    }
}

fn may_meet(a: Level, b: Level) -> bool {
    a == b || a == 0 || b == 0
}
