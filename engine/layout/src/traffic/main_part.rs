//! The main part of a layout: the roads on which a fleet can work.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

use regatta_base::graph::{EdgeIndex, NodeIndex};

use super::network::Network;
use super::parts::{CutOff, Part, parts};
use super::stations::station_names;
use crate::model::facilities::{Door, Lift, LiftLevel};
use crate::model::route_graph::{Edge, Node, RouteGraph};
use crate::model::tags::Station;
use crate::model::value::{plural, shorten};
use crate::model::zones::Zone;

/// The largest number of stations that a text names.
const MOST_NAMES: usize = 20;

/// The main part of a layout: nodes that all can be reached from each other, and the edges between
/// them. Legs that are slower than a [crawl](regatta_base::graph::CRAWL) are no ways.
#[derive(Clone, Debug)]
pub struct MainPart {
    /// Its roads, with the ids of the layout.
    pub graph: RouteGraph,
    /// The other stations and nodes, by reason.
    pub left_out: Vec<LeftOut>,
    /// The nodes of the layout that it doesn't have.
    pub cut_off: BTreeMap<NodeIndex, CutOff>,
}

/// Stations and nodes that are cut off from the main part in the same way.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LeftOut {
    /// The way in which they are cut off; `None` for stations without a node.
    pub cut_off: Option<CutOff>,
    /// The names of stations without a node in the main part; of a node if it has a role and is no
    /// station's. In ascending order.
    pub stations: Vec<String>,
    /// The names of other nodes.
    pub other_nodes: Vec<String>,
}

impl LeftOut {
    fn new(cut_off: Option<CutOff>) -> Self {
        Self { cut_off, stations: Vec::new(), other_nodes: Vec::new() }
    }
}

impl MainPart {
    /// Returns the main part of a layout; `None` if it has no edge.
    pub fn of(graph: &RouteGraph) -> Option<Self> {
        Self::around(graph, &[])
    }

    /// Returns the part with the most of some nodes, such as the stops of a load; the main part if
    /// there are none. `None` if it has no edge.
    pub fn around(graph: &RouteGraph, wanted: &[NodeIndex]) -> Option<Self> {
        let network = Network::around(graph, wanted);
        let names = station_names(graph);
        let parts = parts(&network, &names);
        let cut_off = parts
            .iter()
            .flat_map(|part| part.nodes.iter().map(|node| (*node, part.cut_off)))
            .collect();
        let left_out = left_out(graph, &parts);
        Some(Self { graph: restricted(graph, &network)?, left_out, cut_off })
    }
}

fn left_out(graph: &RouteGraph, parts: &[Part]) -> Vec<LeftOut> {
    let outside: BTreeSet<NodeIndex> = parts.iter().flat_map(|part| &part.nodes).copied().collect();
    let mut of_nodes: BTreeMap<NodeIndex, Vec<String>> = BTreeMap::new();
    let mut served = BTreeSet::new();
    for station in graph.stations() {
        served.extend(station.nodes.iter().copied());
        if station.nodes.iter().all(|node| outside.contains(node)) {
            for node in &station.nodes {
                of_nodes.entry(*node).or_default().push(station.name.clone());
            }
        }
    }
    let mut found: BTreeMap<u8, LeftOut> = BTreeMap::new();
    for part in parts {
        let cut_off = Some(part.cut_off);
        let found = found.entry(part.cut_off as u8).or_insert_with(|| LeftOut::new(cut_off));
        for node in &part.nodes {
            if let Some(names) = of_nodes.get(node) {
                found.stations.extend_from_slice(names);
            } else if part.stations.contains(node) && !served.contains(node) {
                found.stations.push(node_name(graph.node(*node)));
            } else {
                found.other_nodes.push(node_name(graph.node(*node)));
            }
        }
    }
    let mut found: Vec<LeftOut> = found.into_values().collect();
    let stations = unlinked(graph);
    if !stations.is_empty() {
        found.push(LeftOut { stations, ..LeftOut::new(None) });
    }
    for found in &mut found {
        found.stations.sort();
        found.stations.dedup();
    }
    found
}

/// Returns the names of the stations without a node.
pub(super) fn unlinked(graph: &RouteGraph) -> Vec<String> {
    let unlinked = graph.stations().iter().filter(|station| station.nodes.is_empty());
    unlinked.map(|station| station.name.clone()).collect()
}

fn node_name(node: &Node) -> String {
    node.name().map_or_else(|| format!("node {}", node.id), str::to_owned)
}

/// Returns the roads of the main part; `None` if there are none.
fn restricted(graph: &RouteGraph, network: &Network<'_>) -> Option<RouteGraph> {
    let main = network.main_nodes();
    let mut new_nodes = vec![None; graph.nodes().len()];
    for (new, &old) in (0..).map(NodeIndex).zip(&main) {
        new_nodes[old as usize] = Some(new);
    }
    let nodes = main.iter().map(|&node| graph.node(NodeIndex(node)).clone()).collect();
    let (mut edges, mut new_edges) = (Vec::new(), BTreeMap::new());
    for (old, edge) in (0..).map(EdgeIndex).zip(graph.edges()) {
        if let (Some(origin), Some(destination)) =
            (new_nodes[edge.origin.0 as usize], new_nodes[edge.destination.0 as usize])
        {
            new_edges.insert(old, EdgeIndex(edges.len() as u32));
            edges.push(Edge { origin, destination, ..edge.clone() });
        }
    }
    if edges.is_empty() {
        return None;
    }
    let stations = graph.stations().iter().map(|station| Station {
        nodes: station.nodes.iter().filter_map(|node| new_nodes[node.0 as usize]).collect(),
        ..station.clone()
    });
    let stations = stations.filter(|station| !station.nodes.is_empty()).collect();
    let zones = graph.zones().iter().map(|zone| Zone {
        nodes: zone.nodes.iter().filter_map(|node| new_nodes[node.0 as usize]).collect(),
        edges: zone.edges.iter().filter_map(|edge| new_edges.get(edge).copied()).collect(),
        inner: zone.inner.iter().filter_map(|node| new_nodes[node.0 as usize]).collect(),
        ..zone.clone()
    });
    let zones = zones.filter(|zone| !(zone.nodes.is_empty() && zone.edges.is_empty())).collect();
    let doors = graph.doors().iter().map(|door| Door {
        edges: door.edges.iter().filter_map(|edge| new_edges.get(edge).copied()).collect(),
        ..door.clone()
    });
    let doors = doors.filter(|door| !door.edges.is_empty()).collect();
    let lifts =
        graph.lifts().iter().filter_map(|lift| restricted_lift(lift, &new_nodes, &new_edges));
    let lifts = lifts.collect();
    Some(
        RouteGraph::from_valid_parts(nodes, edges)
            .with_origin(graph.origin())
            .with_surroundings(stations, graph.background().to_vec())
            .with_zones(zones)
            .with_facilities(doors, lifts),
    )
}

/// Returns a lift with new indices of nodes and edges, on the levels that have nodes left; `None`
/// if these are fewer than two. A cabin whose home is gone begins at the lowest level.
fn restricted_lift(
    lift: &Lift,
    new_nodes: &[Option<NodeIndex>],
    new_edges: &BTreeMap<EdgeIndex, EdgeIndex>,
) -> Option<Lift> {
    let home = &lift.levels[lift.home].name;
    let levels = lift.levels.iter().map(|level| LiftLevel {
        nodes: level.nodes.iter().filter_map(|node| new_nodes[node.0 as usize]).collect(),
        ..level.clone()
    });
    let levels: Vec<LiftLevel> = levels.filter(|level| !level.nodes.is_empty()).collect();
    if levels.len() < 2 {
        return None;
    }
    Some(Lift {
        home: levels.iter().position(|level| level.name == *home).unwrap_or_default(),
        levels,
        rides: lift.rides.iter().filter_map(|ride| new_edges.get(ride).copied()).collect(),
        ..lift.clone()
    })
}

impl fmt::Display for LeftOut {
    /// Writes what is left out, and the reason: `` stations `S7`, `S8` and 2 other nodes, to which
    /// no way leads from the main part``.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { cut_off, stations, other_nodes } = self;
        if !stations.is_empty() {
            let names = stations.iter().take(MOST_NAMES);
            let names: Vec<String> = names.map(|name| format!("`{}`", shorten(name))).collect();
            let noun = if stations.len() == 1 { "station" } else { "stations" };
            write!(f, "{noun} {}", names.join(", "))?;
            if let Some(more @ 1..) = stations.len().checked_sub(MOST_NAMES) {
                write!(f, " (and {more} more)")?;
            }
        }
        match (stations.is_empty(), other_nodes.len()) {
            (false, 0) => {}
            (false, others) => write!(f, " and {}", plural(others, "other node"))?,
            (true, others @ ..=MOST_NAMES) => {
                let names = other_nodes.iter().map(|name| format!("`{}`", shorten(name)));
                let noun = if others == 1 { "node" } else { "nodes" };
                write!(f, "{noun} {}", names.collect::<Vec<_>>().join(", "))?;
            }
            (true, others) => f.write_str(&plural(others, "node"))?,
        }
        f.write_str(match cut_off {
            Some(CutOff::CannotBeLeft) => ", from which no way leads back",
            Some(CutOff::CannotBeReached) => ", to which no way leads from the main part",
            Some(CutOff::Apart) => ", which no way joins with the main part",
            None => ", which no node serves",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::options::ReadOptions;
    use crate::parse;

    fn main_part(text: &str) -> Option<MainPart> {
        let (graph, _) = parse(text, "plant.csv", &ReadOptions::default()).expect("a graph");
        MainPart::of(&graph)
    }

    #[test]
    fn doors_and_lifts_of_the_main_part_stay() {
        let plant = "Edges:
- {Id: 9, Origin_ID: 9, Destination_ID: 1, CurveType: Linear, VelocityForward: 1}
- {Id: 1, Origin_ID: 1, Destination_ID: 2, CurveType: Linear, VelocityForward: 1}
- {Id: 2, Origin_ID: 2, Destination_ID: 1, CurveType: Linear, VelocityForward: 1}
- {Id: 3, Origin_ID: 2, Destination_ID: 3, CurveType: Linear, VelocityForward: 1}
- {Id: 4, Origin_ID: 3, Destination_ID: 2, CurveType: Linear, VelocityForward: 1}
Vertices:
- {Id: 9, X: -4, Y: 0, Theta: 0, Level: low}
- {Id: 1, X: 0, Y: 0, Theta: 0, Level: low}
- {Id: 2, X: 4, Y: 0, Theta: 0, Level: low}
- {Id: 3, X: 4, Y: 1, Theta: 0, Level: high}
- {Id: 4, X: 4, Y: 2, Theta: 0, Level: top}
Doors:
- {Name: way in, Edges: [9], OpeningSeconds: 3}
- {Name: hall, Edges: [1, 2, 9], OpeningSeconds: 60}
Lifts:
- {Name: L, Nodes: [2, 3, 4], SecondsPerLevel: 40, Home: high}
";
        let (graph, _) = parse(plant, "plant.yaml", &ReadOptions::default()).expect("a graph");
        let MainPart { graph, .. } = MainPart::of(&graph).expect("a part");
        let [door] = graph.doors() else { panic!("{:?}", graph.doors()) };
        assert_eq!((&*door.name, door.times.opening_secs), ("hall", 60.0));
        let ids: Vec<u32> = door.edges.iter().map(|edge| graph.edge(*edge).id).collect();
        assert_eq!(ids, [1, 2]);
        let [lift] = graph.lifts() else { panic!("{:?}", graph.lifts()) };
        assert_eq!((lift.levels.len(), lift.home, lift.level_secs), (2, 1, 40.0));
        let ids: Vec<u32> = lift.rides.iter().map(|edge| graph.edge(*edge).id).collect();
        assert_eq!(ids, [3, 4]);
        assert_eq!(graph.zones().len(), 1, "the robots of the lift");
    }

    #[test]
    fn what_cannot_take_part_is_left_out_by_name_and_reason() {
        let text = "id,x,y,role\nA,0,0,pick\nB,10,0,drop\nS7,20,0,drop\nS8,0,9,drop\nX,30,0,\n\
                    I,50,0,pick\nJ,60,0,drop\n\nfrom,to\nA,B\nB,A\nB,S7\nS8,A\nX,B\nI,J\nJ,I\n";
        let MainPart { graph, left_out, cut_off } = main_part(text).expect("a part");
        let names: Vec<_> = graph.nodes().iter().filter_map(Node::name).collect();
        assert_eq!((names, graph.edges().len()), (vec!["A", "B"], 2));
        let said: Vec<String> = left_out.iter().map(ToString::to_string).collect();
        assert_eq!(
            said,
            [
                "station `S7`, from which no way leads back",
                "station `S8` and 1 other node, to which no way leads from the main part",
                "stations `I`, `J`, which no way joins with the main part",
            ]
        );
        let of_nodes: Vec<CutOff> = cut_off.into_values().collect();
        let (left, reached, apart) = (CutOff::CannotBeLeft, CutOff::CannotBeReached, CutOff::Apart);
        assert_eq!(of_nodes, [left, reached, reached, apart, apart]);
    }

    #[test]
    fn a_station_without_a_node_is_left_out_by_name() {
        let text = "id,x,y\nA,0,0\nB,9,0\n\nfrom,to\nA,B\nB,A\n";
        let (graph, _) = parse(text, "plant.csv", &ReadOptions::default()).expect("a graph");
        let ghost = Station { name: "Ghost".into(), ..Station::default() };
        let graph = graph.with_surroundings(vec![ghost], Vec::new());
        let said: Vec<String> = MainPart::of(&graph)
            .expect("a part")
            .left_out
            .iter()
            .map(ToString::to_string)
            .collect();
        assert_eq!(said, ["station `Ghost`, which no node serves"]);
    }

    #[test]
    fn the_part_with_the_stations_is_the_main_one_however_small() {
        let roads = "A,B\nB,A\nC,D\nD,E\nE,C\n";
        let ids = |roles: [&str; 2]| {
            let [a, b] = roles;
            format!("id,x,y,role\nA,0,0,{a}\nB,9,0,{b}\nC,0,5,\nD,9,5,\nE,5,9,\n\nfrom,to\n{roads}")
        };
        for (roles, nodes) in [(["pick", "drop"], 2), (["", ""], 3), (["transfer", "transfer"], 2)]
        {
            let part = main_part(&ids(roles)).expect("a part");
            assert_eq!(part.graph.nodes().len(), nodes, "{roles:?}");
        }
    }

    #[test]
    fn the_part_with_the_wanted_nodes_is_taken() {
        let text = "id,x,y,role\nA,0,0,pick\nB,9,0,drop\nC,0,5,\nD,9,5,\n\nfrom,to\nA,B\nB,A\n\
                    C,D\nD,C\n";
        let (graph, _) = parse(text, "plant.csv", &ReadOptions::default()).expect("a graph");
        for (wanted, first) in [(vec![], "A"), (vec![0, 2], "A"), (vec![2], "C")] {
            let wanted: Vec<NodeIndex> = wanted.into_iter().map(NodeIndex).collect();
            let part = MainPart::around(&graph, &wanted).expect("a part");
            assert_eq!(part.graph.nodes()[0].name(), Some(first), "{wanted:?}");
        }
    }

    #[test]
    fn a_layout_without_a_way_back_has_no_part() {
        assert!(main_part("id,x,y\nA,0,0\nB,10,0\n\nfrom,to\nA,B\n").is_none());
    }
}
