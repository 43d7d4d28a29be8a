//! Tracks: the edges between two neighbouring nodes of the main part, and whether two robots can
//! pass each other on them.

use regatta_base::cores;
use regatta_base::graph::EdgeIndex;
use regatta_base::rows::Rows;
use regatta_base::sweep::{Footprint, Outlines};

use super::conflicts::{Sweeps, is_straight};
use super::network::Network;
use super::robot::RobotType;

/// The ways in which a track can be driven.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TrackKind {
    /// Not at all: all of its legs are slower than a [crawl](regatta_base::graph::CRAWL).
    Closed,
    /// In one direction only.
    OneWay,
    /// In both directions, but two robots can't pass each other on it.
    Single,
    /// In both directions: one robot can stand on an edge while the other drives all of another
    /// edge past it.
    Double,
}

/// All edges between two different nodes of the main part.
#[derive(Clone, Debug, PartialEq)]
pub struct Track {
    /// The node with the smaller index.
    pub low: u32,
    /// The node with the larger index.
    pub high: u32,
    /// The edges, in ascending order.
    pub edges: Vec<u32>,
    /// The length of the shortest edge, in metres.
    pub metres: f64,
    /// The ways in which it can be driven.
    pub kind: TrackKind,
}

/// All tracks of the main part.
#[derive(Debug)]
pub struct Tracks {
    /// In ascending order of their nodes.
    pub all: Vec<Track>,
    /// By node: the numbers of the tracks that end there and aren't closed.
    by_node: Rows<u32>,
}

impl Track {
    /// The node at the other end.
    pub fn other_end(&self, node: u32) -> u32 {
        if node == self.low { self.high } else { self.low }
    }
}

impl Tracks {
    /// Joins the edges between the same nodes to tracks.
    pub fn new(network: &Network<'_>, sweeps: &Sweeps, robot: &RobotType) -> Self {
        let mut edges: Vec<(u32, u32, u32)> = Vec::new();
        for (index, edge) in (0..).zip(network.graph.edges()) {
            let (a, b) = (edge.origin.0, edge.destination.0);
            if a != b && network.is_main(a) && network.is_main(b) {
                edges.push((a.min(b), a.max(b), index));
            }
        }
        edges.sort_unstable();
        let between: Vec<&[(u32, u32, u32)]> =
            edges.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)).collect();
        let footprint = robot.footprint();
        let all = cores::map(between.len(), |index| {
            let (low, high, _) = between[index][0];
            let edges = between[index].iter().map(|(_, _, edge)| *edge).collect();
            track(network, sweeps, &footprint, low, high, edges)
        });
        let open = (0..).zip(&all).filter(|(_, track)| track.kind != TrackKind::Closed);
        let ends = open
            .flat_map(|(index, track): (u32, &Track)| [(track.low, index), (track.high, index)]);
        let by_node = Rows::new(network.nodes() as usize, ends.collect());
        Self { all, by_node }
    }

    /// The numbers of the tracks that end at a node; closed ones don't count.
    pub fn at(&self, node: u32) -> &[u32] {
        self.by_node.row(node)
    }

    /// The track with a number.
    pub fn get(&self, number: u32) -> &Track {
        &self.all[number as usize]
    }

    /// The nodes that tracks join with a node.
    pub fn neighbours(&self, node: u32) -> impl Iterator<Item = u32> + '_ {
        self.at(node).iter().map(move |&track| self.get(track).other_end(node))
    }
}

fn track(
    network: &Network<'_>,
    sweeps: &Sweeps,
    footprint: &Footprint,
    low: u32,
    high: u32,
    edges: Vec<u32>,
) -> Track {
    let mut up = Vec::new();
    let mut down = Vec::new();
    let legs = edges.iter().flat_map(|&edge| network.legs_of(edge));
    for leg in legs.filter(|&leg| network.is_way(leg)) {
        if network.start(leg) == low { up.push(leg.edge.0) } else { down.push(leg.edge.0) }
    }
    let kind = match (up.is_empty(), down.is_empty()) {
        (false, false) if is_double(network, sweeps, footprint, &up, &down) => TrackKind::Double,
        (false, false) => TrackKind::Single,
        (true, true) => TrackKind::Closed,
        _ => TrackKind::OneWay,
    };
    let lengths = edges.iter().map(|&edge| network.graph.edge(EdgeIndex(edge)).path.length());
    Track { low, high, metres: lengths.fold(f64::INFINITY, f64::min), edges, kind }
}

/// Whether an edge of the one direction and another edge of the other direction let two robots
/// pass.
fn is_double(
    network: &Network<'_>,
    sweeps: &Sweeps,
    footprint: &Footprint,
    up: &[u32],
    down: &[u32],
) -> bool {
    up.iter().any(|a| {
        // Straight edges between two nodes are the same line.
        let mut others =
            down.iter().filter(|&b| a != b && !(is_line(network, *a) && is_line(network, *b)));
        others.any(|&b| {
            let [a, b] = [*a, b].map(|edge| sweeps.outlines(edge, footprint));
            has_room_beside(&a, &b) || has_room_beside(&b, &a)
        })
    })
}

fn is_line(network: &Network<'_>, edge: u32) -> bool {
    is_straight(&network.graph.edge(EdgeIndex(edge)).path)
}

/// Whether a robot can stand somewhere on an edge without touching any robot on another one.
fn has_room_beside(edge: &Outlines<'_>, other: &Outlines<'_>) -> bool {
    let others = other.rectangles();
    let count = edge.rectangles().len();
    edge.rectangles().iter().enumerate().any(|(place, rectangle)| {
        // The place across the road touches first, if any does: it is tried before the others.
        let across = (count - 1 - place) * others.len() / count;
        let (near, far) = others.split_at(across);
        !far.iter().chain(near.iter().rev()).any(|other| rectangle.touches(other))
    })
}
