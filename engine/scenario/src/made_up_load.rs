//! A load for a layout without one: orders between its stations.

use regatta_layout::{Role, RouteGraph};

/// The stops of made-up orders, in the main part of a layout. Robots can drive between any two.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum MadeUpLoad {
    /// From a node to pick at to a node to drop at, by id.
    Transports {
        /// The nodes to pick at.
        picks: Vec<u32>,
        /// The nodes to drop at.
        drops: Vec<u32>,
    },
    /// From one of these nodes of stations to the next, by id.
    Stations(Vec<u32>),
    /// From one of these nodes to the next, by id, since the layout names no stations.
    Nodes(Vec<u32>),
    /// From any node that isn't a charger to the next, as in a load without groups.
    AnyNode,
}

impl MadeUpLoad {
    /// Returns the load of the [main part](regatta_layout::traffic::MainPart) of a layout.
    pub fn new(graph: &RouteGraph) -> Self {
        let purposes = graph.purposes();
        let with = |fits: fn(Role) -> bool| {
            let nodes = graph.nodes().iter().zip(&purposes);
            nodes.filter(|(_, role)| fits(**role)).map(|(node, _)| node.id).collect::<Vec<u32>>()
        };
        let (picks, drops) = (with(Role::is_pick), with(Role::is_drop));
        if picks.iter().any(|pick| drops.iter().any(|drop| drop != pick)) {
            return Self::Transports { picks, drops };
        }
        let stations = station_nodes(graph);
        if stations.len() > 1 {
            return Self::Stations(stations);
        }
        // Chargers are stops only where there are hardly other nodes.
        match purposes.iter().filter(|role| **role != Role::Charge).count() {
            0 | 1 => Self::Nodes(with(|_| true)),
            _ => Self::AnyNode,
        }
    }

    /// The number of nodes with stations that it has; `None` if the layout names none.
    pub fn stations(&self) -> Option<usize> {
        match self {
            Self::Transports { picks, drops } => {
                let others = drops.iter().filter(|drop| !picks.contains(drop));
                Some(picks.len() + others.count())
            }
            Self::Stations(nodes) => Some(nodes.len()),
            Self::Nodes(_) | Self::AnyNode => None,
        }
    }

    /// The stops in words, as in 'each robot has an order, from …'.
    pub fn words(&self) -> &'static str {
        match self {
            Self::Transports { .. } => "from stations to pick at to stations to drop at",
            Self::Stations(_) => "from one station to the next",
            Self::Nodes(_) | Self::AnyNode => {
                "from one node to the next, since the layout names no stations"
            }
        }
    }

    /// Names the nodes of [`AnyNode`](Self::AnyNode), for a layout that has more than the graph.
    #[must_use]
    pub fn named(self, graph: &RouteGraph) -> Self {
        match self {
            Self::AnyNode => {
                let nodes = graph.nodes().iter().zip(graph.purposes());
                let nodes = nodes.filter(|(_, role)| *role != Role::Charge);
                Self::Nodes(nodes.map(|(node, _)| node.id).collect())
            }
            named => named,
        }
    }

    /// Returns the section `load` of a scenario in which every robot always has an order.
    pub fn section(&self) -> String {
        let groups: &[(&str, &[u32])] = match self {
            Self::Transports { picks, drops } => &[("pick", picks), ("drop", drops)],
            Self::Stations(nodes) => &[("stations", nodes)],
            Self::Nodes(nodes) => &[("nodes", nodes)],
            Self::AnyNode => &[],
        };
        let mut text = format!("load:                                 # {}\n", self.words());
        text += if groups.is_empty() { "" } else { "  groups:\n" };
        for (name, nodes) in groups {
            let ids: Vec<String> = nodes.iter().map(u32::to_string).collect();
            text += &format!("    {name}: [{}]\n", ids.join(", "));
        }
        text += match self {
            Self::Transports { .. } => "  from: pick\n  to: drop\n",
            Self::Stations(_) => "  among: stations\n",
            Self::Nodes(_) => "  among: nodes\n",
            Self::AnyNode => "",
        };
        text + "  endless: robots                     # as many open orders as there are robots\n  \
                dwell: {min: 5, max: 15}            # seconds at each stop\n"
    }
}

/// Returns the ids of the nodes of stations, in ascending order of the nodes.
fn station_nodes(graph: &RouteGraph) -> Vec<u32> {
    let mut is_station = vec![false; graph.nodes().len()];
    for node in graph.stations().iter().flat_map(|station| &station.nodes) {
        is_station[node.0 as usize] = true;
    }
    let nodes = graph.nodes().iter().zip(is_station);
    nodes.filter(|(_, is_station)| *is_station).map(|(node, _)| node.id).collect()
}
