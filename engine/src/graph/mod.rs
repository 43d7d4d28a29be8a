//! Route graphs: nodes with poses, and directed Bézier edges between them.

pub mod arc_length;
pub mod bezier;
pub mod components;
pub mod draw;
pub mod finding;
mod fit;
pub mod generate;
pub mod info;
mod item;
mod lines;
mod read;
pub mod spline;
mod stretch;
mod survey;
pub mod validate;
mod value;
mod yaml;

#[cfg(test)]
mod arc_length_tests;

use std::collections::BTreeMap;

use glam::DVec2;

pub use finding::{Finding, Findings, Severity, Subject};
pub use read::{GraphError, MAX_FILE_BYTES, ReadOptions, parse, read};
pub use spline::Handles;

/// Position of a node in [`RouteGraph::nodes`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct NodeIndex(pub u32);

/// Position of an edge in [`RouteGraph::edges`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct EdgeIndex(pub u32);

/// A place with a heading.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// Id in the file; unique among nodes.
    pub id: u32,
    /// Metres east and north.
    pub position: DVec2,
    /// Radians in (-π, π].
    pub theta: f64,
}

/// A cubic Bézier curve in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CubicBezier {
    /// P0 to P3.
    pub control_points: [DVec2; 4],
}

/// A directed curve from one node to another.
#[derive(Clone, Debug, PartialEq)]
pub struct Edge {
    /// Id in the file; unique among edges.
    pub id: u32,
    /// Where it starts.
    pub origin: NodeIndex,
    /// Where it ends.
    pub destination: NodeIndex,
    /// Its course. Straight edges are cubics with evenly spaced control points.
    pub curve: CubicBezier,
    /// Metres per second from origin to destination; > 0.
    pub velocity_forward: f64,
    /// Metres per second from destination to origin in reverse gear; `None` if that is not allowed.
    pub velocity_backwards: Option<f64>,
}

/// Which way along an edge, and so which way the robot faces.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Gear {
    /// From origin to destination, facing ahead.
    Forward,
    /// From destination to origin, heading unchanged: facing back.
    Reverse,
}

/// An edge driven in a gear: what a route is made of. Files write it as the edge's id, `-ID` in reverse.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Leg {
    /// The edge.
    pub edge: EdgeIndex,
    /// The gear.
    pub gear: Gear,
}

/// A validated route graph: every index is in range, every number finite and sane, every id unique, and
/// there is at least one edge.
#[derive(Clone, Debug)]
pub struct RouteGraph {
    nodes: Vec<Node>,
    edges: Vec<Edge>,
    node_by_id: BTreeMap<u32, NodeIndex>,
    edge_by_id: BTreeMap<u32, EdgeIndex>,
    /// Legs that leave each node: `departures[departures_start[n]..departures_start[n + 1]]`.
    departures: Vec<Leg>,
    departures_start: Vec<u32>,
}

impl RouteGraph {
    /// Indexes parts that `validate` has found to be sound.
    ///
    /// # Panics
    /// If an edge names a node that isn't there: `validate` would have refused the file.
    pub(crate) fn from_valid_parts(nodes: Vec<Node>, edges: Vec<Edge>) -> Self {
        let node_by_id = (0..).map(NodeIndex).zip(&nodes).map(|(index, node)| (node.id, index)).collect();
        let edge_by_id = (0..).map(EdgeIndex).zip(&edges).map(|(index, edge)| (edge.id, index)).collect();
        let (departures, departures_start) = departures_by_node(nodes.len(), &edges);
        Self { nodes, edges, node_by_id, edge_by_id, departures, departures_start }
    }

    /// All nodes, by [`NodeIndex`].
    pub fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// All edges, by [`EdgeIndex`].
    pub fn edges(&self) -> &[Edge] {
        &self.edges
    }

    /// The node at an index.
    pub fn node(&self, index: NodeIndex) -> &Node {
        &self.nodes[index.0 as usize]
    }

    /// The edge at an index.
    pub fn edge(&self, index: EdgeIndex) -> &Edge {
        &self.edges[index.0 as usize]
    }

    /// The node with that id in the file.
    pub fn node_by_id(&self, id: u32) -> Option<NodeIndex> {
        self.node_by_id.get(&id).copied()
    }

    /// The edge with that id in the file.
    pub fn edge_by_id(&self, id: u32) -> Option<EdgeIndex> {
        self.edge_by_id.get(&id).copied()
    }

    /// Legs that leave a node: forward ones along edges that start there, reverse ones along edges that
    /// end there and may be driven backwards; in the order of the edges.
    pub fn departures(&self, node: NodeIndex) -> &[Leg] {
        let range =
            self.departures_start[node.0 as usize] as usize..self.departures_start[node.0 as usize + 1] as usize;
        &self.departures[range]
    }

    /// Where a leg starts.
    pub fn leg_start(&self, leg: Leg) -> NodeIndex {
        let edge = self.edge(leg.edge);
        match leg.gear {
            Gear::Forward => edge.origin,
            Gear::Reverse => edge.destination,
        }
    }

    /// Where a leg ends.
    pub fn leg_end(&self, leg: Leg) -> NodeIndex {
        let edge = self.edge(leg.edge);
        match leg.gear {
            Gear::Forward => edge.destination,
            Gear::Reverse => edge.origin,
        }
    }

    /// Commanded speed on a leg in metres per second; `None` if the edge can't be driven in that gear.
    pub fn leg_velocity(&self, leg: Leg) -> Option<f64> {
        let edge = self.edge(leg.edge);
        match leg.gear {
            Gear::Forward => Some(edge.velocity_forward),
            Gear::Reverse => edge.velocity_backwards,
        }
    }
}

/// Counting sort of the legs by the node that they leave.
fn departures_by_node(nodes: usize, edges: &[Edge]) -> (Vec<Leg>, Vec<u32>) {
    let legs = || {
        (0..).map(EdgeIndex).zip(edges).flat_map(|(index, edge)| {
            let forward = (edge.origin, Leg { edge: index, gear: Gear::Forward });
            let reverse = edge.velocity_backwards.map(|_| (edge.destination, Leg { edge: index, gear: Gear::Reverse }));
            std::iter::once(forward).chain(reverse)
        })
    };
    let mut start = vec![0u32; nodes + 1];
    for (node, _) in legs() {
        start[node.0 as usize + 1] += 1;
    }
    for node in 0..nodes {
        start[node + 1] += start[node];
    }
    let placeholder = Leg { edge: EdgeIndex(0), gear: Gear::Forward };
    let mut departures = vec![placeholder; start[nodes] as usize];
    let mut next = start.clone();
    for (node, leg) in legs() {
        let slot = &mut next[node.0 as usize];
        departures[*slot as usize] = leg;
        *slot += 1;
    }
    (departures, start)
}
