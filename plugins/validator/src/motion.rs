//! A robot in a frame, its move since the frame before, and the rules of motion: speed,
//! acceleration, turns on the spot, and the distance driven between two frames.

use glam::Vec2;
use regatta_plugin::frame::{NO_EDGE, RobotState};
use regatta_plugin::world::RobotTypeRecord;

use crate::findings::Kind;
use crate::world_model::WorldModel;

/// The tolerance of a driven distance in metres: single precision of poses, and ends of edges that
/// are a little apart.
const DISTANCE_TOLERANCE: f64 = 0.005;
/// The engine's curves are driven up to 0.1 % faster than their arc length says.
const DISTANCE_FACTOR: f64 = 1.002;
/// The tolerance of a speed limit, in metres per second.
const SPEED_TOLERANCE: f64 = 0.001;
/// The factor by which a change of speed may exceed the limit, in addition to [`resolution`].
const ACCELERATION_FACTOR: f64 = 1.01;
/// The tolerance of a turn on the spot, in radians.
const ROTATION_TOLERANCE: f64 = 0.002;

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

/// The change of speed that the resolution of distances (2⁻²⁶ m) causes near a stop: √(2 a 2⁻²⁶ m),
/// and as much for rounding.
fn resolution(acceleration: f64) -> f64 {
    2.0 * (2.0 * acceleration * 2f64.powi(-26)).sqrt() + 1e-5
}

/// Returns the speed limit of a robot type on an edge, in the gear of a speed.
fn speed_limit(world: &WorldModel, robot_type: &RobotTypeRecord, edge: u32, speed: f32) -> f64 {
    let of_edge = world.edge(edge).map_or(world.max_speed, |edge| {
        let record = &edge.record;
        f64::from(if speed < 0.0 { record.reverse_speed } else { record.speed })
    });
    of_edge.min(f64::from(robot_type.max_speed))
}

/// Checks a robot's speed in one frame.
pub(crate) fn check_speed(
    world: &WorldModel,
    robot_type: &RobotTypeRecord,
    now: &Row,
    faults: &mut Vec<Fault>,
) {
    let speed = f64::from(now.speed.abs());
    let limit = speed_limit(world, robot_type, now.edge, now.speed);
    // Without permission for reverse gear there is no limit: that is a wrong direction.
    if speed > limit * 1.0001 + SPEED_TOLERANCE && (now.speed > 0.0 || limit > 0.0) {
        faults.push(Fault { kind: Kind::Speed, value: speed, limit });
    }
}

impl Move<'_> {
    /// The largest distance that the robot can have driven, in metres, with tolerance.
    pub fn reach(&self) -> f64 {
        let max_speed = self.world.max_speed.min(f64::from(self.robot_type.max_speed));
        max_speed * self.gap.seconds * DISTANCE_FACTOR + DISTANCE_TOLERANCE
    }

    /// The largest distance that the robot can have driven along an edge that it hasn't left. A
    /// robot that has just come from a faster edge may be ahead by its braking distance in a tick.
    fn reach_on_edge(&self) -> f64 {
        let Self { world, robot_type, now, gap, .. } = *self;
        let forward = speed_limit(world, robot_type, now.edge, 1.0);
        let backward = speed_limit(world, robot_type, now.edge, -1.0);
        // The use of a reverse gear that isn't allowed is a wrong direction.
        let limit = if now.speed < 0.0 && backward > 0.0 { backward } else { forward };
        let change = f64::from(robot_type.max_acceleration) * gap.period * gap.period;
        let slack = if change.is_finite() { change } else { 0.0 };
        limit * gap.seconds * DISTANCE_FACTOR + slack + DISTANCE_TOLERANCE
    }

    /// Checks all rules of a move. A robot that is farther away than it can have driven has
    /// no route to check.
    pub fn check(&self, faults: &mut Vec<Fault>) {
        self.check_acceleration(faults);
        self.check_rotation(faults);
        self.check_teleport(faults);
        if !faults.iter().any(|fault| fault.kind == Kind::Teleport) {
            self.check_route(faults);
        }
    }

    /// Checks the change of speed.
    fn check_acceleration(&self, faults: &mut Vec<Fault>) {
        let (acceleration, seconds) =
            (f64::from(self.robot_type.max_acceleration), self.gap.seconds);
        if !acceleration.is_finite() || seconds <= 0.0 {
            return;
        }
        let allowed = acceleration * seconds * ACCELERATION_FACTOR + resolution(acceleration);
        let (from, to) = (f64::from(self.before.speed), f64::from(self.now.speed));
        let changed_gear = from * to < 0.0;
        let change = if changed_gear { (to - from).abs() } else { to.abs() - from.abs() };
        if change.abs() > allowed {
            let kind = if change > 0.0 { Kind::Acceleration } else { Kind::HardBraking };
            faults.push(Fault { kind, value: change.abs() / seconds, limit: acceleration });
        }
    }

    /// Checks a turn on the spot.
    fn check_rotation(&self, faults: &mut Vec<Fault>) {
        let (limit, seconds) = (f64::from(self.robot_type.max_rotation_speed), self.gap.seconds);
        let turns = [self.before, self.now].iter().all(|row| row.state == RobotState::Turning);
        if !turns || !limit.is_finite() || seconds <= 0.0 {
            return;
        }
        let turned = wrap(f64::from(self.now.theta) - f64::from(self.before.theta)).abs();
        if turned > limit * seconds + ROTATION_TOLERANCE {
            faults.push(Fault { kind: Kind::Rotation, value: turned / seconds, limit });
        }
    }

    /// Checks that the robot isn't farther away than it can have driven.
    fn check_teleport(&self, faults: &mut Vec<Fault>) {
        let Self { world, before, now, .. } = *self;
        let value = now.distance_to(before.position);
        let stayed = before.edge == now.edge && world.edge(now.edge).is_some();
        // On the same edge and in the same gear, the limit of the edge counts.
        let same_gear = (now.speed >= 0.0) == (before.speed >= 0.0);
        let limit = if stayed && same_gear { self.reach_on_edge() } else { self.reach() };
        if value > limit {
            faults.push(Fault { kind: Kind::Teleport, value, limit });
        }
    }
}
