//! Route graphs: nodes with poses, and directed Bézier edges between them.

use std::collections::HashMap;

use glam::DVec2;

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
    node_by_id: HashMap<u32, NodeIndex>,
    edge_by_id: HashMap<u32, EdgeIndex>,
    /// Legs that leave each node: `departures[departures_start[n]..departures_start[n + 1]]`.
    departures: Vec<Leg>,
    departures_start: Vec<u32>,
}
