//! Roads that are added to a layout: nodes and straight edges, like those that are there.

use glam::DVec2;
use regatta_layout::{CubicBezier, Edge, EdgeChange, Node, NodeIndex, Role, RouteGraph, Tags};

/// The room beside a robot on a road beside another one, in metres, so that robots on both don't
/// touch.
pub const CLEARANCE: f64 = 0.6;

/// A layout with more roads.
pub struct Roads<'a> {
    graph: &'a RouteGraph,
    nodes: Vec<(Node, Option<NodeIndex>)>,
    edges: Vec<Edge>,
    closed: Vec<u32>,
    next_node: u32,
    next_edge: u32,
}

impl<'a> Roads<'a> {
    /// Begins with the roads of a layout.
    pub fn new(graph: &'a RouteGraph) -> Self {
        let node = graph.nodes().iter().map(|node| node.id).max().unwrap_or(0);
        let edge = graph.edges().iter().map(|edge| edge.id).max().unwrap_or(0);
        let (nodes, edges, closed) = (Vec::new(), Vec::new(), Vec::new());
        Self { graph, nodes, edges, closed, next_node: node + 1, next_edge: edge + 1 }
    }

    /// Adds a node on the level of another one, with a heading.
    pub fn node(&mut self, position: DVec2, heading: DVec2, near: NodeIndex) -> NodeIndex {
        let level = self.graph.node(near).tags.as_ref().and_then(|tags| tags.level.clone());
        let tags = Tags { level, ..Tags::default() };
        self.push(position, heading, Role::None, tags, None)
    }

    /// Adds a node with the role, the zone and the stations of another one.
    pub fn node_like(&mut self, position: DVec2, heading: DVec2, like: NodeIndex) -> NodeIndex {
        let other = self.graph.node(like);
        let tags = other.tags.as_ref();
        let tags = tags.map_or_else(Tags::default, |tags| Tags {
            level: tags.level.clone(),
            zone: tags.zone.clone(),
            ..Tags::default()
        });
        self.push(position, heading, other.role, tags, Some(like))
    }

    fn push(
        &mut self,
        position: DVec2,
        heading: DVec2,
        role: Role,
        tags: Tags,
        like: Option<NodeIndex>,
    ) -> NodeIndex {
        let theta = heading.y.atan2(heading.x);
        let node = Node { role, tags: tags.boxed(), ..Node::new(self.next_node, position, theta) };
        self.next_node += 1;
        self.nodes.push((node, like));
        NodeIndex((self.graph.nodes().len() + self.nodes.len() - 1) as u32)
    }

    /// The id of a node.
    pub fn id(&self, node: NodeIndex) -> u32 {
        self.get(node).id
    }

    fn get(&self, node: NodeIndex) -> &Node {
        let known = self.graph.nodes();
        let index = node.0 as usize;
        known.get(index).unwrap_or_else(|| &self.nodes[index - known.len()].0)
    }

    /// The position of a node.
    pub fn position(&self, node: NodeIndex) -> DVec2 {
        self.get(node).position
    }

    /// Adds a straight edge, otherwise like another one.
    pub fn edge(&mut self, origin: NodeIndex, destination: NodeIndex, like: &Edge) {
        let path = CubicBezier::straight(self.position(origin), self.position(destination)).into();
        let id = self.next_edge;
        self.next_edge += 1;
        self.edges.push(Edge { id, origin, destination, path, tags: None, ..like.clone() });
    }

    /// Takes an edge out, by its id.
    pub fn close(&mut self, edge: u32) {
        self.closed.push(edge);
    }

    /// Returns the layout; `None` if no edge is left.
    pub fn done(self) -> Option<RouteGraph> {
        let graph = self.graph.with_roads(&self.nodes, &self.edges);
        let changes: Vec<_> = self.closed.iter().map(|id| (*id, EdgeChange::Close)).collect();
        graph.with_changes(&changes).ok()
    }
}

/// Returns the edges that lead to a node.
pub fn arrivals(graph: &RouteGraph, node: NodeIndex) -> impl Iterator<Item = &Edge> {
    graph.edges().iter().filter(move |edge| edge.destination == node)
}

/// Returns the edges that lead away from a node.
pub fn exits(graph: &RouteGraph, node: NodeIndex) -> impl Iterator<Item = &Edge> {
    graph.edges().iter().filter(move |edge| edge.origin == node)
}

/// Returns the distance in metres from a point to the nodes and edges of a layout, but for those at
/// some nodes.
pub fn room(graph: &RouteGraph, point: DVec2, except: &[NodeIndex]) -> f64 {
    let mut room = f64::INFINITY;
    for (node, index) in graph.nodes().iter().zip((0..).map(NodeIndex)) {
        if !except.contains(&index) {
            room = room.min(node.position.distance(point));
        }
    }
    for edge in graph.edges() {
        if except.contains(&edge.origin) || except.contains(&edge.destination) {
            continue;
        }
        for part in [0.25, 0.5, 0.75] {
            room = room.min(edge.path.at(part).0.distance(point));
        }
    }
    room
}
