//! Rules of the route graph: a robot is on the curve of its edge, heads as the edge says, drives in
//! a direction that is allowed, and each of its edges begins where the one before ends.

use regatta_plugin::frame::{NO_EDGE, RobotState};

use crate::findings::Kind;
use crate::row::{Fault, Row, wrap};
use crate::site::Site;

/// Metres between a pose and the curve of its edge: the engine's curves differ from the exact ones
/// by up to 1 mm, the judge's by as much, and poses are in single precision.
const PLACE_TOLERANCE: f64 = 0.005;
/// Metres by which positions along an edge differ from the judge's: both approximate arc lengths.
const ALONG_TOLERANCE: f32 = 0.002;
/// Radians between a heading and that of the edge: the engine's differ by up to 0.1°.
const HEADING_TOLERANCE: f64 = 0.02;
/// Metres by which a position along an edge may go back.
const BACK_TOLERANCE: f64 = 0.001;
/// Metres between a robot that stands on no edge and the beginning of the edge that it enters.
const NODE_TOLERANCE: f64 = 0.05;
/// The largest number of legs that a search tries; beyond it a robot counts as having found a way.
const MOST_LEGS: usize = 4096;

/// The single-precision resolution of a place, in metres.
fn resolution(row: &Row) -> f64 {
    f64::from(row.x.abs().max(row.y.abs())) * 2.5e-7
}

/// Checks whether a robot is on its edge, and heads as it should.
pub(crate) fn check_place(site: &Site, now: &Row, faults: &mut Vec<Fault>) {
    let Some(edge) = site.edge(now.edge) else { return };
    let length = edge.record.length;
    let Some((place, tangent)) = edge.at(now.s) else { return };
    let beyond = f64::from((now.s - length).max(-now.s)).max(0.0);
    let off = now.distance_to(place).max(beyond);
    let limit = PLACE_TOLERANCE + 2.0 * resolution(now);
    if off > limit {
        faults.push(Fault { kind: Kind::OffGraph, value: off, limit });
    }
    // A robot that stands at a node may still have the heading of another edge, or be about to
    // turn.
    let is_at_end = now.s <= 1e-3 || now.s >= length - 1e-3;
    if now.state == RobotState::Turning || (is_at_end && now.speed == 0.0) {
        return;
    }
    let turn_to =
        |tangent: f32| wrap(f64::from(now.theta) - f64::from(edge.heading(tangent))).abs();
    let turn = turn_to(tangent);
    // Where an edge has a corner or is much curved, the heading is that of a place nearby.
    let is_near = |offset: f32| {
        edge.at(now.s + offset).is_some_and(|(_, tangent)| turn_to(tangent) <= HEADING_TOLERANCE)
    };
    if turn > HEADING_TOLERANCE && !is_near(ALONG_TOLERANCE) && !is_near(-ALONG_TOLERANCE) {
        faults.push(Fault { kind: Kind::Heading, value: turn, limit: HEADING_TOLERANCE });
    }
}

/// Checks whether a robot can have come here from where it was. `reach` is the distance that it can
/// have driven, in metres.
pub(crate) fn check_way(site: &Site, before: &Row, now: &Row, reach: f64, faults: &mut Vec<Fault>) {
    let Some(edge) = site.edge(now.edge) else { return };
    if now.speed < 0.0 && edge.record.velocity_backwards <= 0.0 {
        faults.push(Fault { kind: Kind::WrongDirection, value: f64::from(now.speed), limit: 0.0 });
        return;
    }
    if before.edge == NO_EDGE {
        let begins = [(false, edge.record.origin), (true, edge.record.destination)];
        let near = begins.into_iter().filter(|(reverse, _)| may_drive(site, now, *reverse)).any(
            |(_, node)| {
                let node = site.nodes.get(node as usize);
                node.is_none_or(|node| {
                    before.distance_to([node.x, node.y]) <= reach + NODE_TOLERANCE
                })
            },
        );
        if !near {
            faults.push(Fault { kind: Kind::BrokenRoute, value: 0.0, limit: 0.0 });
        }
        return;
    }
    let along = f64::from(now.s) - f64::from(before.s);
    if before.edge == now.edge && is_allowed_along(site, before, now, along)
        || has_way(site, before, now, reach)
    {
        return;
    }
    let kind = if before.edge == now.edge { Kind::WrongDirection } else { Kind::BrokenRoute };
    faults.push(Fault { kind, value: along, limit: 0.0 });
}

/// Whether a robot may have moved by this distance along its edge without leaving it. (How far is
/// another rule's matter.)
fn is_allowed_along(site: &Site, before: &Row, now: &Row, along: f64) -> bool {
    let tolerance = BACK_TOLERANCE + f64::from(now.s.abs()) * 2.5e-7;
    let speed = if now.speed == 0.0 { before.speed } else { now.speed };
    let reverse_allowed =
        site.edge(now.edge).is_some_and(|edge| edge.record.velocity_backwards > 0.0);
    let is_forward = along >= -tolerance && speed >= 0.0;
    let is_backward = along <= tolerance && speed <= 0.0 && reverse_allowed;
    is_forward || is_backward || along.abs() <= tolerance
}

/// Whether a robot may drive its edge in this gear, by the sign of its speed.
fn may_drive(site: &Site, row: &Row, reverse: bool) -> bool {
    let allowed = |edge: &crate::site::Edge| !reverse || edge.record.velocity_backwards > 0.0;
    site.edge(row.edge).is_some_and(allowed)
        && if reverse { row.speed <= 0.0 } else { row.speed >= 0.0 }
}

/// Whether there is a way from one place to another over nodes that is no longer than `reach`, in
/// metres.
fn has_way(site: &Site, before: &Row, now: &Row, reach: f64) -> bool {
    let (Some(from), Some(to)) = (site.edge(before.edge), site.edge(now.edge)) else { return true };
    let mut open = Vec::new();
    if may_drive(site, before, false) {
        open.push((
            from.record.destination,
            (f64::from(from.record.length) - f64::from(before.s)).max(0.0),
        ));
    }
    if may_drive(site, before, true) {
        open.push((from.record.origin, f64::from(before.s).max(0.0)));
    }
    let mut ends = Vec::new();
    if may_drive(site, now, false) {
        ends.push((to.record.origin, f64::from(now.s)));
    }
    if may_drive(site, now, true) {
        ends.push((to.record.destination, f64::from(to.record.length) - f64::from(now.s)));
    }
    let mut tried = 0;
    while let Some((node, driven)) = open.pop() {
        if ends.iter().any(|(end, rest)| *end == node && driven + rest <= reach) {
            return true;
        }
        for (leg, reverse) in site.leaving(node) {
            tried += 1;
            if tried > MOST_LEGS {
                return true;
            }
            let record = &site.edges[*leg as usize].record;
            let driven = driven + f64::from(record.length);
            if driven <= reach {
                open.push((if *reverse { record.origin } else { record.destination }, driven));
            }
        }
    }
    false
}
