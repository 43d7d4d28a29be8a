//! The roads of a layout in LIF, the ways on them, and the nodes that vehicles have.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::path::Path;

use serde::Deserialize;

use crate::Result;

#[derive(Deserialize)]
struct Lif {
    layouts: Vec<Layout>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Layout {
    edges: Vec<LifEdge>,
    #[serde(default)]
    stations: Vec<Station>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct LifEdge {
    edge_id: String,
    start_node_id: String,
    end_node_id: String,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Station {
    station_id: String,
    interaction_node_ids: Vec<String>,
}

/// The edges that leave each node, and the nodes of stations.
pub struct Roads {
    edges: BTreeMap<String, Vec<(String, String)>>,
    stations: BTreeMap<String, String>,
}

/// Nodes and the edges between them.
#[derive(Clone)]
pub struct Way {
    pub nodes: Vec<String>,
    pub edges: Vec<String>,
}

impl Roads {
    pub fn read(path: &Path) -> Result<Self> {
        let lif: Lif = serde_json::from_str(&std::fs::read_to_string(path)?)?;
        let (mut edges, mut stations) = (BTreeMap::<_, Vec<_>>::new(), BTreeMap::new());
        for layout in lif.layouts {
            for LifEdge { edge_id, start_node_id, end_node_id } in layout.edges {
                edges.entry(start_node_id).or_default().push((edge_id, end_node_id));
            }
            for station in layout.stations {
                let node = station.interaction_node_ids.into_iter().next();
                stations.extend(node.map(|node| (station.station_id, node)));
            }
        }
        Ok(Self { edges, stations })
    }

    /// The names of the stations.
    pub fn stations(&self) -> Vec<&String> {
        self.stations.keys().collect()
    }

    /// The way with the fewest edges from a node or a station to another.
    pub fn way(&self, from: &str, to: &str) -> Option<Way> {
        let [from, to] = [from, to].map(|name| self.stations.get(name).map_or(name, |it| it));
        let mut came_by: BTreeMap<&str, (&str, &str)> = BTreeMap::new();
        let mut next = VecDeque::from([from]);
        while let Some(node) = next.pop_front().filter(|_| !came_by.contains_key(to)) {
            for (edge, end) in self.edges.get(node).into_iter().flatten() {
                if end != from && !came_by.contains_key(&**end) {
                    came_by.insert(end, (node, edge));
                    next.push_back(end);
                }
            }
        }
        let mut way = Way { nodes: vec![to.to_owned()], edges: Vec::new() };
        let mut node = to;
        while node != from {
            let (before, edge) = came_by.get(node)?;
            way.edges.insert(0, (*edge).to_owned());
            way.nodes.insert(0, (*before).to_owned());
            node = before;
        }
        Some(way)
    }
}

impl Way {
    /// The way with another one that begins at its end.
    pub fn joined(mut self, other: Self) -> Self {
        self.nodes.extend(other.nodes.into_iter().skip(1));
        self.edges.extend(other.edges);
        self
    }
}

/// The vehicles that have nodes.
#[derive(Default)]
pub struct Claims {
    of_node: BTreeMap<String, BTreeSet<String>>,
}

impl Claims {
    /// Replaces the nodes of a vehicle.
    pub fn set(&mut self, vehicle: &str, nodes: Vec<String>) {
        for vehicles in self.of_node.values_mut() {
            vehicles.remove(vehicle);
        }
        for node in nodes {
            self.of_node.entry(node).or_default().insert(vehicle.to_owned());
        }
    }

    /// Gives a vehicle a node, unless others have it. Returns whether it has it.
    pub fn claim(&mut self, vehicle: &str, node: &str) -> bool {
        let vehicles = self.of_node.entry(node.to_owned()).or_default();
        if vehicles.iter().any(|other| other != vehicle) {
            return false;
        }
        vehicles.insert(vehicle.to_owned());
        true
    }
}
