//! The pieces of a graph: of every leg, and one of every node.

use regatta_base::graph::{EdgeIndex, Gear, Leg, NodeIndex};

use super::piece::{Piece, PieceInfo};

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

/// The pieces of every leg of a graph, and one piece for every node.
#[derive(Clone, Debug, Default)]
pub struct Tracks {
    pieces: Vec<Piece>,
    infos: Vec<PieceInfo>,
    forward: Vec<Track>,
    reverse: Vec<Option<Track>>,
    first_node_piece: u32,
}

impl Tracks {
    /// Adds the pieces of the next edge, in driving order: those of its forward leg, and of its
    /// reverse leg if the edge may be driven in reverse gear. All edges come before the nodes.
    pub fn push_edge<F, R>(&mut self, forward: F, reverse: Option<R>)
    where
        F: IntoIterator<Item = (Piece, PieceInfo)>,
        R: IntoIterator<Item = (Piece, PieceInfo)>,
    {
        let forward = self.push(forward);
        let reverse = reverse.map(|pieces| self.push(pieces));
        self.forward.push(forward);
        self.reverse.push(reverse);
        self.first_node_piece = self.next_row();
    }

    /// Adds the pieces of all nodes, on which robots stand.
    ///
    /// # Panics
    /// If there are 2³¹ pieces or more, which would take 64 GiB.
    pub fn push_nodes(&mut self, pieces: impl IntoIterator<Item = Piece>) {
        self.pieces.extend(pieces);
        self.infos.resize(self.pieces.len(), PieceInfo::default());
        assert!(
            self.pieces.len() < 1 << 31,
            "the top bit of a row number is reserved for the gear"
        );
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

    fn push(&mut self, pieces: impl IntoIterator<Item = (Piece, PieceInfo)>) -> Track {
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
