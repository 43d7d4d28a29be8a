//! Axis-aligned bounding boxes, which quickly show that two robots are far apart.

use glam::Vec2;

use crate::body::Body;

/// An axis-aligned bounding box, in metres: its western and southern side, then its eastern and
/// northern side with the opposite sign. A larger box therefore has smaller numbers on all four
/// sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bounds([f32; 4]);

/// The largest numbers that a box may have on each side to overlap a given box.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OverlapLimit([f32; 4]);

impl Bounds {
    /// The box without any points.
    pub(crate) const NOTHING: Self = Self([f32::MAX; 4]);

    /// Creates the box between its south-western and its north-eastern corner.
    pub(crate) fn new(least: Vec2, most: Vec2) -> Self {
        Self([least.x, least.y, -most.x, -most.y])
    }

    /// Returns the box around a footprint and some metres around it.
    pub(crate) fn of(body: &Body, metres: f32) -> Self {
        let (Vec2 { x, y }, half) = (body.position, body.half_extent(body.heading));
        let (pad_x, pad_y) = (half.x + (metres + slack(x)), half.y + (metres + slack(y)));
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

    /// Returns the smallest box around both.
    pub(crate) fn join(self, other: Self) -> Self {
        let (a, b) = (self.0, other.0);
        Self([0, 1, 2, 3].map(|side| if b[side] < a[side] { b[side] } else { a[side] }))
    }

    pub(crate) fn overlap_limit(&self) -> OverlapLimit {
        let [west, south, east, north] = self.0;
        OverlapLimit([-east, -north, -west, -south])
    }

    /// Whether it has a point in common with the box that has this limit.
    pub(crate) fn overlaps(&self, limit: OverlapLimit) -> bool {
        let (a, limit) = (self.0, limit.0);
        (a[0] <= limit[0]) & (a[1] <= limit[1]) & (a[2] <= limit[2]) & (a[3] <= limit[3])
    }
}

/// Returns the largest rounding error of a coordinate at that distance from the origin, in metres.
pub(crate) fn slack(distance: f32) -> f32 {
    1e-5 + distance.abs() * 1e-6
}
