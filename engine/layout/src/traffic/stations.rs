//! Stations where a standing robot blocks a through road.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use regatta_base::graph::NodeIndex;

use super::conflicts::Conflicts;
use super::network::{Network, Search};
use crate::model::route_graph::RouteGraph;
use crate::model::tags::Role;

/// The largest number of steps of the search for other ways: a leg looked at is one.
const MOST_STEPS: u64 = 100_000_000;

/// The names of the stations at each node that robots work at, in ascending order of nodes: a node
/// with a role, or a node of a station.
pub type StationNames = BTreeMap<u32, Vec<String>>;

/// The effect of a robot that stands at a station on those that drive elsewhere.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effect {
    /// No way leads any more from the first node to the second one, which are of the main part.
    CutsOff(NodeIndex, NodeIndex),
    /// Others have to take another way.
    Detour,
    /// It wasn't found out whether there is another way: the search took too long.
    Unknown,
}

/// A node with stations where a standing robot blocks a through road.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BlockingStation {
    /// The node.
    pub node: NodeIndex,
    /// The names of its stations; none if the node has only a role.
    pub names: Vec<String>,
    /// The effect of a standing robot.
    pub effect: Effect,
}

/// Returns the names of all stations by node.
pub fn station_names(graph: &RouteGraph) -> StationNames {
    let mut names = StationNames::new();
    for (index, node) in (0..).zip(graph.nodes()) {
        if node.role != Role::None {
            names.entry(index).or_default();
        }
    }
    for station in graph.stations() {
        for node in &station.nodes {
            names.entry(node.0).or_default().push(station.name.clone());
        }
    }
    names
}

/// Finds the stations of the main part where a standing robot blocks a through road, in ascending
/// order of their nodes.
///
/// A road leads through a node if a robot that enters it by one edge can leave it to another node
/// than it came from; a robot may also block roads that only pass by. It cuts nodes off if, while
/// it stands there, some node of the main part can't be reached any more from another one. Nodes
/// where others would touch it don't count.
pub fn blocking_stations(
    network: &Network<'_>,
    conflicts: &Conflicts,
    names: &StationNames,
) -> Vec<BlockingStation> {
    let mut detours = Detours { network, conflicts, steps: 0 };
    let nodes = names.iter().filter(|(node, _)| network.is_main(**node));
    let found = nodes.filter_map(|(&node, names)| {
        let effect = detours.effect(node)?;
        Some(BlockingStation { node: NodeIndex(node), names: names.clone(), effect })
    });
    found.collect()
}

/// The search for ways around standing robots.
struct Detours<'a> {
    network: &'a Network<'a>,
    conflicts: &'a Conflicts,
    steps: u64,
}

/// Whether a way exists.
enum Way {
    Exists,
    Missing,
    Unknown,
}

impl Detours<'_> {
    /// Returns the effect of a robot at a node; `None` if it blocks no through road.
    fn effect(&mut self, node: u32) -> Option<Effect> {
        let mut effect = None;
        for (from, to) in self.through_roads(node) {
            match self.way(node, from, to) {
                Way::Exists => effect = effect.or(Some(Effect::Detour)),
                Way::Missing => return Some(Effect::CutsOff(NodeIndex(from), NodeIndex(to))),
                Way::Unknown => effect = Some(Effect::Unknown),
            }
        }
        effect
    }

    /// Returns the ends of the roads that a robot at a station blocks: different free nodes that
    /// are joined by a blocked leg, or by way of the station and nodes where others would touch it.
    fn through_roads(&self, station: u32) -> BTreeSet<(u32, u32)> {
        let mut roads = BTreeSet::new();
        for leg in self.conflicts.blocked(station).filter(|&leg| self.network.is_way(leg)) {
            let from = self.network.start(leg);
            if self.is_free(station, from) {
                let ends = self.ends(station, self.network.end(leg));
                roads.extend(ends.into_iter().filter(|to| *to != from).map(|to| (from, to)));
            }
        }
        roads
    }

    /// Returns the free nodes that robots come to from a node if nodes that aren't free count as
    /// through roads: the node itself if it is free.
    fn ends(&self, station: u32, node: u32) -> BTreeSet<u32> {
        let (mut seen, mut open) = (BTreeSet::from([node]), vec![node]);
        while let Some(node) = open.pop() {
            if self.is_free(station, node) {
                continue;
            }
            for (_, next) in self.network.steps(node, Search::Forwards) {
                if self.network.is_main(next) && seen.insert(next) {
                    open.push(next);
                }
            }
        }
        seen.retain(|&node| self.is_free(station, node));
        seen
    }

    /// Whether a node of the main part stays usable while a robot stands at a station.
    fn is_free(&self, station: u32, node: u32) -> bool {
        node != station && self.network.is_main(node) && !self.conflicts.is_touching(station, node)
    }

    /// Looks for a way between two nodes, from both of them by turns.
    fn way(&mut self, station: u32, from: u32, to: u32) -> Way {
        let mut ahead = Front::new(from, Search::Forwards);
        let mut back = Front::new(to, Search::Backwards);
        while self.steps < MOST_STEPS {
            let way = self.advance(station, &mut ahead, &back);
            if let Some(way) = way.or_else(|| self.advance(station, &mut back, &ahead)) {
                return way;
            }
        }
        Way::Unknown
    }

    /// Follows the legs of the next node of one side. Returns whether there is a way, if that is
    /// known then.
    fn advance(&mut self, station: u32, front: &mut Front, other: &Front) -> Option<Way> {
        let Some(node) = front.open.pop_front() else { return Some(Way::Missing) };
        for (leg, next) in self.network.steps(node, front.search) {
            self.steps += 1;
            if !self.is_free(station, next) || self.conflicts.is_blocked(leg, station) {
                continue;
            }
            if other.seen.contains(&next) {
                return Some(Way::Exists);
            }
            if front.seen.insert(next) {
                front.open.push_back(next);
            }
        }
        None
    }
}

/// One side of a search from two sides.
struct Front {
    search: Search,
    seen: BTreeSet<u32>,
    open: VecDeque<u32>,
}

impl Front {
    fn new(from: u32, search: Search) -> Self {
        Self { search, seen: BTreeSet::from([from]), open: VecDeque::from([from]) }
    }
}
