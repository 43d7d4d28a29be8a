//! Legs as pieces: cubic polynomials in arc length, which is all that moving a robot needs.
//!
//! A piece tells where a robot is from the distance `w` that it still has to the piece's end. Position, heading and
//! pace come from one polynomial; `w` moves on by speed × time. Against the exact curve, evaluated in `f32`:
//! position within 1 mm, heading within 0.1°, |p'(w)| within 0.1 % of 1.

use glam::{DVec2, Vec2};
use rayon::prelude::*;

use super::bezier::Side;
use super::fit;
use super::stretch::Fitted;
use super::{Edge, EdgeIndex, Gear, Leg, Node, NodeIndex, RouteGraph};

/// Radians. A curve whose end is this near to its node's heading was meant to have it: the rest is rounding.
const SAME_HEADING: f64 = 1e-5;

/// Edges from which on more threads than one are worth waking.
const WORTH_THREADS: usize = 512;

/// A distance in fixed point, in units of 2⁻²⁷ m (7.45 nm): sums of steps are exact, in any order, on any machine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(transparent)]
pub struct Distance(pub i32);

impl Distance {
    /// Units a metre.
    pub const PER_METRE: f64 = (1u32 << 27) as f64;

    /// The nearest distance that can be told; saturates at ±16 m.
    pub fn from_metres(metres: f64) -> Self {
        Self((metres * Self::PER_METRE).round_ties_even() as i32)
    }

    /// In metres, exactly.
    pub fn to_metres(self) -> f64 {
        f64::from(self.0) / Self::PER_METRE
    }
}

/// A stretch of a leg: x(w) = x₀ + w (x₁ + w (x₂ + w x₃)), and y alike, with `w` in [-length, 0] the distance from
/// the END of the piece in metres. So at w = 0 the position is exactly (x₀, y₀) and the derivative (x₁, y₁).
///
/// w grows in the driving direction. In reverse gear the robot faces against it: its heading is the direction of
/// minus the derivative.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(32))]
pub struct Piece {
    /// Coefficients of x, in m, 1, 1/m, 1/m².
    pub x: [f32; 4],
    /// Coefficients of y.
    pub y: [f32; 4],
}

impl Piece {
    /// Position in metres at `w` in [-length, 0] metres.
    pub fn position(&self, w: f32) -> Vec2 {
        let value = |c: [f32; 4]| c[0] + w * (c[1] + w * (c[2] + w * c[3]));
        Vec2::new(value(self.x), value(self.y))
    }

    /// The derivative at `w` in [-length, 0] metres: its direction is the driving direction, its length within
    /// 0.1 % of 1.
    pub fn derivative(&self, w: f32) -> Vec2 {
        let value = |c: [f32; 4]| c[1] + w * (2.0 * c[2] + w * (3.0 * c[3]));
        Vec2::new(value(self.x), value(self.y))
    }

    /// A place to stand at, facing `tangent`; only for w = 0.
    fn standing(position: DVec2, tangent: DVec2) -> Self {
        let coefficients = |at: f64, towards: f64| [at as f32, towards as f32, 0.0, 0.0];
        Self { x: coefficients(position.x, tangent.x), y: coefficients(position.y, tangent.y) }
    }
}

/// What a hand-over needs to know of a piece, and a step doesn't.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PieceInfo {
    /// How long it is: at most 8 m (and less than a micrometre); at least one unit, but 0 for a place to stand at.
    pub length: Distance,
    /// Metres along the edge from its ORIGIN at w = 0. Along a piece it is `s_end + w` in forward gear and
    /// `s_end - w` in reverse.
    pub s_end: f32,
}

/// A leg: consecutive rows of [`Tracks::pieces`], in driving order.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Track {
    /// Row of its first piece.
    pub first_piece: u32,
    /// Number of pieces; at least 1.
    pub pieces: u32,
    /// Metres: the sum of the pieces' lengths, exactly.
    pub length: f64,
}

impl Track {
    /// Row of its last piece.
    pub fn last_piece(&self) -> u32 {
        self.first_piece + self.pieces - 1
    }
}

/// Every leg of a route graph as pieces, and a place to stand at for every node.
#[derive(Clone, Debug, Default)]
pub struct Tracks {
    pieces: Vec<Piece>,
    infos: Vec<PieceInfo>,
    forward: Vec<Track>,
    reverse: Vec<Option<Track>>,
    first_node_piece: u32,
}

impl Tracks {
    /// Fits pieces to every leg; if they are many, on all threads of the current rayon pool, with the same result on any number.
    ///
    /// # Panics
    /// If the pieces are 2³¹ or more, 64 GiB of them.
    pub fn compile(graph: &RouteGraph) -> Self {
        let fit = |edge: &Edge| fit::fit(&edge.curve, end_tangents(graph, edge));
        let edges = graph.edges();
        let fitted: Vec<Fitted> = match edges.len() {
            0..WORTH_THREADS => edges.iter().map(fit).collect(),
            _ => edges.par_iter().map(fit).collect(),
        };
        let mut tracks = Self::default();
        for (edge, fitted) in edges.iter().zip(&fitted) {
            let forward = tracks.push(fitted.forward());
            let reverse = edge.velocity_backwards.map(|_| tracks.push(fitted.reverse()));
            tracks.forward.push(forward);
            tracks.reverse.push(reverse);
        }
        tracks.first_node_piece = tracks.next_row();
        tracks.pieces.extend(graph.nodes().iter().map(standing));
        tracks.infos.resize(tracks.pieces.len(), PieceInfo::default());
        assert!(tracks.pieces.len() < 1 << 31, "a row number needs its top bit for the gear");
        tracks
    }

    /// All pieces. Those of a track are consecutive.
    pub fn pieces(&self) -> &[Piece] {
        &self.pieces
    }

    /// What belongs to each piece, by the same row.
    pub fn infos(&self) -> &[PieceInfo] {
        &self.infos
    }

    /// The track of a leg; `None` if the edge can't be driven in that gear.
    pub fn track(&self, leg: Leg) -> Option<&Track> {
        match leg.gear {
            Gear::Forward => self.forward.get(leg.edge.0 as usize),
            Gear::Reverse => self.reverse.get(leg.edge.0 as usize)?.as_ref(),
        }
    }

    /// Arc length of an edge in metres.
    pub fn edge_length(&self, edge: EdgeIndex) -> f64 {
        self.forward[edge.0 as usize].length
    }

    /// Row of the piece that stands on a node; only for w = 0.
    pub fn node_piece(&self, node: NodeIndex) -> u32 {
        self.first_node_piece + node.0
    }

    fn push(&mut self, pieces: impl Iterator<Item = (Piece, PieceInfo)>) -> Track {
        let first_piece = self.next_row();
        let mut length = 0.0;
        for (piece, info) in pieces {
            length += info.length.to_metres();
            self.pieces.push(piece);
            self.infos.push(info);
        }
        Track { first_piece, pieces: self.next_row() - first_piece, length }
    }

    fn next_row(&self) -> u32 {
        self.pieces.len() as u32
    }
}

fn standing(node: &Node) -> Piece {
    Piece::standing(node.position, DVec2::from_angle(node.theta))
}

/// Unit tangents at the ends of an edge: the nodes' own headings, to the bit, where the curve has them.
fn end_tangents(graph: &RouteGraph, edge: &Edge) -> [DVec2; 2] {
    [(0.0, Side::After, edge.origin), (1.0, Side::Before, edge.destination)].map(|(lambda, side, node)| {
        let tangent = edge.curve.tangent(lambda, side);
        let heading = DVec2::from_angle(graph.node(node).theta);
        if heading.distance(tangent) < SAME_HEADING { heading } else { tangent }
    })
}
