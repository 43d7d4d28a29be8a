//! Conflicts on the roads: spots where robots are, and passages along which they drive.

use crate::roads::{Leg, Relation, Roads};

/// A robot's place in a layer: at the end of a leg, or within one, behind others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Spot(pub usize);

/// A motion: along a leg, along the rest of the leg that the robot is on, or a turn on the spot at
/// a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Passage(pub usize);

/// The spots and passages of some roads.
#[derive(Debug)]
pub(super) struct Space {
    legs: usize,
    nodes: usize,
    /// By spot: the passages that a robot there blocks.
    blocked: Vec<Vec<u32>>,
    /// By passage: the spots that block it.
    blocking: Vec<Vec<u32>>,
    /// By edge: the edges on which robots may touch those on it, itself included.
    near: Vec<Vec<u32>>,
    /// By node: the nodes that one edge joins with it, and itself.
    neighbours: Vec<Vec<u32>>,
}

impl Space {
    pub(super) fn new(roads: &Roads) -> Self {
        let (legs, nodes) = (2 * roads.edges().len(), roads.nodes() as usize);
        let mut space = Self {
            legs,
            nodes,
            blocked: vec![Vec::new(); 2 * legs],
            blocking: Vec::new(),
            near: (0..roads.edges().len() as u32).map(|edge| near(roads, edge)).collect(),
            neighbours: neighbours(roads),
        };
        for index in 0..legs as u32 {
            let leg = Leg::from_index(index);
            let [end, inside] = [space.end(leg).0, space.inside(leg).0];
            space.blocked[end] = space.blocked_at_end(roads, leg);
            let both = [leg, Leg::new(leg.edge(), !leg.is_reverse())];
            space.blocked[inside] = both.map(|leg| leg.index() as u32).to_vec();
        }
        space.blocking = vec![Vec::new(); 2 * legs + nodes];
        for (spot, passages) in (0..).zip(&space.blocked) {
            for &passage in passages {
                space.blocking[passage as usize].push(spot);
            }
        }
        space
    }

    pub(super) fn end(&self, leg: Leg) -> Spot {
        Spot(leg.index())
    }

    pub(super) fn inside(&self, leg: Leg) -> Spot {
        Spot(self.legs + leg.index())
    }

    pub(super) fn whole(&self, leg: Leg) -> Passage {
        Passage(leg.index())
    }

    pub(super) fn rest(&self, leg: Leg) -> Passage {
        Passage(self.legs + leg.index())
    }

    pub(super) fn turn(&self, node: u32) -> Passage {
        Passage(2 * self.legs + node as usize)
    }

    pub(super) fn spots(&self) -> usize {
        2 * self.legs
    }

    pub(super) fn passages(&self) -> usize {
        2 * self.legs + self.nodes
    }

    pub(super) fn nodes(&self) -> usize {
        self.nodes
    }

    /// The passages that a robot at a spot blocks.
    pub(super) fn blocked_by(&self, spot: Spot) -> &[u32] {
        &self.blocked[spot.0]
    }

    /// The spots that block a passage.
    pub(super) fn blocking(&self, passage: Passage) -> &[u32] {
        &self.blocking[passage.0]
    }

    /// The edges on which robots may touch those on an edge, itself included.
    pub(super) fn near(&self, edge: u32) -> &[u32] {
        &self.near[edge as usize]
    }

    /// A node, and the nodes that one edge joins with it.
    pub(super) fn neighbours(&self, node: u32) -> &[u32] {
        &self.neighbours[node as usize]
    }

    fn blocked_at_end(&self, roads: &Roads, leg: Leg) -> Vec<u32> {
        let mut passages = Vec::new();
        for track in touched(roads, leg) {
            if track as usize >= roads.edges().len() {
                passages.push(self.turn(track - roads.edges().len() as u32).0 as u32);
                continue;
            }
            for leg in [Leg::new(track, false), Leg::new(track, true)] {
                passages.extend([self.whole(leg), self.rest(leg)].map(|passage| passage.0 as u32));
            }
        }
        passages
    }
}

/// Returns the tracks where robots may touch one that stands at the end of a leg.
fn touched(roads: &Roads, leg: Leg) -> Vec<u32> {
    let length = roads.edge(leg.edge()).length;
    let place = if leg.is_reverse() { 0.0 } else { length };
    let mut tracks = vec![leg.edge()];
    for (track, relation) in roads.conflicts().of_any(leg.edge()) {
        let touches = match relation {
            Relation::Crossing { own, .. } => own.contains(place),
            Relation::Into(apart) => length - place < apart,
            Relation::From(apart) => place < apart,
        };
        if touches {
            tracks.push(track);
        }
    }
    tracks.sort_unstable();
    tracks.dedup();
    tracks
}

fn near(roads: &Roads, edge: u32) -> Vec<u32> {
    let mut near = roads.conflicts().near(&[edge]);
    near.retain(|track| (*track as usize) < roads.edges().len());
    near
}

fn neighbours(roads: &Roads) -> Vec<Vec<u32>> {
    let mut neighbours: Vec<Vec<u32>> = (0..roads.nodes()).map(|node| vec![node]).collect();
    for edge in roads.edges() {
        neighbours[edge.origin as usize].push(edge.destination);
        neighbours[edge.destination as usize].push(edge.origin);
    }
    for nodes in &mut neighbours {
        nodes.sort_unstable();
        nodes.dedup();
    }
    neighbours
}
