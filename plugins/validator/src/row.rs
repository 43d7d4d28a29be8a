//! A robot in a frame, and its move since the frame before.

use glam::Vec2;
use regatta_plugin::frame::{NO_EDGE, RobotState};
use regatta_plugin::world::RobotTypeRecord;

use crate::findings::Kind;
use crate::world_model::WorldModel;

/// One robot's values of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Row {
    pub position: Vec2,
    pub theta: f32,
    pub speed: f32,
    pub s: f32,
    pub edge: u32,
    pub state: RobotState,
}

impl Row {
    /// Whether all values are numbers of a plausible size.
    pub fn is_valid(&self) -> bool {
        self.position.abs().cmple(Vec2::splat(1e7)).all()
            && self.theta.abs() <= 1e3
            && self.speed.is_finite()
            && (self.edge == NO_EDGE || self.s.is_finite())
    }

    pub fn is_absent(&self) -> bool {
        self.state == RobotState::Absent
    }

    /// The distance to a point, in metres.
    pub fn distance_to(&self, point: Vec2) -> f64 {
        (point.as_dvec2() - self.position.as_dvec2()).length()
    }
}

/// The time between two frames.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Gap {
    /// Seconds of simulated time.
    pub seconds: f64,
    /// Seconds of one tick.
    pub period: f64,
}

/// The move of a robot from one frame to the next.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Move<'a> {
    pub world: &'a WorldModel,
    pub robot_type: &'a RobotTypeRecord,
    pub before: &'a Row,
    pub now: &'a Row,
    pub gap: Gap,
}

/// A fault of a robot in a frame: its kind, the measured and the allowed value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Fault {
    pub kind: Kind,
    pub value: f64,
    pub limit: f64,
}

/// Wraps an angle into (-π, π].
pub(crate) fn wrap(angle: f64) -> f64 {
    use std::f64::consts::{PI, TAU};
    // Most angles are there already, and a remainder takes longer than most rules.
    if angle.abs() < PI {
        return angle;
    }
    let wrapped = angle.rem_euclid(TAU);
    if wrapped > PI { wrapped - TAU } else { wrapped }
}
