//! A piece: a cubic polynomial in arc length, and the fixed-point distance that positions along it
//! are kept in.

use glam::{DVec2, Vec2};

/// A distance in fixed point, in units of 2⁻²⁷ m (7.45 nm). Sums are exact, in any order and on any
/// machine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(transparent)]
pub struct Distance(pub i32);

impl Distance {
    /// The number of units per metre.
    pub const PER_METRE: f64 = (1u32 << 27) as f64;

    /// Returns the nearest representable distance; saturates at ±16 m.
    pub fn from_metres(metres: f64) -> Self {
        Self((metres * Self::PER_METRE).round_ties_even() as i32)
    }

    /// Converts to metres, exactly.
    pub fn to_metres(self) -> f64 {
        f64::from(self.0) / Self::PER_METRE
    }
}

/// A section of a leg as a cubic polynomial: x(w) = x₀ + w (x₁ + w (x₂ + w x₃)), and y(w) likewise.
///
/// `w` in [-length, 0] is the distance in metres from the END of the piece, so that at w = 0 the
/// position is exactly (x₀, y₀) and the derivative exactly (x₁, y₁). `w` grows in the direction of
/// travel. In reverse gear the robot faces against that direction: its heading is the direction of
/// minus the derivative.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(32))]
pub struct Piece {
    /// The coefficients of x, in m, 1, 1/m, 1/m².
    pub x: [f32; 4],
    /// The coefficients of y, in the same units.
    pub y: [f32; 4],
}

impl Piece {
    /// Returns the position in metres at `w` in [-length, 0] metres.
    pub fn position(&self, w: f32) -> Vec2 {
        let value = |c: [f32; 4]| c[0] + w * (c[1] + w * (c[2] + w * c[3]));
        Vec2::new(value(self.x), value(self.y))
    }

    /// Returns the derivative at `w` in [-length, 0] metres: a vector in the direction of travel
    /// whose length is within 0.1 % of 1.
    pub fn derivative(&self, w: f32) -> Vec2 {
        let value = |c: [f32; 4]| c[1] + w * (2.0 * c[2] + w * (3.0 * c[3]));
        Vec2::new(value(self.x), value(self.y))
    }

    /// Returns the piece of a robot that stands on a node, facing along `tangent`; valid at w = 0
    /// only.
    pub fn stationary(position: DVec2, tangent: DVec2) -> Self {
        let coefficients =
            |position: f64, tangent: f64| [position as f32, tangent as f32, 0.0, 0.0];
        Self { x: coefficients(position.x, tangent.x), y: coefficients(position.y, tangent.y) }
    }
}

/// The data of a piece that only the transition to the next piece needs, not every step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PieceInfo {
    /// The length of the piece: at least one unit and at most 8 m (plus less than a micrometre), or
    /// 0 for the piece of a node.
    pub length: Distance,
    /// Metres along the edge from its ORIGIN at w = 0. Elsewhere on the piece it is `s_end + w` in
    /// forward gear and `s_end - w` in reverse gear.
    pub s_end: f32,
}
