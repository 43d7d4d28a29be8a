//! A robot in a frame.

use regatta_plugin::frame::{NO_EDGE, RobotState};

/// One robot's values of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Row {
    pub x: f32,
    pub y: f32,
    pub theta: f32,
    pub speed: f32,
    pub s: f32,
    pub edge: u32,
    pub state: RobotState,
}

impl Row {
    /// Whether all values are numbers of a sensible size.
    pub fn is_valid(&self) -> bool {
        let place = [self.x, self.y].iter().all(|value| value.abs() <= 1e7);
        place
            && self.theta.abs() <= 1e3
            && self.speed.is_finite()
            && (self.edge == NO_EDGE || self.s.is_finite())
    }

    pub fn is_absent(&self) -> bool {
        self.state == RobotState::Absent
    }

    /// The distance to another place, in metres.
    pub fn distance_to(&self, [x, y]: [f32; 2]) -> f64 {
        let (dx, dy) = (f64::from(x) - f64::from(self.x), f64::from(y) - f64::from(self.y));
        (dx * dx + dy * dy).sqrt()
    }
}

/// What is wrong with a robot in a frame: the kind, what was measured, and what is allowed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Fault {
    pub kind: crate::findings::Kind,
    pub value: f64,
    pub limit: f64,
}

/// Returns an angle turned by whole turns into (-π, π].
pub(crate) fn wrap(angle: f64) -> f64 {
    // Nearly all are there already, and a remainder takes longer than the rest of most rules.
    if angle.abs() < std::f64::consts::PI {
        return angle;
    }
    let wrapped = angle.rem_euclid(std::f64::consts::TAU);
    if wrapped > std::f64::consts::PI { wrapped - std::f64::consts::TAU } else { wrapped }
}
