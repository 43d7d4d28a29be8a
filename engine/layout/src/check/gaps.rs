//! Ends of roads that nearly meet another node.

use std::collections::{BTreeMap, BTreeSet};

use glam::DVec2;

use super::validate::MIN_LENGTH;
use crate::model::raw::{RawGraph, RawNode};
use crate::model::tags::{Role, Tags};

/// The distance in metres up to which ends that don't meet are joined: 5 cm between numbers that
/// aren't exact.
pub(crate) const MAX_JOINED_GAP: f64 = 0.05 + 1e-6;
/// The distance in metres up to which ends that don't meet are told.
const MAX_TOLD_GAP: f64 = 0.2 + 1e-6;

/// A node at which a road ends, and another node nearby without an edge between them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Gap {
    /// The index of the end.
    pub end: usize,
    /// The index of the other node.
    pub other: usize,
    /// Metres.
    pub distance: f64,
}

/// The nodes that edges join with each node, in either direction, by id.
#[derive(Debug, Default)]
pub(crate) struct Neighbours(BTreeMap<u32, BTreeSet<u32>>);

impl Neighbours {
    pub fn of(raw: &RawGraph) -> Self {
        let mut neighbours = Self::default();
        for edge in &raw.edges {
            let (Some(origin), Some(destination)) = (edge.origin, edge.destination) else {
                continue;
            };
            neighbours.0.entry(origin).or_default().insert(destination);
            neighbours.0.entry(destination).or_default().insert(origin);
        }
        neighbours
    }

    pub fn are_joined(&self, a: u32, b: u32) -> bool {
        self.0.get(&a).is_some_and(|others| others.contains(&b))
    }

    /// Gives the neighbours of a node to another one, which replaces it.
    pub fn replace(&mut self, node: u32, by: u32) {
        let others = self.0.remove(&node).unwrap_or_default();
        for &other in &others {
            let of_other = self.0.entry(other).or_default();
            of_other.remove(&node);
            of_other.insert(by);
        }
        self.0.entry(by).or_default().extend(others);
    }

    /// Returns the nodes with a single neighbour.
    fn dead_ends(&self) -> impl Iterator<Item = u32> + '_ {
        self.0.iter().filter(|(_, others)| others.len() == 1).map(|(id, _)| *id)
    }
}

/// Returns the ids of nodes at which roads end: those that edges only leave, or only reach, and
/// those with a single neighbour.
pub(crate) fn ends(raw: &RawGraph, neighbours: &Neighbours) -> BTreeSet<u32> {
    let (mut left, mut reached) = (BTreeSet::new(), BTreeSet::new());
    for edge in &raw.edges {
        left.extend(edge.origin);
        reached.extend(edge.destination);
        if edge.reverse_speed.is_some_and(|speed| speed > 0.0) {
            left.extend(edge.destination);
            reached.extend(edge.origin);
        }
    }
    left.symmetric_difference(&reached).copied().chain(neighbours.dead_ends()).collect()
}

/// Returns the gaps that are joined, from each end to the nodes of its level, those of an end by
/// distance.
pub(crate) fn gaps(raw: &RawGraph, neighbours: &Neighbours, ends: &BTreeSet<u32>) -> Vec<Gap> {
    let mut found = all_gaps(raw, neighbours, ends);
    found.retain(|gap| gap.distance <= MAX_JOINED_GAP);
    found
}

fn all_gaps(raw: &RawGraph, neighbours: &Neighbours, ends: &BTreeSet<u32>) -> Vec<Gap> {
    let cells = cells(&raw.nodes);
    let mut found = Vec::new();
    for (end, node) in raw.nodes.iter().enumerate() {
        if node.id.is_some_and(|id| ends.contains(&id)) {
            found.extend(gaps_of(end, raw, neighbours, &cells));
        }
    }
    found
}

/// Returns the gaps between ends and the nodes nearest to them, each once, without those between
/// nodes at one place, which have a warning of their own.
pub(crate) fn gaps_to_tell(raw: &RawGraph) -> Vec<Gap> {
    let neighbours = Neighbours::of(raw);
    let ends = ends(raw, &neighbours);
    let mut told = BTreeSet::new();
    let mut found = all_gaps(raw, &neighbours, &ends);
    found.retain(|gap| {
        let is_new = !told.contains(&gap.end) && !told.contains(&gap.other);
        let is_told = is_new && gap.distance >= MIN_LENGTH;
        if is_told {
            told.extend([gap.end, gap.other]);
        }
        is_told
    });
    found
}

/// Returns the reason why two nodes can't be one, if there is one: each has something that the
/// other one would lose.
pub(crate) fn obstacle(raw: &RawGraph, a: &RawNode, b: &RawNode) -> Option<&'static str> {
    let [zone, other_zone] = [a, b].map(|node| node.tags.as_ref()?.zone.as_deref());
    if a.role != Role::None && b.role != Role::None && a.role != b.role {
        return Some("their roles differ");
    }
    if lift_of(raw, a) != lift_of(raw, b) {
        return Some("one of them is in a lift");
    }
    (zone.is_some() && other_zone.is_some() && zone != other_zone).then_some("their zones differ")
}

/// Returns the index of the lift that a node is in.
fn lift_of(raw: &RawGraph, node: &RawNode) -> Option<usize> {
    let id = node.id?;
    raw.lifts.iter().position(|lift| lift.nodes.contains(&id))
}

fn gaps_of(end: usize, raw: &RawGraph, neighbours: &Neighbours, cells: &Cells) -> Vec<Gap> {
    let node = &raw.nodes[end];
    let (Some(id), Some(at)) = (node.id, position(node)) else { return Vec::new() };
    let mut found = Vec::new();
    for other in nearby(at, cells) {
        let node_there = &raw.nodes[other];
        let (Some(other_id), Some(place)) = (node_there.id, position(node_there)) else { continue };
        let distance = place.distance(at);
        let is_gap = other_id != id
            && distance <= MAX_TOLD_GAP
            && level(node_there) == level(node)
            && !neighbours.are_joined(id, other_id);
        if is_gap {
            found.push(Gap { end, other, distance });
        }
    }
    found.sort_by(|a, b| a.distance.total_cmp(&b.distance).then(a.other.cmp(&b.other)));
    found
}

fn level(node: &RawNode) -> Option<&str> {
    node.tags.as_deref().and_then(|Tags { level, .. }| level.as_deref())
}

fn position(node: &RawNode) -> Option<DVec2> {
    node.position().filter(|position| position.is_finite())
}

/// The nodes by squares of [`MAX_TOLD_GAP`].
type Cells = BTreeMap<(i64, i64), Vec<usize>>;

fn cell(position: DVec2) -> (i64, i64) {
    let index = (position / MAX_TOLD_GAP).floor();
    (index.x as i64, index.y as i64)
}

fn cells(nodes: &[RawNode]) -> Cells {
    let mut cells = Cells::new();
    for (index, node) in nodes.iter().enumerate() {
        if let Some(position) = position(node) {
            cells.entry(cell(position)).or_default().push(index);
        }
    }
    cells
}

/// Returns the nodes in the square of a place and in those around it.
fn nearby(at: DVec2, cells: &Cells) -> impl Iterator<Item = usize> + '_ {
    let (x, y) = cell(at);
    let columns = x.saturating_sub(1)..=x.saturating_add(1);
    let squares =
        columns.flat_map(move |x| (y.saturating_sub(1)..=y.saturating_add(1)).map(move |y| (x, y)));
    squares.filter_map(|square| cells.get(&square)).flatten().copied()
}
