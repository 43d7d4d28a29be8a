//! A piece: a cubic polynomial in arc length. Positions along it are distances in fixed point, and
//! a tick is a step of such distances.

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
        Vec2::new(value(&self.x, w), value(&self.y, w))
    }

    /// Returns the derivative at `w` in [-length, 0] metres: a vector in the direction of travel
    /// whose length is within 0.1 % of 1.
    pub fn derivative(&self, w: f32) -> Vec2 {
        Vec2::new(slope(&self.x, w), slope(&self.y, w))
    }

    /// Returns the piece of a robot that stands on a node, facing along `tangent`; valid at w = 0
    /// only.
    pub fn stationary(position: DVec2, tangent: DVec2) -> Self {
        let (position, tangent) = (position.as_vec2(), tangent.as_vec2());
        Self { x: [position.x, tangent.x, 0.0, 0.0], y: [position.y, tangent.y, 0.0, 0.0] }
    }
}

/// Returns the value of a polynomial.
///
/// The vector kernels do the same operations in the same order.
#[inline]
pub(super) fn value(c: &[f32; 4], w: f32) -> f32 {
    c[0] + w * (c[1] + w * (c[2] + w * c[3]))
}

/// Returns the derivative of a polynomial.
///
/// The vector kernels do the same operations in the same order.
#[inline]
pub(super) fn slope(c: &[f32; 4], w: f32) -> f32 {
    c[1] + w * ((c[2] + c[2]) + w * (3.0 * c[3]))
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

/// The length of a tick, in the forms that the stages use.
#[derive(Clone, Copy, Debug)]
pub struct TimeStep {
    /// Seconds per tick.
    pub(super) seconds: f32,
    /// Units of [`Distance`] that a robot drives in a tick at 1 m/s.
    pub(super) units: f32,
}

impl TimeStep {
    /// Makes the time step of that many seconds.
    pub fn new(seconds: f64) -> Self {
        Self { seconds: seconds as f32, units: (seconds * Distance::PER_METRE) as f32 }
    }

    /// Returns the units that a robot drives in a tick in which its speed changes evenly.
    #[inline]
    pub(super) fn distance(self, before: f32, now: f32) -> i32 {
        ((before + now) * (0.5 * self.units)).round_ties_even() as i32
    }
}
