//! A load for a layout without one: orders between its stations.

use regatta_layout::{NodeIndex, Role, RouteGraph};

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
    /// From one of these nodes of stations to another, by id. Chargers and parking places are none.
    Stations(Vec<u32>),
    /// From one of these nodes to another, by id, since robots can't drive between two stations.
    Nodes(Vec<u32>),
}

impl MadeUpLoad {
    /// Returns the load of the [main part](regatta_layout::traffic::MainPart) of a layout.
    pub fn new(graph: &RouteGraph) -> Self {
        let (picks, drops) = (nodes_with(graph, Role::is_pick), nodes_with(graph, Role::is_drop));
        if picks.iter().any(|pick| drops.iter().any(|drop| drop != pick)) {
            return Self::Transports { picks, drops };
        }
        let stations = station_nodes(graph);
        if stations.len() > 1 {
            return Self::Stations(stations);
        }
        // Chargers are stops only where there are hardly other nodes.
        let nodes = nodes_with(graph, |role| role != Role::Charge);
        Self::Nodes(if nodes.len() > 1 { nodes } else { nodes_with(graph, |_| true) })
    }

    /// The number of nodes with stations that it has; `None` if the layout names none.
    pub fn stations(&self) -> Option<usize> {
        match self {
            Self::Transports { picks, drops } => {
                let others = drops.iter().filter(|drop| !picks.contains(drop));
                Some(picks.len() + others.count())
            }
            Self::Stations(nodes) => Some(nodes.len()),
            Self::Nodes(_) => None,
        }
    }

    /// The reason why the orders have other stops than the stations of the whole layout suggest:
    /// `None` if they are those.
    pub fn other_stops(&self, whole: &RouteGraph) -> Option<String> {
        let purposes = whole.purposes();
        let has_transports = purposes.iter().any(|role| role.is_pick())
            || purposes.iter().any(|role| role.is_drop());
        match self {
            Self::Transports { .. } => None,
            _ if has_transports => Some(format!(
                "robots can't drive from a pick station to a drop station and back; orders lead {} \
                 instead",
                self.words()
            )),
            Self::Stations(_) => None,
            Self::Nodes(_) => {
                let reason = match station_nodes(whole).len() {
                    0 if is_without_stations(whole) => return None,
                    0 => "all stations are chargers and parking places",
                    1 => "there is only one station for orders",
                    _ => "robots can't drive between two stations",
                };
                Some(format!("{reason}; orders lead {} instead", self.words()))
            }
        }
    }

    /// The stops in words, as in 'each robot has an order, from …'.
    pub fn words(&self) -> &'static str {
        match self {
            Self::Transports { .. } => "from pick stations to drop stations",
            Self::Stations(_) => "from one station to another",
            Self::Nodes(_) => "from one node to another",
        }
    }

    /// Returns the section `load` of a scenario in which every robot always has an order.
    pub fn section(&self) -> String {
        let groups: &[(&str, &[u32])] = match self {
            Self::Transports { picks, drops } => &[("pick", picks), ("drop", drops)],
            Self::Stations(nodes) => &[("stations", nodes)],
            Self::Nodes(nodes) => &[("nodes", nodes)],
        };
        let mut text = format!("load:                                 # {}\n", self.words());
        text += "  groups:\n";
        for (name, nodes) in groups {
            let ids: Vec<String> = nodes.iter().map(u32::to_string).collect();
            text += &format!("    {name}: [{}]\n", ids.join(", "));
        }
        text += match self {
            Self::Transports { .. } => "  from: pick\n  to: drop\n",
            Self::Stations(_) => "  from: stations\n  to: stations\n",
            Self::Nodes(_) => "  from: nodes\n  to: nodes\n",
        };
        text + "  endless: robots                     # as many open orders as there are robots\n  \
                dwell: {min: 5, max: 15}            # seconds at each stop\n"
    }
}

/// Whether a layout has neither stations nor nodes with a role.
fn is_without_stations(graph: &RouteGraph) -> bool {
    graph.stations().is_empty() && graph.purposes().iter().all(|role| *role == Role::None)
}

/// Returns the ids of the nodes whose purpose fits, in ascending order of the nodes.
fn nodes_with(graph: &RouteGraph, fits: fn(Role) -> bool) -> Vec<u32> {
    let nodes = (0..).map(NodeIndex).zip(graph.nodes()).zip(graph.purposes());
    // A robot that stands in a cabin keeps it.
    let is_in_lift = |node| graph.lifts().iter().any(|lift| lift.level_of(node).is_some());
    let nodes = nodes.filter(|((index, _), role)| fits(*role) && !is_in_lift(*index));
    nodes.map(|((_, node), _)| node.id).collect()
}

/// Returns the ids of the nodes of stations other than chargers and parking places, in ascending
/// order of the nodes.
fn station_nodes(graph: &RouteGraph) -> Vec<u32> {
    let mut is_station = vec![false; graph.nodes().len()];
    for node in graph.stations().iter().flat_map(|station| &station.nodes) {
        is_station[node.0 as usize] = true;
    }
    let nodes = graph.nodes().iter().zip(graph.purposes()).zip(is_station);
    let stations = nodes.filter(|((_, role), is_station)| {
        *is_station && !matches!(role, Role::Charge | Role::Park)
    });
    stations.map(|((node, _), _)| node.id).collect()
}
