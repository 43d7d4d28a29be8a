//! A route graph as hand-overs need it: what comes after a piece, and which edges leave a node.

use std::sync::Arc;

use super::{PIECE, REVERSE};
use crate::fleet::Route;
use crate::graph::arc_length::{Piece, PieceInfo, Tracks};
use crate::graph::{EdgeIndex, Gear, Leg, NodeIndex, RouteGraph};

/// A leg.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lane {
    /// Row of its first piece, with [`REVERSE`] set in reverse gear.
    pub first_piece: u32,
    /// Commanded speed in metres per second; 0 where the leg can't be driven.
    pub speed: f32,
    /// Metres.
    pub length: f32,
    /// The node it leads to.
    pub end: NodeIndex,
}

/// A piece. Hand-overs look up two of these at random, so they are small.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stretch {
    /// In units of [`Distance`](crate::graph::arc_length::Distance), less than 2³¹; bit 31 marks the last of a leg.
    length_and_last: u32,
    /// Metres along the edge from its origin to the end of this piece.
    pub s_end: f32,
}

impl Stretch {
    const LAST: u32 = 1 << 31;

    /// In units of [`Distance`](crate::graph::arc_length::Distance).
    pub fn length(self) -> i32 {
        (self.length_and_last & !Self::LAST) as i32
    }

    /// Whether its leg ends with it.
    pub fn is_last(self) -> bool {
        self.length_and_last & Self::LAST != 0
    }
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
    /// By piece: metres from its end to the end of its leg.
    rests: Vec<f32>,
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
        let (stretches, rests) = stretches(&tracks, legs);
        let (exits, exits_start) = exits(&graph);
        let mut roads = Self { graph, tracks, stretches, rests, lanes, exits, exits_start, back: Vec::new() };
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
    pub(super) fn stretch(&self, piece: u32) -> Stretch {
        self.stretches[(piece & PIECE) as usize]
    }

    /// All pieces, to look up soon.
    pub(super) fn stretches(&self) -> &[Stretch] {
        &self.stretches
    }

    /// Metres from the end of a piece to the end of its leg.
    pub(super) fn rest(&self, piece: u32) -> f32 {
        self.rests[(piece & PIECE) as usize]
    }

    /// Whether a robot at a distance `w` from the end of that piece has come to the end of its leg.
    pub(crate) fn is_at_end(&self, piece: u32, w: i32) -> bool {
        w >= 0 && self.stretch(piece).is_last()
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
            Lane { first_piece: track.first_piece | reverse, speed: speed as f32, length: track.length as f32, end }
        }
        _ => Lane { first_piece: 0, speed: 0.0, length: 0.0, end },
    }
}

/// By piece: its stretch, and metres from its end to the end of its leg.
fn stretches(tracks: &Tracks, legs: impl Iterator<Item = Leg>) -> (Vec<Stretch>, Vec<f32>) {
    let stretch = |info: &PieceInfo| Stretch { length_and_last: info.length.0 as u32, s_end: info.s_end };
    let mut stretches: Vec<_> = tracks.infos().iter().map(stretch).collect();
    let mut rests = vec![0.0; stretches.len()];
    for track in legs.filter_map(|leg| tracks.track(leg)) {
        stretches[track.last_piece() as usize].length_and_last |= Stretch::LAST;
        let mut rest = 0.0;
        for row in (track.first_piece..=track.last_piece()).rev() {
            rests[row as usize] = rest as f32;
            rest += tracks.infos()[row as usize].length.to_metres();
        }
    }
    // Nodes, where robots only stand.
    stretches[tracks.node_piece(NodeIndex(0)) as usize..]
        .iter_mut()
        .for_each(|node| node.length_and_last = Stretch::LAST);
    (stretches, rests)
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
