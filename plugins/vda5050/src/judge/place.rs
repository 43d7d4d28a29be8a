//! The place of a vehicle: against its node, its edge, and its own visualization.

use super::clock;
use super::curve::{distance_to_line, distance_to_path};
use super::finding::{Notes, quoted};
use super::progress::Step;
use super::rule::Rule;
use crate::message::{AllowedDeviation, Edge, Position, State, Trajectory, Visualization};

/// Metres that a position may be off, for its own error.
const TOLERANCE: f64 = 0.25;
/// Seconds that a vehicle may drive on before its state tells its place.
const REACTION: f64 = 0.5;
/// Metres per second that a vehicle may drive between a state and a visualization.
const MOST_SPEED: f64 = 5.0;
/// Seconds between a state and a visualization that are compared.
const COMPARED: f64 = 2.0;
/// Metres from corner to corner of a vehicle whose contacts are judged.
pub(super) const MOST_SIZE: f64 = 10.0;
/// The share by which a speed may be above its limit.
const SPEED_SHARE: f64 = 1.05;
/// Metres per second by which a speed may be above its limit.
const SPEED_NOISE: f64 = 0.05;

/// The size of a vehicle in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Footprint {
    pub length: f64,
    pub width: f64,
}

impl Footprint {
    /// The size, if it is one of a vehicle.
    pub fn new(length: f64, width: f64) -> Option<Self> {
        let is_size = length > 0.0 && width > 0.0 && length.hypot(width) <= MOST_SIZE;
        is_size.then_some(Self { length, width })
    }
}

/// Judges the place and the speed of a vehicle that has an order.
pub(super) fn judge_state(step: &Step<'_>, notes: &mut Notes<'_>) {
    let state = step.state;
    let next = state.last_node_sequence_id.saturating_add(1);
    let edge = step.route.edge(next).filter(|_| step.is_on_edge());
    if let Some(edge) = edge {
        judge_speed(state, edge, notes);
    }
    let Some(position) = state.mobile_robot_position.as_ref().filter(|place| place.localized)
    else {
        return;
    };
    judge_node(step, position, notes);
    if let Some(edge) = edge {
        judge_edge(step, edge, position, notes);
    }
}

fn speed(state: &State) -> f64 {
    let velocity = state.velocity.unwrap_or_default();
    velocity.vx.unwrap_or(0.0).hypot(velocity.vy.unwrap_or(0.0))
}

fn judge_speed(state: &State, edge: &Edge, notes: &mut Notes<'_>) {
    let speed = speed(state);
    if let Some(limit) = edge.maximum_speed
        && speed > limit * SPEED_SHARE + SPEED_NOISE
    {
        let name = quoted(&edge.edge_id);
        let text = format!("{speed:.2} m/s on edge {name}, which allows {limit:.2} m/s");
        notes.add(Rule::SpeedLimit, text);
    }
}

fn judge_node(step: &Step<'_>, position: &Position, notes: &mut Notes<'_>) {
    let Some(node) = step.reached() else { return };
    let Some(place) = &node.node_position else { return };
    let Some(deviation) = place.allowed_deviation else { return };
    let (east, north) = (position.x - place.x, position.y - place.y);
    let radius = match deviation {
        AllowedDeviation::Radius(radius) => radius,
        AllowedDeviation::Ellipse(ellipse) => ellipse.a.max(ellipse.b),
    };
    let distance = east.hypot(north);
    let most = radius + TOLERANCE + REACTION * speed(step.state);
    let is_there = place.map_id == position.map_id && distance <= most;
    if !is_there {
        let (name, map) = (quoted(&node.node_id), quoted(&position.map_id));
        let text = format!(
            "node {name} is reached {distance:.2} m from it on map {map}, {radius:.2} m allowed"
        );
        notes.add(Rule::NodeOutOfRange, text);
    }
}

fn judge_edge(step: &Step<'_>, edge: &Edge, position: &Position, notes: &mut Notes<'_>) {
    let point = [position.x, position.y];
    let corridor = edge.corridor.map_or(0.0, |space| space.left_width.max(space.right_width));
    let name = quoted(&edge.edge_id);
    if let Some(path) = path(step, edge) {
        let distance = distance_to_path(point, path).unwrap_or(0.0);
        if distance > corridor + TOLERANCE + deviation(step, edge) {
            let text = format!("{distance:.2} m off the trajectory of edge {name}");
            notes.add(Rule::OffTrajectory, text);
        }
        return;
    }
    let Some([from, to]) = ends(step, edge, position) else { return };
    let length = (to[0] - from[0]).hypot(to[1] - from[1]);
    let distance = distance_to_line(point, from, to);
    if distance > length / 2.0 + corridor + TOLERANCE + deviation(step, edge) {
        let text = format!("{distance:.2} m off edge {name}, which is {length:.2} m long");
        notes.add(Rule::OffEdge, text);
    }
}

/// The trajectory of an edge: that of the order, or that of the vehicle.
fn path<'a>(step: &Step<'a>, edge: &'a Edge) -> Option<&'a Trajectory> {
    let mut shown = step.state.edge_states.iter();
    let shown = shown.find(|shown| shown.sequence_id == edge.sequence_id);
    edge.trajectory.as_ref().or_else(|| shown?.trajectory.as_ref())
}

/// The largest deviation that the nodes of an edge allow: a vehicle may cut the corners there.
fn deviation(step: &Step<'_>, edge: &Edge) -> f64 {
    let ends = [edge.sequence_id.saturating_sub(1), edge.sequence_id.saturating_add(1)];
    let positions = ends.iter().filter_map(|id| step.route.node(*id)?.node_position.as_ref());
    let radii = positions.filter_map(|position| match position.allowed_deviation? {
        AllowedDeviation::Radius(radius) => Some(radius),
        AllowedDeviation::Ellipse(ellipse) => Some(ellipse.a.max(ellipse.b)),
    });
    radii.fold(0.0, f64::max)
}

/// The ends of an edge, if they are on the map of the vehicle.
fn ends(step: &Step<'_>, edge: &Edge, position: &Position) -> Option<[[f64; 2]; 2]> {
    let ids = [edge.sequence_id.checked_sub(1)?, edge.sequence_id.checked_add(1)?];
    let [from, to] = ids.map(|id| end(step, id, &position.map_id));
    Some([from?, to?])
}

/// The position of a node, if it is on a map.
fn end(step: &Step<'_>, sequence_id: u32, map_id: &str) -> Option<[f64; 2]> {
    let place = step.route.node(sequence_id)?.node_position.as_ref()?;
    (place.map_id == map_id).then_some([place.x, place.y])
}

/// Judges a visualization against the last state.
pub(super) fn judge_visualization(message: &Visualization, state: &State, notes: &mut Notes<'_>) {
    let (Some(seen), Some(told)) = (&message.mobile_robot_position, &state.mobile_robot_position)
    else {
        return;
    };
    let times = [&message.header.timestamp, &state.header.timestamp].map(|at| clock::seconds(at));
    let [Some(seen_time), Some(told_time)] = times else { return };
    let after = seen_time - told_time;
    let distance = (seen.x - told.x).hypot(seen.y - told.y);
    let most = TOLERANCE + MOST_SPEED.max(2.0 * speed(state)) * after.abs();
    if after.abs() <= COMPARED && seen.map_id == told.map_id && distance > most {
        let text = format!("{distance:.2} m from the position of the state, {after:.2} s after it");
        notes.add(Rule::Visualization, text);
    }
}
