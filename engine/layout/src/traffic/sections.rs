//! Single-track sections: maximal stretches between passing places where two robots can't pass
//! each other.

use regatta_base::cores;
use regatta_base::graph::{EdgeIndex, NodeIndex};
use regatta_base::sweep::MARGIN;

use super::conflicts::Conflicts;
use super::network::Network;
use super::passing::Passing;
use super::robot::RobotType;
use super::room::{Count, most_standing};
use super::tracks::{TrackKind, Tracks};

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
    /// The length of its tracks, in metres.
    pub metres: f64,
    /// The largest number of robots that stand at its nodes, other than its ends, without touching
    /// each other.
    pub at_nodes: Count,
    /// The number of robots that stand in it behind each other, wherever they stop, with its ends
    /// left free. It counts along the tracks, whatever their shape.
    pub in_line: u32,
}

/// The kind of a section.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SectionKind {
    /// It leads from end to end.
    Through,
    /// It has one end: robots come out where they went in.
    DeadEnd,
    /// It has no end: it is a plant of its own.
    Whole,
}

impl Section {
    /// The kind.
    pub fn kind(&self) -> SectionKind {
        match self.ends.len() {
            0 => SectionKind::Whole,
            1 => SectionKind::DeadEnd,
            _ => SectionKind::Through,
        }
    }
}

/// Finds all sections, in the order of their first tracks.
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
    let mut sections = Vec::new();
    let mut is_done = vec![false; tracks.all.len()];
    for first in 0..tracks.all.len() as u32 {
        if tracks.get(first).kind == TrackKind::Single && !is_done[first as usize] {
            let found = connected(tracks, &is_passing, first, &mut is_done);
            sections.push(section(network, conflicts, tracks, robot, &found));
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

fn section(
    network: &Network<'_>,
    conflicts: &Conflicts,
    tracks: &Tracks,
    robot: &RobotType,
    found: &[u32],
) -> Section {
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
    Section {
        dead_ends: dead_ends.map(NodeIndex).collect(),
        at_nodes: most_standing(conflicts, &inside),
        in_line: in_line(metres, ends.len(), robot),
        nodes: nodes.into_iter().map(NodeIndex).collect(),
        edges: edges.into_iter().map(EdgeIndex).collect(),
        ends: ends.into_iter().map(NodeIndex).collect(),
        metres,
    }
}

/// Whether other roads than some tracks meet a node.
fn is_end(network: &Network<'_>, tracks: &Tracks, found: &[u32], node: u32) -> bool {
    let has_loop = network.departures(node).iter().any(|&leg| network.end(leg) == node);
    has_loop || tracks.at(node).iter().any(|track| found.binary_search(track).is_err())
}

/// The number of robots behind each other on so many metres, with the ends left free.
fn in_line(metres: f64, ends: usize, robot: &RobotType) -> u32 {
    let lengths = (metres / (robot.length() + 2.0 * f64::from(MARGIN))).floor() as i64;
    (lengths + 1 - ends.min(2) as i64).max(0) as u32
}
