//! Single-track sections: maximal stretches between passing places where two robots can't pass
//! each other.

use regatta_base::cores;
use regatta_base::graph::{EdgeIndex, NodeIndex};
use regatta_base::sweep::MARGIN;

use super::conflicts::Conflicts;
use super::network::{Network, Search};
use super::passing::{MOST_NODES, Passing};
use super::robot::RobotType;
use super::room::{Certainty, Count, most_standing};
use super::tracks::{TrackKind, Tracks};

/// The shape of a section's tracks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// One after the other.
    Path,
    /// With branches, but without a ring.
    Tree,
    /// With a ring.
    Ring,
}

/// Whether two robots that stay on a section can exchange their places.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exchange {
    /// No two robots can.
    Never,
    /// From some places at least.
    Possible,
    /// It wasn't searched.
    Unknown,
}

/// A single-track section.
#[derive(Clone, Debug, PartialEq)]
pub struct Section {
    /// Its nodes, in ascending order, its ends among them.
    pub nodes: Vec<NodeIndex>,
    /// Its edges, in ascending order.
    pub edges: Vec<EdgeIndex>,
    /// Its nodes where other roads meet it, in ascending order: passing places, or nodes from which
    /// one-way or double tracks lead on.
    pub ends: Vec<NodeIndex>,
    /// Its nodes from which only the way back leads on.
    pub dead_ends: Vec<NodeIndex>,
    /// The shape of its tracks.
    pub shape: Shape,
    /// Whether two robots can exchange their places on it, if it has no ends: it is known of a
    /// path, and searched on sections of at most 16 nodes.
    pub exchange: Exchange,
    /// The length of all of its tracks, in metres.
    pub metres: f64,
    /// The length of the way along its tracks from one end to the other, in metres; `None` if it
    /// hasn't two ends, or has a ring.
    pub between_ends: Option<f64>,
    /// The largest number of robots that stand at its nodes, other than its ends, without touching
    /// each other. A bound if a zone is there, which may allow fewer.
    pub at_nodes: Count,
    /// The number of robots that stand behind each other, wherever they stop, on one track as long
    /// as all of its tracks, with its ends left free: the robots of a path.
    pub in_line: u32,
}

/// The kind of a section.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SectionKind {
    /// It leads from end to end.
    Through,
    /// It has one end and no ring: robots come out where they went in.
    DeadEnd,
    /// It has one end and a ring: robots may come out by the other side of the ring.
    Loop,
    /// It has no end and no ring: it is the whole main part.
    Whole,
    /// The same with a ring.
    Ring,
}

impl Section {
    /// The kind.
    pub fn kind(&self) -> SectionKind {
        match (self.ends.len(), self.shape) {
            (0, Shape::Ring) => SectionKind::Ring,
            (0, _) => SectionKind::Whole,
            (1, Shape::Ring) => SectionKind::Loop,
            (1, _) => SectionKind::DeadEnd,
            _ => SectionKind::Through,
        }
    }

    /// Whether no robot has room in it between its ends.
    pub fn is_without_room(&self) -> bool {
        self.at_nodes.robots == 0 && self.in_line == 0
    }
}

/// Finds all sections of the main part, in the order of their first tracks.
pub fn sections(
    network: &Network<'_>,
    conflicts: &Conflicts,
    tracks: &Tracks,
    robot: &RobotType,
) -> Vec<Section> {
    let passing = Passing { network, conflicts, tracks };
    let is_passing = cores::map(network.nodes() as usize, |node| {
        single_tracks(tracks, node as u32).nth(1).is_some() && passing.is_passing_place(node as u32)
    });
    let zoned = zoned(network);
    let mut sections = Vec::new();
    let mut is_done = vec![false; tracks.all.len()];
    for first in 0..tracks.all.len() as u32 {
        if tracks.get(first).kind == TrackKind::Single && !is_done[first as usize] {
            let found = connected(tracks, &is_passing, first, &mut is_done);
            sections.push(section(&passing, &zoned, robot, &found));
        }
    }
    sections
}

fn single_tracks(tracks: &Tracks, node: u32) -> impl Iterator<Item = u32> + '_ {
    let at = tracks.at(node).iter().copied();
    at.filter(|&track| tracks.get(track).kind == TrackKind::Single)
}

/// Returns a single track and all that are joined with it by nodes that are no passing places.
fn connected(tracks: &Tracks, is_passing: &[bool], first: u32, is_done: &mut [bool]) -> Vec<u32> {
    is_done[first as usize] = true;
    let mut found = vec![first];
    let mut next = 0;
    while let Some(&track) = found.get(next) {
        next += 1;
        let track = tracks.get(track);
        for node in [track.low, track.high] {
            if is_passing[node as usize] {
                continue;
            }
            for other in single_tracks(tracks, node) {
                if !std::mem::replace(&mut is_done[other as usize], true) {
                    found.push(other);
                }
            }
        }
    }
    found.sort_unstable();
    found
}

/// Returns by node whether a zone includes it, or an edge that starts or ends there.
fn zoned(network: &Network<'_>) -> Vec<bool> {
    let mut zoned = vec![false; network.nodes() as usize];
    for zone in network.graph.zones() {
        let edges = zone.edges.iter().map(|&edge| network.graph.edge(edge));
        let ends = edges.flat_map(|edge| [edge.origin, edge.destination]);
        for node in ends.chain(zone.nodes.iter().copied()) {
            zoned[node.0 as usize] = true;
        }
    }
    zoned
}

fn section(passing: &Passing<'_>, zoned: &[bool], robot: &RobotType, found: &[u32]) -> Section {
    let Passing { network, conflicts, tracks } = *passing;
    let mut nodes: Vec<u32> = Vec::new();
    let mut edges: Vec<u32> = Vec::new();
    let mut metres = 0.0;
    for track in found.iter().map(|&track| tracks.get(track)) {
        nodes.extend([track.low, track.high]);
        edges.extend(&track.edges);
        metres += track.metres;
    }
    for list in [&mut nodes, &mut edges] {
        list.sort_unstable();
        list.dedup();
    }
    let (ends, inside): (Vec<u32>, Vec<u32>) =
        nodes.iter().partition(|node| is_end(network, tracks, found, **node));
    let dead_ends = inside.iter().copied().filter(|&node| tracks.at(node).len() == 1);
    let shape = shape(tracks, found, nodes.len());
    let mut at_nodes = most_standing(conflicts, &inside);
    if inside.iter().any(|&node| zoned[node as usize]) {
        at_nodes.certainty = Certainty::Bound;
    }
    Section {
        dead_ends: dead_ends.map(NodeIndex).collect(),
        shape,
        exchange: exchange(passing, shape, &nodes, &ends),
        at_nodes,
        in_line: in_line(metres, ends.len(), robot).max(robots_at(at_nodes)),
        between_ends: between_ends(tracks, found, shape, &ends),
        nodes: nodes.into_iter().map(NodeIndex).collect(),
        edges: edges.into_iter().map(EdgeIndex).collect(),
        ends: ends.into_iter().map(NodeIndex).collect(),
        metres,
    }
}

/// The length of the way along some tracks without a ring from one of two ends to the other.
fn between_ends(tracks: &Tracks, found: &[u32], shape: Shape, ends: &[u32]) -> Option<f64> {
    let &[start, goal] = ends else { return None };
    if shape == Shape::Ring {
        return None;
    }
    let mut open = vec![(start, u32::MAX, 0.0)];
    while let Some((node, before, metres)) = open.pop() {
        if node == goal {
            return Some(metres);
        }
        let at = tracks.at(node).iter().copied();
        for track in at.filter(|&track| track != before && found.binary_search(&track).is_ok()) {
            let next = tracks.get(track);
            open.push((next.other_end(node), track, metres + next.metres));
        }
    }
    None
}

/// The shape of some tracks that are joined, with so many nodes.
fn shape(tracks: &Tracks, found: &[u32], nodes: usize) -> Shape {
    let mut ends: Vec<u32> = Vec::with_capacity(2 * found.len());
    for track in found.iter().map(|&track| tracks.get(track)) {
        ends.extend([track.low, track.high]);
    }
    ends.sort_unstable();
    let has_branch = ends.chunk_by(|a, b| a == b).any(|tracks| tracks.len() > 2);
    match (found.len() < nodes, has_branch) {
        (true, false) => Shape::Path,
        (true, true) => Shape::Tree,
        (false, _) => Shape::Ring,
    }
}

fn exchange(passing: &Passing<'_>, shape: Shape, nodes: &[u32], ends: &[u32]) -> Exchange {
    match shape {
        _ if !ends.is_empty() => Exchange::Unknown,
        Shape::Path => Exchange::Never,
        Shape::Tree | Shape::Ring if nodes.len() > MOST_NODES => Exchange::Unknown,
        _ if passing.can_exchange(nodes) => Exchange::Possible,
        _ => Exchange::Never,
    }
}

/// Whether other roads than some tracks meet a node.
fn is_end(network: &Network<'_>, tracks: &Tracks, found: &[u32], node: u32) -> bool {
    let has_loop = network.steps(node, Search::Forwards).any(|(_, end)| end == node);
    has_loop || tracks.at(node).iter().any(|track| found.binary_search(track).is_err())
}

/// The number of robots that stand at nodes for sure.
fn robots_at(nodes: Count) -> u32 {
    if nodes.certainty == Certainty::Exact { nodes.robots } else { 0 }
}

/// The number of robots behind each other on so many metres, with the ends left free.
fn in_line(metres: f64, ends: usize, robot: &RobotType) -> u32 {
    let lengths = (metres / (robot.length() + 2.0 * f64::from(MARGIN))).floor() as i64;
    (lengths + 1 - ends.min(2) as i64).max(0) as u32
}
