//! Rules of motion: speed, acceleration, turns on the spot, and how far a robot gets in the time
//! between two frames.

use regatta_plugin::frame::RobotState;
use regatta_plugin::world::RobotTypeRecord;

use crate::findings::Kind;
use crate::row::{Fault, Row, wrap};
use crate::site::Site;

/// Metres that a robot may have moved further than its speed limit and the time allow: single
/// precision of poses, and ends of edges that are a little apart.
const DISTANCE_TOLERANCE: f64 = 0.005;
/// The engine's curves are driven up to 0.1 % faster than their arc length says.
const DISTANCE_FACTOR: f64 = 1.002;
/// Metres per second above a speed limit.
const SPEED_TOLERANCE: f64 = 0.001;
/// The part by which a change of speed may exceed the limit. What the resolution of distances (2⁻²⁶
/// m) adds is in [`resolution`].
const ACCELERATION_FACTOR: f64 = 1.01;
/// Radians that a turn on the spot may exceed its limit by.
const ROTATION_TOLERANCE: f64 = 0.002;

/// The change of speed that the resolution of distances causes near a stop: √(2 a 2⁻²⁶ m), and as
/// much for rounding.
fn resolution(acceleration: f64) -> f64 {
    2.0 * (2.0 * acceleration * 2f64.powi(-26)).sqrt() + 1e-5
}

/// The time between two frames.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Gap {
    /// Seconds of simulated time.
    pub seconds: f64,
    /// Seconds of one tick.
    pub period: f64,
}

/// Returns the speed limit on an edge, in the gear in which a robot drives it.
pub(crate) fn speed_limit(site: &Site, robot_type: &RobotTypeRecord, edge: u32, speed: f32) -> f64 {
    let of_edge = site.edge(edge).map_or(site.fastest, |edge| {
        let record = &edge.record;
        f64::from(if speed < 0.0 { record.velocity_backwards } else { record.velocity_forward })
    });
    of_edge.min(f64::from(robot_type.max_speed))
}

/// The furthest that a robot gets between two frames, in metres, with tolerance.
pub(crate) fn reach(site: &Site, robot_type: &RobotTypeRecord, gap: Gap) -> f64 {
    site.fastest.min(f64::from(robot_type.max_speed)) * gap.seconds * DISTANCE_FACTOR
        + DISTANCE_TOLERANCE
}

/// The furthest that a robot gets along the edge that it stays on. A robot that has just come from
/// a faster edge may be ahead by what it needs to brake within a tick.
pub(crate) fn reach_on_edge(site: &Site, robot_type: &RobotTypeRecord, now: &Row, gap: Gap) -> f64 {
    let forward = speed_limit(site, robot_type, now.edge, 1.0);
    let backward = speed_limit(site, robot_type, now.edge, -1.0);
    // Where reverse gear isn't allowed, its use is a wrong direction.
    let limit = if now.speed < 0.0 && backward > 0.0 { backward } else { forward };
    let change = f64::from(robot_type.max_acceleration) * gap.period * gap.period;
    let slack = if change.is_finite() { change } else { 0.0 };
    limit * gap.seconds * DISTANCE_FACTOR + slack + DISTANCE_TOLERANCE
}

/// Checks a robot's speed in one frame.
pub(crate) fn check_speed(
    site: &Site,
    robot_type: &RobotTypeRecord,
    now: &Row,
    faults: &mut Vec<Fault>,
) {
    let speed = f64::from(now.speed.abs());
    let limit = speed_limit(site, robot_type, now.edge, now.speed);
    // Without permission for reverse gear there is no limit to be over: that is a wrong direction.
    if speed > limit * 1.0001 + SPEED_TOLERANCE && (now.speed > 0.0 || limit > 0.0) {
        faults.push(Fault { kind: Kind::Speed, value: speed, limit });
    }
}

/// Checks how a robot's speed has changed since the frame before.
pub(crate) fn check_acceleration(
    robot_type: &RobotTypeRecord,
    before: &Row,
    now: &Row,
    gap: Gap,
    faults: &mut Vec<Fault>,
) {
    let acceleration = f64::from(robot_type.max_acceleration);
    if !acceleration.is_finite() || gap.seconds <= 0.0 {
        return;
    }
    let allowed = acceleration * gap.seconds * ACCELERATION_FACTOR + resolution(acceleration);
    let (from, to) = (f64::from(before.speed), f64::from(now.speed));
    let changed_gear = from * to < 0.0;
    let change = if changed_gear { (to - from).abs() } else { to.abs() - from.abs() };
    if change.abs() > allowed {
        let kind = if change > 0.0 { Kind::Acceleration } else { Kind::HardBraking };
        faults.push(Fault { kind, value: change.abs() / gap.seconds, limit: acceleration });
    }
}

/// Checks a turn on the spot.
pub(crate) fn check_rotation(
    robot_type: &RobotTypeRecord,
    before: &Row,
    now: &Row,
    gap: Gap,
    faults: &mut Vec<Fault>,
) {
    let limit = f64::from(robot_type.max_rotation_speed);
    let turns = before.state == RobotState::Turning && now.state == RobotState::Turning;
    if !turns || !limit.is_finite() || gap.seconds <= 0.0 {
        return;
    }
    let turned = wrap(f64::from(now.theta) - f64::from(before.theta)).abs();
    if turned > limit * gap.seconds + ROTATION_TOLERANCE {
        faults.push(Fault { kind: Kind::Rotation, value: turned / gap.seconds, limit });
    }
}

/// Checks whether a robot is further away than it can have driven.
pub(crate) fn check_teleport(
    site: &Site,
    robot_type: &RobotTypeRecord,
    before: &Row,
    now: &Row,
    gap: Gap,
    faults: &mut Vec<Fault>,
) {
    let moved = now.distance_to([before.x, before.y]);
    let stayed = before.edge == now.edge && site.edge(now.edge).is_some();
    // On a straight piece of the same edge the limit of the edge counts, else the fastest that the
    // robot may be anywhere.
    let limit = if stayed && (now.speed >= 0.0) == (before.speed >= 0.0) {
        reach_on_edge(site, robot_type, now, gap)
    } else {
        reach(site, robot_type, gap)
    };
    if moved > limit {
        faults.push(Fault { kind: Kind::Teleport, value: moved, limit });
    }
}
