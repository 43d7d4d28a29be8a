//! Legs compiled to pieces: cubic polynomials in arc length, which is all that moving a robot
//! needs.
//!
//! A piece gives a robot's pose as a function of `w`, the distance that remains to the end of the
//! piece: position, heading and |p'(w)| come from one polynomial, and `w` advances by speed × time.
//! The pieces, evaluated in `f32`, differ from the exact curve by at most 1 mm in position, 0.1° in
//! heading, and 0.1 % in |p'(w)|, which is 1 for an exact arc-length parametrization.

mod curve_span;
mod fit;
mod piece;
#[cfg(test)]
mod tests;

use glam::DVec2;
use rayon::prelude::*;

use super::route_graph::{Edge, EdgeIndex, Gear, Leg, Node, NodeIndex, RouteGraph};
use curve_span::CurveSpan;
pub use piece::{Distance, Piece, PieceInfo};

/// The largest difference, in radians, between the end tangent of a curve and the heading of its
/// node that is attributed to rounding. The curve then gets the node's heading.
const SAME_HEADING: f64 = 1e-5;

/// The number of edges from which fitting in parallel is faster than on one thread.
const PARALLEL_THRESHOLD: usize = 512;

/// A leg: consecutive rows of [`Tracks::pieces`], in driving order.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Track {
    /// The row of the first piece.
    pub first_piece: u32,
    /// The number of pieces; at least 1.
    pub pieces: u32,
    /// Metres; exactly the sum of the pieces' lengths.
    pub length: f64,
}

impl Track {
    /// Returns the row of the last piece.
    pub fn last_piece(&self) -> u32 {
        self.first_piece + self.pieces - 1
    }
}

/// The pieces of every leg of a route graph, and one piece for every node.
#[derive(Clone, Debug, Default)]
pub struct Tracks {
    pieces: Vec<Piece>,
    infos: Vec<PieceInfo>,
    forward: Vec<Track>,
    reverse: Vec<Option<Track>>,
    first_node_piece: u32,
}

impl Tracks {
    /// The memory in bytes that a piece takes while a graph is compiled, with its share of the
    /// tables of a fleet.
    pub const BYTES_PER_PIECE: u64 = 200;

    /// Returns the smallest number of pieces that [`compile`](Self::compile) can give: no piece is
    /// longer than 8 m. Takes no memory, and a microsecond per edge.
    pub fn least_pieces(graph: &RouteGraph) -> u64 {
        let of = |edge: &Edge| {
            let gears = if edge.velocity_backwards.is_some() { 2 } else { 1 };
            // The length of a line through points of the curve, which is at most the curve's.
            // Saturates.
            let pieces =
                (edge.path.polyline_length(16) / fit::LONGEST_ACCEPTED).ceil().max(1.0) as u64;
            pieces.saturating_mul(gears)
        };
        graph.edges().iter().map(of).fold(graph.nodes().len() as u64, u64::saturating_add)
    }

    /// Fits pieces to every leg. Large graphs are fitted on all threads of the current rayon pool;
    /// the result doesn't depend on their number.
    ///
    /// # Panics
    /// If there are 2³¹ pieces or more, which would take 64 GiB.
    pub fn compile(graph: &RouteGraph) -> Self {
        let fit = |edge: &Edge| fit::fit(&edge.path, end_tangents(graph, edge));
        let edges = graph.edges();
        let fitted: Vec<Vec<CurveSpan>> = match edges.len() {
            0..PARALLEL_THRESHOLD => edges.iter().map(fit).collect(),
            _ => edges.par_iter().map(fit).collect(),
        };
        let mut tracks = Self::default();
        for (edge, spans) in edges.iter().zip(&fitted) {
            let forward = tracks.push(CurveSpan::forward_pieces(spans));
            let reverse =
                edge.velocity_backwards.map(|_| tracks.push(CurveSpan::reverse_pieces(spans)));
            tracks.forward.push(forward);
            tracks.reverse.push(reverse);
        }
        tracks.first_node_piece = tracks.next_row();
        tracks.pieces.extend(graph.nodes().iter().map(node_piece));
        tracks.infos.resize(tracks.pieces.len(), PieceInfo::default());
        assert!(
            tracks.pieces.len() < 1 << 31,
            "the top bit of a row number is reserved for the gear"
        );
        tracks
    }

    /// Returns all pieces. Those of a track are consecutive.
    pub fn pieces(&self) -> &[Piece] {
        &self.pieces
    }

    /// Returns the infos of all pieces, by the same rows.
    pub fn infos(&self) -> &[PieceInfo] {
        &self.infos
    }

    /// Returns the track of a leg; `None` if the edge can't be driven in that gear.
    pub fn track(&self, leg: Leg) -> Option<&Track> {
        match leg.gear {
            Gear::Forward => self.forward.get(leg.edge.0 as usize),
            Gear::Reverse => self.reverse.get(leg.edge.0 as usize)?.as_ref(),
        }
    }

    /// Returns the arc length of an edge in metres.
    pub fn edge_length(&self, edge: EdgeIndex) -> f64 {
        self.forward[edge.0 as usize].length
    }

    /// Returns the row of a node's piece, which is valid at w = 0 only.
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

fn node_piece(node: &Node) -> Piece {
    Piece::stationary(node.position, DVec2::from_angle(node.theta))
}

/// Returns the unit tangents at the ends of an edge: exactly the nodes' headings where the curve
/// has them.
fn end_tangents(graph: &RouteGraph, edge: &Edge) -> [DVec2; 2] {
    let ends =
        [(edge.path.start_tangent(), edge.origin), (edge.path.end_tangent(), edge.destination)];
    ends.map(|(tangent, node)| {
        let heading = DVec2::from_angle(graph.node(node).theta);
        if heading.distance(tangent) < SAME_HEADING { heading } else { tangent }
    })
}
