//! Zones: groups of nodes and edges with a rule for the robots in them.

use std::collections::{BTreeMap, BTreeSet};
use std::num::NonZeroU32;

use glam::DVec2;
use regatta_base::graph::{EdgeIndex, NodeIndex};

use super::route_graph::RouteGraph;
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
    /// each, in metres from [`origin`](Self::origin). The zones of lifts are left out.
    pub fn zone_places(&self) -> Vec<(&str, DVec2)> {
        let mut members: BTreeMap<&str, Vec<DVec2>> = BTreeMap::new();
        for zone in self.zones() {
            let nodes = zone.nodes.iter().map(|node| self.node(*node).position);
            let edges = zone.edges.iter().map(|edge| self.edge(*edge).path.at(0.5).0);
            members.insert(&zone.name, nodes.chain(edges).collect());
        }
        let nodes = self.nodes().iter().map(|node| (node.tags.as_deref(), node.position));
        let edges = self.edges().iter().map(|edge| (edge.tags.as_deref(), edge.path.at(0.5).0));
        let ruled: BTreeSet<&str> = self.zones().iter().map(|zone| &*zone.name).collect();
        for (tags, place) in nodes.chain(edges) {
            if let Some(name) = tags.and_then(zone_of).filter(|name| !ruled.contains(name)) {
                members.entry(name).or_default().push(place);
            }
        }
        for lift in self.lifts() {
            members.remove(&*lift.zone_name());
        }
        members.retain(|_, places| !places.is_empty());
        members.into_iter().map(|(name, places)| (name, middle(&places))).collect()
    }
}

fn middle(places: &[DVec2]) -> DVec2 {
    places.iter().sum::<DVec2>() / places.len() as f64
}

fn zone_of(tags: &Tags) -> Option<&str> {
    tags.zone.as_deref()
}
