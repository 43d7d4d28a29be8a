//! Rules of the route graph: a robot is on the curve of its edge, has the edge's heading, drives in
//! an allowed direction, and each of its edges begins where the one before ends.

use regatta_plugin::frame::{NO_EDGE, RobotState};

use crate::findings::Kind;
use crate::motion::{Fault, Move, Row, wrap};
use crate::world_model::{Leg, WorldModel};

/// The tolerance in metres between a pose and the curve of its edge: the engine's curves differ
/// from the exact ones by up to 1 mm, the judge's by as much, and poses are in single precision.
const PLACE_TOLERANCE: f64 = 0.005;
/// The tolerance of positions along an edge, in metres: both sides approximate arc lengths.
const ALONG_TOLERANCE: f32 = 0.002;
/// The tolerance of a heading in radians: the engine's differ by up to 0.1°.
const HEADING_TOLERANCE: f64 = 0.02;
/// The distance by which a position along an edge may go back, in metres.
const BACK_TOLERANCE: f64 = 0.001;
/// The distance, in metres, between a robot without an edge and the start of the edge that it
/// enters.
const NODE_TOLERANCE: f64 = 0.05;
/// The largest number of legs that a search tries. Beyond it, the robot is assumed to have a route.
const MAX_LEGS: usize = 4096;

/// Checks that a robot is on its edge, and has its heading.
pub(crate) fn check_place(world: &WorldModel, now: &Row, faults: &mut Vec<Fault>) {
    let Some(edge) = world.edge(now.edge) else { return };
    let Some((point, tangent)) = edge.at(now.s) else { return };
    let length = edge.record.length;
    let beyond = f64::from((now.s - length).max(-now.s)).max(0.0);
    let off = now.distance_to(point).max(beyond);
    // The resolution of single precision there, in metres.
    let resolution = f64::from(now.position.abs().max_element()) * 2.5e-7;
    let limit = PLACE_TOLERANCE + 2.0 * resolution;
    if off > limit {
        faults.push(Fault { kind: Kind::OffGraph, value: off, limit });
    }
    // A robot that stands at a node may still have the heading of another edge, or be about to
    // turn.
    let is_at_end = now.s <= 1e-3 || now.s >= length - 1e-3;
    if now.state == RobotState::Turning || (is_at_end && now.speed == 0.0) {
        return;
    }
    let turn = turn_from(now, edge.heading(tangent));
    if turn <= HEADING_TOLERANCE {
        return;
    }
    // At a corner or a tight bend of an edge, the heading is that of a nearby point.
    let has_heading_near = [ALONG_TOLERANCE, -ALONG_TOLERANCE].into_iter().any(|offset| {
        let tangent = edge.at(now.s + offset).map(|(_, tangent)| tangent);
        tangent.is_some_and(|tangent| turn_from(now, edge.heading(tangent)) <= HEADING_TOLERANCE)
    });
    if !has_heading_near {
        faults.push(Fault { kind: Kind::Heading, value: turn, limit: HEADING_TOLERANCE });
    }
}

/// Returns the angle between a robot and a heading, in radians.
fn turn_from(now: &Row, heading: f32) -> f64 {
    wrap(f64::from(now.theta) - f64::from(heading)).abs()
}

impl Move<'_> {
    /// Checks that the robot can have come here by edges that it may drive.
    pub fn check_route(&self, faults: &mut Vec<Fault>) {
        let Self { world, before, now, .. } = *self;
        let Some(edge) = world.edge(now.edge) else { return };
        let (speed, along) = (f64::from(now.speed), f64::from(now.s) - f64::from(before.s));
        if now.speed < 0.0 && edge.record.reverse_speed <= 0.0 {
            faults.push(Fault { kind: Kind::WrongDirection, value: speed, limit: 0.0 });
        } else if before.edge == NO_EDGE {
            if !self.is_near_start() {
                faults.push(Fault { kind: Kind::BrokenRoute, value: 0.0, limit: 0.0 });
            }
        } else if !(before.edge == now.edge && self.is_allowed_along(along) || self.has_route()) {
            let same_edge = before.edge == now.edge;
            let kind = if same_edge { Kind::WrongDirection } else { Kind::BrokenRoute };
            faults.push(Fault { kind, value: along, limit: 0.0 });
        }
    }

    /// Whether the robot was near a node from which it may drive its edge.
    fn is_near_start(&self) -> bool {
        let reach = self.reach() + NODE_TOLERANCE;
        legs_of(self.world, self.now).any(|leg| {
            let node = self.world.nodes.get(leg.origin as usize);
            node.is_none_or(|node| self.before.distance_to([node.x, node.y].into()) <= reach)
        })
    }

    /// Whether the robot may have moved by this distance along its edge without leaving it. Another
    /// rule limits the distance.
    fn is_allowed_along(&self, along: f64) -> bool {
        let Self { world, before, now, .. } = *self;
        let tolerance = BACK_TOLERANCE + f64::from(now.s.abs()) * 2.5e-7;
        let speed = if now.speed == 0.0 { before.speed } else { now.speed };
        let reverse_allowed =
            world.edge(now.edge).is_some_and(|edge| edge.record.reverse_speed > 0.0);
        let is_forward = along >= -tolerance && speed >= 0.0;
        let is_backward = along <= tolerance && speed <= 0.0 && reverse_allowed;
        is_forward || is_backward || along.abs() <= tolerance
    }

    /// Whether a route over nodes within reach leads from the edge before to the present one.
    fn has_route(&self) -> bool {
        let Self { world, before, now, .. } = *self;
        if world.edge(before.edge).is_none() {
            return true;
        }
        let reach = self.reach();
        let mut open: Vec<_> = legs_of(world, before)
            .map(|leg| (leg.destination, leg.rest(before).max(0.0)))
            .collect();
        let ends: Vec<_> = legs_of(world, now).map(|leg| (leg.origin, leg.driven(now))).collect();
        let mut tried = 0;
        while let Some((node, driven)) = open.pop() {
            if ends.iter().any(|(end, rest)| *end == node && driven + rest <= reach) {
                return true;
            }
            for leg in world.leaving(node) {
                tried += 1;
                if tried > MAX_LEGS {
                    return true;
                }
                let driven = driven + leg.length;
                if driven <= reach {
                    open.push((leg.destination, driven));
                }
            }
        }
        false
    }
}

/// Returns the legs of a robot's edge that it may drive, by the sign of its speed.
fn legs_of(world: &WorldModel, row: &Row) -> impl Iterator<Item = Leg> {
    let legs = world.edge(row.edge).map_or([None; 2], |edge| edge.legs());
    legs.into_iter()
        .flatten()
        .filter(|leg| if leg.is_reverse { row.speed <= 0.0 } else { row.speed >= 0.0 })
}

impl Leg {
    /// The metres that a robot has driven on it.
    fn driven(&self, row: &Row) -> f64 {
        if self.is_reverse { self.length - f64::from(row.s) } else { f64::from(row.s) }
    }

    /// The metres that a robot has left on it.
    fn rest(&self, row: &Row) -> f64 {
        if self.is_reverse { f64::from(row.s) } else { self.length - f64::from(row.s) }
    }
}
