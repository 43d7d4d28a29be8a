//! Zones: groups of nodes and edges with a rule for the robots in them.

use std::collections::{BTreeMap, BTreeSet};
use std::num::NonZeroU32;

use glam::DVec2;
use regatta_base::graph::{EdgeIndex, NodeIndex};

use super::facilities::Lift;
use super::route_graph::{Edge, Node, RouteGraph};
use super::tags::Tags;

/// A group of nodes and edges with a rule. A robot is in it while it stands at or drives along one
/// of them; a group without a rule is only a tag, [`Tags::zone`](super::tags::Tags::zone).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Zone {
    /// The name, unique among zones.
    pub name: Box<str>,
    /// The rule.
    pub rule: ZoneRule,
    /// Its nodes, in ascending order.
    pub nodes: Vec<NodeIndex>,
    /// Its edges, in ascending order.
    pub edges: Vec<EdgeIndex>,
    /// Those of its nodes that its file doesn't list: they are between its edges.
    pub inner: Vec<NodeIndex>,
}

impl Zone {
    /// Whether robots never stand at all of these nodes at once.
    pub(crate) fn keeps_apart(&self, nodes: &[NodeIndex]) -> bool {
        let ZoneRule::Capacity(robots) = self.rule else { return false };
        let inside = nodes.iter().filter(|node| self.nodes.binary_search(node).is_ok());
        inside.count() > robots.get() as usize
    }

    /// Whether it may keep a robot out: more robots than it lets in have room in it.
    pub(crate) fn is_limit(&self) -> bool {
        match self.rule {
            // Any number of robots have room on an edge.
            ZoneRule::Capacity(robots) => {
                !self.edges.is_empty() || self.nodes.len() > robots.get() as usize
            }
            ZoneRule::SameDirection => !self.edges.is_empty() || self.nodes.len() > 1,
        }
    }

    /// The nodes that a file has to list: without those that a reader finds between the edges.
    pub(crate) fn listed_nodes(&self, graph: &RouteGraph) -> Vec<NodeIndex> {
        if self.inner.is_empty() {
            return self.nodes.clone();
        }
        let found = inner_nodes(&self.edges, graph);
        let is_listed = |node: &&NodeIndex| !(self.inner.contains(node) && found.contains(node));
        self.nodes.iter().filter(is_listed).copied().collect()
    }
}

/// Returns the nodes between edges: a robot that stands there hasn't left them. The edges lead from
/// such a node to two others or more, or no other edge does: both directions of one road that ends
/// there don't make it one.
pub(crate) fn inner_nodes(edges: &[EdgeIndex], graph: &RouteGraph) -> BTreeSet<NodeIndex> {
    let mut neighbours: BTreeMap<NodeIndex, BTreeSet<NodeIndex>> = BTreeMap::new();
    for edge in edges.iter().map(|&edge| graph.edge(edge)) {
        neighbours.entry(edge.origin).or_default().insert(edge.destination);
        neighbours.entry(edge.destination).or_default().insert(edge.origin);
    }
    let edges: BTreeSet<EdgeIndex> = edges.iter().copied().collect();
    let mut has_others = BTreeSet::new();
    for (index, edge) in graph.edges().iter().enumerate() {
        if !edges.contains(&EdgeIndex(index as u32)) {
            has_others.extend([edge.origin, edge.destination]);
        }
    }
    let inner = neighbours
        .into_iter()
        .filter(|(node, others)| others.len() > 1 || !has_others.contains(node));
    inner.map(|(node, _)| node).collect()
}

/// The rule for the robots in a zone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ZoneRule {
    /// At most so many robots at the same time.
    Capacity(NonZeroU32),
    /// Several robots only if all have entered at the same node. Nodes where two or more of its
    /// edges meet are in it, too.
    SameDirection,
}

impl ZoneRule {
    /// The rule of a zone for one robot at a time: a block of openTCS, a mutex group of Open-RMF.
    pub const EXCLUSIVE: Self = Self::Capacity(NonZeroU32::MIN);
}

impl RouteGraph {
    /// Returns the names of the zones, with and without a rule, and the middle of the members of
    /// each on each level, in metres from [`origin`](Self::origin). The zones of lifts are left out.
    pub fn zone_places(&self) -> Vec<(&str, DVec2)> {
        let mut members: BTreeMap<(&str, Option<&str>), Vec<DVec2>> = BTreeMap::new();
        for zone in self.zones() {
            let nodes = zone.nodes.iter().map(|node| node_member(self.node(*node)));
            let edges = zone.edges.iter().map(|edge| self.edge_member(self.edge(*edge)));
            for (level, place) in nodes.chain(edges) {
                members.entry((&zone.name, level)).or_default().push(place);
            }
        }
        let nodes = self.nodes().iter();
        let nodes = nodes.map(|node| (node.tags.as_deref(), node_member(node)));
        let edges = self.edges().iter();
        let edges = edges.map(|edge| (edge.tags.as_deref(), self.edge_member(edge)));
        let ruled: BTreeSet<&str> = self.zones().iter().map(|zone| &*zone.name).collect();
        for (tags, (level, place)) in nodes.chain(edges) {
            if let Some(name) = tags.and_then(zone_of).filter(|name| !ruled.contains(name)) {
                members.entry((name, level)).or_default().push(place);
            }
        }
        let of_lifts: BTreeSet<String> = self.lifts().iter().map(Lift::zone_name).collect();
        members.retain(|(name, _), _| !of_lifts.contains(*name));
        members.into_iter().map(|((name, _), places)| (name, middle(&places))).collect()
    }

    /// Returns the level and the middle of an edge.
    fn edge_member<'a>(&'a self, edge: &'a Edge) -> (Option<&'a str>, DVec2) {
        (self.drawn_level(edge), edge.path.at(0.5).0)
    }
}

/// Returns the level and the place of a node.
fn node_member(node: &Node) -> (Option<&str>, DVec2) {
    (node.level(), node.position)
}

fn middle(places: &[DVec2]) -> DVec2 {
    places.iter().sum::<DVec2>() / places.len() as f64
}

fn zone_of(tags: &Tags) -> Option<&str> {
    tags.zone.as_deref()
}
