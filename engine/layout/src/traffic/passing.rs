//! Passing places: junctions where two robots can pass each other.

use std::collections::VecDeque;

use super::conflicts::Conflicts;
use super::network::{Network, Search};
use super::tracks::{TrackKind, Tracks};

/// The largest number of nodes around a junction that are searched.
pub const MOST_NODES: usize = 16;
/// The fewest tracks that meet at a junction.
const FEWEST_TRACKS: usize = 3;

/// A search for passing places.
#[derive(Clone, Copy, Debug)]
pub struct Passing<'a> {
    /// The legs.
    pub network: &'a Network<'a>,
    /// The roads that standing robots block.
    pub conflicts: &'a Conflicts,
    /// The tracks.
    pub tracks: &'a Tracks,
}

impl Passing<'_> {
    /// Whether two robots can pass each other at a node: a double track ends there, or it is a
    /// junction of three tracks or more on whose [surroundings](Self::surroundings) two robots,
    /// with no others around, can exchange their places.
    pub fn is_passing_place(&self, node: u32) -> bool {
        let tracks = self.tracks.at(node);
        if tracks.iter().any(|&track| self.tracks.get(track).kind == TrackKind::Double) {
            return true;
        }
        tracks.len() >= FEWEST_TRACKS && self.can_exchange(&self.surroundings(node))
    }

    /// Returns a junction and the nodes around it, nearest first by number of tracks: on each road
    /// up to the first node where a standing robot blocks no edge that meets the junction, other
    /// than edges between both. At most [`MOST_NODES`].
    pub fn surroundings(&self, junction: u32) -> Vec<u32> {
        let mut nodes = vec![junction];
        let mut next = 0;
        while let Some(&node) = nodes.get(next) {
            next += 1;
            if node != junction && self.is_clear(node, junction) {
                continue;
            }
            for neighbour in self.tracks.neighbours(node) {
                if nodes.len() < MOST_NODES && !nodes.contains(&neighbour) {
                    nodes.push(neighbour);
                }
            }
        }
        nodes
    }

    /// Whether a robot at a node blocks no edge that meets a junction, other than edges between
    /// both.
    fn is_clear(&self, node: u32, junction: u32) -> bool {
        let touched = self.conflicts.touched(node);
        let mut tracks = self.tracks.at(junction).iter().map(|&track| self.tracks.get(track));
        !tracks.any(|track| track.edges.iter().any(|edge| touched.binary_search(edge).is_ok()))
    }

    /// Whether two robots that stay on some nodes can exchange their places, from any two of them.
    pub fn can_exchange(&self, nodes: &[u32]) -> bool {
        let pairs = Pairs::new(self, nodes);
        let count = nodes.len();
        let mut starts = (0..count).flat_map(|a| (a + 1..count).map(move |b| Pair { a, b }));
        starts.any(|start| pairs.is_possible(start) && pairs.leads(start, start.swapped()))
    }
}

/// The places of two robots, by the position of their nodes in a list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Pair {
    a: usize,
    b: usize,
}

impl Pair {
    fn swapped(self) -> Self {
        Self { a: self.b, b: self.a }
    }
}

/// The states of two robots on some nodes.
struct Pairs<'a> {
    conflicts: &'a Conflicts,
    nodes: &'a [u32],
    /// By node of the list: the legs to other nodes of the list, with their positions.
    moves: Vec<Vec<(regatta_base::graph::Leg, usize)>>,
}

impl<'a> Pairs<'a> {
    fn new(passing: &Passing<'a>, nodes: &'a [u32]) -> Self {
        let mut moves = Vec::with_capacity(nodes.len());
        for &node in nodes {
            let ways = passing.network.steps(node, Search::Forwards);
            let inside = ways.filter_map(|(leg, end)| {
                Some((leg, nodes.iter().position(|&other| other == end && other != node)?))
            });
            moves.push(inside.collect());
        }
        Self { conflicts: passing.conflicts, nodes, moves }
    }

    fn is_possible(&self, Pair { a, b }: Pair) -> bool {
        !self.conflicts.is_touching(self.nodes[a], self.nodes[b])
    }

    /// Whether a sequence of moves leads from a state to another one.
    fn leads(&self, from: Pair, to: Pair) -> bool {
        let count = self.nodes.len();
        let mut reached = vec![false; count * count];
        let mut open = VecDeque::from([from]);
        reached[from.a * count + from.b] = true;
        while let Some(state) = open.pop_front() {
            if state == to {
                return true;
            }
            for next in self.next(state) {
                if !std::mem::replace(&mut reached[next.a * count + next.b], true) {
                    open.push_back(next);
                }
            }
        }
        false
    }

    fn next(&self, state: Pair) -> impl Iterator<Item = Pair> + '_ {
        let first = self.ends(state.a, state.b).map(move |a| Pair { a, ..state });
        first.chain(self.ends(state.b, state.a).map(move |b| Pair { b, ..state }))
    }

    /// The nodes to which a robot can move past another one.
    fn ends(&self, robot: usize, other: usize) -> impl Iterator<Item = usize> + '_ {
        let moves = self.moves[robot].iter();
        let by = self.nodes[other];
        moves.filter(move |(leg, _)| !self.conflicts.is_blocked(*leg, by)).map(|(_, end)| *end)
    }
}
