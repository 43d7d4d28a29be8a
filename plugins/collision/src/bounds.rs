//! Upright boxes, to see quickly who is far from whom.

use crate::body::Body;

/// An upright box, in metres: its western and southern side, and its eastern and northern one with the opposite sign.
/// So a larger box has smaller numbers, all four of them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bounds([f32; 4]);

/// What the numbers of a box may be at most if it is to overlap some other.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reach([f32; 4]);

impl Bounds {
    /// Holds no point.
    pub(crate) const NOTHING: Self = Self([f32::MAX; 4]);

    pub(crate) fn new([west, south]: [f32; 2], [east, north]: [f32; 2]) -> Self {
        Self([west, south, -east, -north])
    }

    /// Around a footprint and some metres more.
    pub(crate) fn of(body: &Body, metres: f32) -> Self {
        let ([x, y], [reach_x, reach_y]) = (body.place, body.half_extent(body.heading));
        let (pad_x, pad_y) = (reach_x + (metres + slack(x)), reach_y + (metres + slack(y)));
        Self([x - pad_x, y - pad_y, -x - pad_x, -y - pad_y])
    }

    pub(crate) fn west(&self) -> f32 {
        self.0[0]
    }

    pub(crate) fn south(&self) -> f32 {
        self.0[1]
    }

    pub(crate) fn east(&self) -> f32 {
        -self.0[2]
    }

    pub(crate) fn north(&self) -> f32 {
        -self.0[3]
    }

    /// The smallest box around both.
    pub(crate) fn join(self, other: Self) -> Self {
        let less = |side: usize| if other.0[side] < self.0[side] { other.0[side] } else { self.0[side] };
        Self([less(0), less(1), less(2), less(3)])
    }

    pub(crate) fn reach(&self) -> Reach {
        let [west, south, east, north] = self.0;
        Reach([-east, -north, -west, -south])
    }

    /// Whether it has a point in common with the box that has this reach.
    pub(crate) fn overlaps(&self, reach: Reach) -> bool {
        let holds = |side: usize| self.0[side] <= reach.0[side];
        holds(0) & holds(1) & holds(2) & holds(3)
    }
}

/// As much as rounding may hide at that distance from the origin, in metres.
pub(crate) fn slack(distance: f32) -> f32 {
    1e-5 + distance.abs() * 1e-6
}
