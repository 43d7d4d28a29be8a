//! The room that the zones of a layout have for robots that stand.

use regatta_layout::{EdgeIndex, NodeIndex, RouteGraph, ZoneRule};

/// The zones of a layout, and the robots in them.
pub(super) struct ZoneRoom {
    /// By node and by edge: the zones that it belongs to.
    of_node: Vec<Vec<u32>>,
    of_edge: Vec<Vec<u32>>,
    /// By zone: the robots that it still has room for.
    room: Vec<u32>,
}

impl ZoneRoom {
    pub fn new(graph: &RouteGraph) -> Self {
        let mut of_node = vec![Vec::new(); graph.nodes().len()];
        let mut of_edge = vec![Vec::new(); graph.edges().len()];
        let mut room = Vec::new();
        for (zone, index) in graph.zones().iter().zip(0..) {
            for node in &zone.nodes {
                of_node[node.0 as usize].push(index);
            }
            for edge in &zone.edges {
                of_edge[edge.0 as usize].push(index);
            }
            room.push(match zone.rule {
                ZoneRule::Capacity(robots) => robots.get(),
                // Robots that are there from the beginning have entered at no node.
                ZoneRule::SameDirection => 1,
            });
        }
        Self { of_node, of_edge, room }
    }

    /// The first zone of a node, if it is in one.
    pub fn first_of(&self, node: NodeIndex) -> Option<u32> {
        self.of_node[node.0 as usize].first().copied()
    }

    /// The robots that a zone still has room for.
    pub fn room_of(&self, zone: u32) -> usize {
        self.room[zone as usize] as usize
    }

    /// Whether all zones of a node have room for another robot.
    pub fn has_room(&self, node: NodeIndex) -> bool {
        self.of_node[node.0 as usize].iter().all(|zone| self.room[*zone as usize] > 0)
    }

    /// Adds a robot at a place, also beyond the room of its zones.
    pub fn add(&mut self, edge: Option<EdgeIndex>, node: NodeIndex) {
        for zone in self.zones(edge, node) {
            let room = &mut self.room[zone as usize];
            *room = room.saturating_sub(1);
        }
    }

    /// Returns the zones of an edge and of the node at its end, each once.
    fn zones(&self, edge: Option<EdgeIndex>, node: NodeIndex) -> Vec<u32> {
        let mut zones = self.of_node[node.0 as usize].clone();
        if let Some(edge) = edge {
            zones.extend(&self.of_edge[edge.0 as usize]);
            zones.sort_unstable();
            zones.dedup();
        }
        zones
    }
}
