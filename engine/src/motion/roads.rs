//! A route graph as hand-overs need it: what comes after a piece, and which edges leave a node.

use std::sync::Arc;

use super::REVERSE;
use crate::fleet::Route;
use crate::graph::arc_length::{Piece, Tracks};
use crate::graph::{EdgeIndex, Gear, Leg, NodeIndex, RouteGraph};

/// A leg.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lane {
    /// Row of its first piece, with [`REVERSE`] set in reverse gear.
    pub first_piece: u32,
    /// Commanded speed in metres per second; 0 where the leg can't be driven.
    pub speed: f32,
    /// Metres.
    pub length: f64,
    /// The node it leads to.
    pub end: NodeIndex,
}

/// A piece.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stretch {
    /// In units of [`Distance`](crate::graph::arc_length::Distance).
    pub length: i32,
    /// Metres along the edge from its origin to the end of this piece.
    pub s_end: f32,
    /// Metres from the end of this piece to the end of its leg; 0 for the last.
    pub rest: f32,
}

/// A place on a route, to look ahead from.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Onward {
    pub robot: u32,
    pub route: Route,
    /// The node that the next leg leaves.
    pub node: NodeIndex,
    /// The leg that leads there.
    pub leg: Option<Leg>,
}

/// The route graph, for hand-overs.
#[derive(Debug)]
pub(crate) struct Roads {
    graph: Arc<RouteGraph>,
    tracks: Arc<Tracks>,
    stretches: Vec<Stretch>,
    /// By edge and gear.
    lanes: Vec<Lane>,
    /// Edges that start at a node: `exits[exits_start[n]..exits_start[n + 1]]`.
    exits: Vec<EdgeIndex>,
    exits_start: Vec<u32>,
    /// By edge: place among its destination's exits of the edge that leads straight back, or `u32::MAX`.
    back: Vec<u32>,
}

impl Roads {
    pub(crate) fn new(graph: Arc<RouteGraph>, tracks: Arc<Tracks>) -> Self {
        let legs = (0..graph.edges().len() as u32)
            .flat_map(|edge| [Gear::Forward, Gear::Reverse].map(|gear| Leg { edge: EdgeIndex(edge), gear }));
        let lanes = legs.clone().map(|leg| lane(&graph, &tracks, leg)).collect();
        let mut stretches: Vec<Stretch> =
            tracks.infos().iter().map(|info| Stretch { length: info.length.0, s_end: info.s_end, rest: 0.0 }).collect();
        legs.for_each(|leg| fill_rests(&mut stretches, &tracks, leg));
        let (exits, exits_start) = exits(&graph);
        let mut roads = Self { graph, tracks, stretches, lanes, exits, exits_start, back: Vec::new() };
        roads.back =
            roads.graph.edges().iter().map(|edge| roads.straight_back(edge.origin, edge.destination)).collect();
        roads
    }

    pub(crate) fn graph(&self) -> &RouteGraph {
        &self.graph
    }

    pub(crate) fn tracks(&self) -> &Tracks {
        &self.tracks
    }

    pub(crate) fn pieces(&self) -> &[Piece] {
        self.tracks.pieces()
    }

    pub(crate) fn lane(&self, leg: Leg) -> &Lane {
        &self.lanes[2 * leg.edge.0 as usize + usize::from(leg.gear == Gear::Reverse)]
    }

    /// What belongs to a `piece` of the fleet's column.
    pub(super) fn stretch(&self, piece: u32) -> &Stretch {
        &self.stretches[(piece & !REVERSE) as usize]
    }

    /// Metres from the end of a piece to the end of its leg.
    pub(super) fn rest(&self, piece: u32) -> f64 {
        f64::from(self.stretch(piece).rest)
    }

    /// The node that a robot comes to on its leg, or stands on.
    pub(crate) fn node_ahead(&self, leg: Option<Leg>, piece: u32) -> NodeIndex {
        match leg {
            Some(leg) => self.lane(leg).end,
            None => NodeIndex(piece - self.tracks.node_piece(NodeIndex(0))),
        }
    }

    /// The edge that a random walk takes from a node; `None` at a dead end. It doesn't turn straight back if it
    /// has a choice.
    pub(crate) fn wander(&self, node: NodeIndex, leg: Option<Leg>, random: u32) -> Option<EdgeIndex> {
        let exits = self.exits_of(node);
        let back = match leg {
            Some(Leg { edge, gear: Gear::Forward }) if exits.len() > 1 => self.back[edge.0 as usize],
            _ => u32::MAX,
        };
        let choices = exits.len() as u64 - u64::from(back != u32::MAX);
        let choice = (u64::from(random) * choices) >> 32;
        let choice = choice + u64::from(choice >= u64::from(back));
        exits.get(choice as usize).copied()
    }

    fn exits_of(&self, node: NodeIndex) -> &[EdgeIndex] {
        let node = node.0 as usize;
        &self.exits[self.exits_start[node] as usize..self.exits_start[node + 1] as usize]
    }

    fn straight_back(&self, origin: NodeIndex, destination: NodeIndex) -> u32 {
        let leads_back = |&edge: &EdgeIndex| self.graph.edge(edge).destination == origin;
        self.exits_of(destination).iter().position(leads_back).map_or(u32::MAX, |place| place as u32)
    }
}

fn lane(graph: &RouteGraph, tracks: &Tracks, leg: Leg) -> Lane {
    let end = graph.leg_end(leg);
    let reverse = if leg.gear == Gear::Reverse { REVERSE } else { 0 };
    match (tracks.track(leg), graph.leg_velocity(leg)) {
        (Some(track), Some(speed)) => {
            Lane { first_piece: track.first_piece | reverse, speed: speed as f32, length: track.length, end }
        }
        _ => Lane { first_piece: 0, speed: 0.0, length: 0.0, end },
    }
}

fn fill_rests(stretches: &mut [Stretch], tracks: &Tracks, leg: Leg) {
    let Some(track) = tracks.track(leg) else { return };
    let mut rest = 0.0;
    for row in (track.first_piece..=track.last_piece()).rev() {
        stretches[row as usize].rest = rest as f32;
        rest += tracks.infos()[row as usize].length.to_metres();
    }
}

/// Edges by the node that they start at.
fn exits(graph: &RouteGraph) -> (Vec<EdgeIndex>, Vec<u32>) {
    let mut start = vec![0];
    let mut exits = Vec::new();
    for node in 0..graph.nodes().len() as u32 {
        let forward = graph.departures(NodeIndex(node)).iter().filter(|leg| leg.gear == Gear::Forward);
        exits.extend(forward.map(|leg| leg.edge));
        start.push(exits.len() as u32);
    }
    (exits, start)
}
