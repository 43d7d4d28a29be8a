//! A curve cut into stretches, each of which becomes a piece in both gears.

use glam::DVec2;

use super::arc_length::{Distance, Piece, PieceInfo};

/// A point of the curve that a piece starts or ends at.
#[derive(Clone, Copy, Debug)]
pub(super) struct Joint {
    /// Metres.
    pub(super) position: DVec2,
    /// A unit vector.
    pub(super) tangent: DVec2,
}

impl Joint {
    /// Facing the other way: for driving in the other direction.
    fn turned(self) -> Self {
        Self { tangent: -self.tangent, ..self }
    }
}

/// A piece to be: between two points of the curve.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stretch {
    pub(super) from: Joint,
    pub(super) to: Joint,
    /// Units of [`Distance`] from the edge's origin.
    pub(super) start: i64,
    pub(super) end: i64,
    /// Too short to tell its turn: straight.
    pub(super) is_tip: bool,
}

/// A curve cut into stretches, from which the pieces of both gears are made.
#[derive(Clone, Debug)]
pub(super) struct Fitted(pub(super) Vec<Stretch>);

impl Fitted {
    /// Pieces from P0 to P3.
    pub(super) fn forward(&self) -> impl Iterator<Item = (Piece, PieceInfo)> {
        self.0.iter().map(|stretch| stretch.piece(stretch.from, stretch.to, stretch.end))
    }

    /// Pieces from P3 to P0.
    pub(super) fn reverse(&self) -> impl Iterator<Item = (Piece, PieceInfo)> {
        self.0.iter().rev().map(|stretch| stretch.piece(stretch.to.turned(), stretch.from.turned(), stretch.start))
    }
}

impl Stretch {
    fn piece(&self, from: Joint, to: Joint, s_end: i64) -> (Piece, PieceInfo) {
        let length = Distance((self.end - self.start) as i32);
        let polynomial = match self.is_tip {
            true => Polynomial([to.position, to.tangent, DVec2::ZERO, DVec2::ZERO]),
            false => Polynomial::hermite(from, to, length.to_metres()),
        };
        (polynomial.to_piece(), PieceInfo { length, s_end: (s_end as f64 / Distance::PER_METRE) as f32 })
    }
}

/// A piece in `f64`: coefficients of the powers of w.
pub(super) struct Polynomial([DVec2; 4]);

impl Polynomial {
    /// The cubic with these positions and derivatives at w = -length and w = 0.
    pub(super) fn hermite(from: Joint, to: Joint, length: f64) -> Self {
        let mean = (to.position - from.position) / length;
        let bend = from.tangent + to.tangent - mean * 2.0;
        Self([to.position, to.tangent, (bend + to.tangent - mean) / length, bend / (length * length)])
    }

    pub(super) fn position(&self, w: f64) -> DVec2 {
        self.0[0] + (self.0[1] + (self.0[2] + self.0[3] * w) * w) * w
    }

    pub(super) fn derivative(&self, w: f64) -> DVec2 {
        self.0[1] + (self.0[2] * 2.0 + self.0[3] * (3.0 * w)) * w
    }

    fn to_piece(&self) -> Piece {
        Piece { x: self.0.map(|c| c.x as f32), y: self.0.map(|c| c.y as f32) }
    }
}
