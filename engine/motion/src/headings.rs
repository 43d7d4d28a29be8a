//! The headings of robots where they aren't simply those of the edges: edges with an orientation,
//! and turns on the spot.
//!
//! Fleets that need it have columns `gain` and `offset`: the heading in a frame is
//! `gain · tangent + offset`, brought to (-π, π], where `tangent` is the angle of the edge's
//! tangent. A robot on an edge that is driven along its tangent has 1 and 0, one at an angle to it
//! 1 and the angle, one with a heading on the map 0 and the heading, and one that turns on the spot
//! 0 and its heading of the moment.

use std::f32::consts::{PI, TAU};

use regatta_base::graph::{EdgeIndex, Ends, Gear, Leg, Rotation, SMOOTH_TURN};

use super::atan2::{BELOW_PI, atan2};
use super::leg_table::LegTable;
use super::pieces::PieceIndex;
use super::scalar::direction;
use crate::piece::Distance;

/// The largest difference in radians between the headings of consecutive legs that robots drive
/// through without a turn: 5°, from which `regatta graph check` warns.
pub(super) const SMOOTH: f32 = SMOOTH_TURN as f32;

/// The part of a turn in radians that may be missing at its end, because of rounding.
pub(super) const NEGLIGIBLE_TURN: f32 = 1e-5;

/// The rule by which the heading of a robot follows from the tangent of its edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeadingRule {
    /// 1 or 0: whether the heading follows the tangent.
    pub gain: f32,
    /// Radians.
    pub offset: f32,
}

impl HeadingRule {
    /// Along the tangent.
    pub const TANGENT: Self = Self { gain: 1.0, offset: 0.0 };

    /// A heading that doesn't depend on the edge, in radians in (-2π, 2π].
    pub fn fixed(heading: f32) -> Self {
        Self { gain: 0.0, offset: wrap(heading) }
    }

    /// At this angle to the tangent, in radians.
    pub fn at_angle(offset: f32) -> Self {
        Self { gain: 1.0, offset }
    }

    /// Returns the heading at a place with that angle of the tangent, in radians in (-π, π].
    ///
    /// The vector kernels do the same operations in the same order.
    pub fn heading(self, tangent: f32) -> f32 {
        wrap(tangent * self.gain + self.offset)
    }
}

/// Returns the equivalent of an angle in (-2π, 2π] that is in (-π, π].
///
/// The vector kernels do the same operations in the same order.
pub(super) fn wrap(angle: f32) -> f32 {
    let below = if PI < angle { angle - TAU } else { angle };
    let above = if below < -BELOW_PI { below + TAU } else { below };
    above.clamp(-BELOW_PI, PI)
}

/// Returns the angle from one heading to another, in radians: in (-π, π] by the shorter way, else
/// in (-2π, 2π).
pub(super) fn turn_between(from: f32, to: f32, rotation: Rotation) -> f32 {
    let shorter = wrap(to - from);
    match rotation {
        Rotation::CounterClockwise if shorter < -NEGLIGIBLE_TURN => shorter + TAU,
        Rotation::Clockwise if shorter > NEGLIGIBLE_TURN => shorter - TAU,
        _ => shorter,
    }
}

/// The heading of robots on an edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EdgeHeading {
    /// The heading along the edge.
    pub rule: HeadingRule,
    /// The way to turn on the spot at its ends.
    pub rotation: Ends<Rotation>,
}

/// The headings of robots on the edges of a graph. They are the same in both gears.
#[derive(Debug)]
pub struct EdgeHeadings {
    /// By edge.
    rules: Vec<HeadingRule>,
    /// By edge: the headings at its ends, as in frames.
    ends: Vec<Ends<f32>>,
    /// By edge: the way to turn at its ends.
    rotations: Vec<Ends<Rotation>>,
}

impl EdgeHeadings {
    /// Computes the headings at the ends of all edges.
    pub fn new(legs: &LegTable, edges: &[EdgeHeading]) -> Self {
        let ends = (0..).zip(edges).map(|(edge, at)| {
            let [origin, destination] = tangents(legs, EdgeIndex(edge));
            Ends { origin: at.rule.heading(origin), destination: at.rule.heading(destination) }
        });
        Self {
            ends: ends.collect(),
            rotations: edges.iter().map(|edge| edge.rotation).collect(),
            rules: edges.iter().map(|edge| edge.rule).collect(),
        }
    }

    pub(super) fn rule(&self, edge: EdgeIndex) -> HeadingRule {
        self.rules[edge.0 as usize]
    }

    /// Returns the heading of a robot at the start of a leg.
    pub(super) fn start(&self, leg: Leg) -> f32 {
        self.ends[leg.edge.0 as usize].start(leg.gear)
    }

    /// Returns the way to turn from one leg to the next; without the former, the robot stands on a
    /// node.
    pub(super) fn rotation(&self, from: Option<Leg>, to: Leg) -> Rotation {
        let at_start = self.rotations[to.edge.0 as usize].start(to.gear);
        let Some(from) = from else { return Rotation::Shorter.and(at_start) };
        self.rotations[from.edge.0 as usize].end(from.gear).and(at_start)
    }

    /// Returns the heading of a robot at the end of a leg.
    pub(super) fn end(&self, leg: Leg) -> f32 {
        self.ends[leg.edge.0 as usize].end(leg.gear)
    }
}

/// Returns the angles of the tangents at the origin and the destination of an edge.
fn tangents(legs: &LegTable, edge: EdgeIndex) -> [f32; 2] {
    let Some(track) = legs.tracks().track(Leg { edge, gear: Gear::Forward }) else {
        return [0.0; 2];
    };
    let length = legs.tracks().infos()[track.first_piece as usize].length;
    let [first, last] =
        [track.first_piece, track.last_piece()].map(|row| legs.piece(row, Gear::Forward));
    [tangent_angle(legs, first, -length.0), tangent_angle(legs, last, 0)]
}

/// Returns the angle of the tangent of a piece in forward gear, as in frames, at `w` units from its
/// end.
pub(super) fn tangent_angle(legs: &LegTable, piece: PieceIndex, w: i32) -> f32 {
    let (x, y) = direction(&legs.pieces()[piece.row()], Distance(w), piece.sign_bit());
    atan2(y, x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_are_brought_to_the_half_open_interval() {
        let cases = [
            (0.0, 0.0),
            (PI, PI),
            (-PI, PI),
            (3.0, 3.0),
            (4.0, 4.0 - TAU),
            (-4.0, TAU - 4.0),
            (TAU, 0.0),
        ];
        for (angle, expected) in cases {
            assert!((wrap(angle) - expected).abs() < 1e-6, "{angle}: {}", wrap(angle));
        }
        for i in -200_000..=200_000 {
            let angle = TAU * (i as f32 / 200_000.0);
            assert!(-PI < wrap(angle) && wrap(angle) <= PI, "{angle}: {}", wrap(angle));
        }
    }

    #[test]
    fn the_shorter_way_is_taken() {
        let shorter = |from, to| turn_between(from, to, Rotation::Shorter);
        assert!((shorter(3.0, -3.0) - (TAU - 6.0)).abs() < 1e-6);
        assert!((shorter(-3.0, 3.0) + (TAU - 6.0)).abs() < 1e-6);
        assert!((shorter(1.0, 0.5) + 0.5).abs() < 1e-6);
    }

    #[test]
    fn a_way_may_be_the_longer_one() {
        assert!((turn_between(1.0, 0.5, Rotation::CounterClockwise) - (TAU - 0.5)).abs() < 1e-6);
        assert!((turn_between(0.5, 1.0, Rotation::Clockwise) + (TAU - 0.5)).abs() < 1e-6);
        assert_eq!(turn_between(1.0, 1.0, Rotation::Clockwise), 0.0);
        assert_eq!(Rotation::Clockwise.and(Rotation::CounterClockwise), Rotation::Shorter);
        assert_eq!(Rotation::Shorter.and(Rotation::Clockwise), Rotation::Clockwise);
    }
}
