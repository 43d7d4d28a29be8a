//! Spans of a curve, each of which becomes one piece in either gear.

use glam::DVec2;
use regatta_motion::{Distance, Piece, PieceInfo};

/// A point of the curve where a span starts or ends.
#[derive(Clone, Copy, Debug)]
pub(super) struct Knot {
    /// Metres.
    pub(super) position: DVec2,
    /// A unit vector.
    pub(super) tangent: DVec2,
}

impl Knot {
    /// Returns the knot as seen when driving in the other direction.
    fn reversed(self) -> Self {
        Self { tangent: -self.tangent, ..self }
    }
}

/// The part of a curve between two knots.
#[derive(Clone, Copy, Debug)]
pub(super) struct CurveSpan {
    pub(super) from: Knot,
    pub(super) to: Knot,
    /// Units of [`Distance`] from the edge's origin.
    pub(super) start: i64,
    pub(super) end: i64,
    /// Whether the span is too short for its curvature to be resolved, so that it becomes a
    /// straight line.
    pub(super) is_straight: bool,
}

impl CurveSpan {
    /// Returns the pieces of a curve's spans from P0 to P3.
    pub(super) fn forward_pieces(spans: &[Self]) -> impl Iterator<Item = (Piece, PieceInfo)> {
        spans.iter().map(|span| span.piece(span.from, span.to, span.end))
    }

    /// Returns the pieces of a curve's spans from P3 to P0.
    pub(super) fn reverse_pieces(spans: &[Self]) -> impl Iterator<Item = (Piece, PieceInfo)> {
        spans
            .iter()
            .rev()
            .map(|span| span.piece(span.to.reversed(), span.from.reversed(), span.start))
    }

    fn piece(&self, from: Knot, to: Knot, s_end: i64) -> (Piece, PieceInfo) {
        let length = Distance((self.end - self.start) as i32);
        let polynomial = match self.is_straight {
            true => Polynomial([to.position, to.tangent, DVec2::ZERO, DVec2::ZERO]),
            false => Polynomial::hermite(from, to, length.to_metres()),
        };
        (
            polynomial.to_piece(),
            PieceInfo { length, s_end: (s_end as f64 / Distance::PER_METRE) as f32 },
        )
    }
}

/// A piece in `f64`: the coefficients of the powers of w.
pub(super) struct Polynomial([DVec2; 4]);

impl Polynomial {
    /// Returns the cubic that has the positions and tangents of two knots at w = -length and w = 0.
    pub(super) fn hermite(from: Knot, to: Knot, length: f64) -> Self {
        let mean = (to.position - from.position) / length;
        let bend = from.tangent + to.tangent - mean * 2.0;
        Self([
            to.position,
            to.tangent,
            (bend + to.tangent - mean) / length,
            bend / (length * length),
        ])
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
