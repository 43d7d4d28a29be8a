//! Checks an order before a vehicle takes it: its form, and whether the vehicle can carry it out.

use core::f64::consts::{PI, TAU};

use regatta_base::graph::{EdgeIndex, Gear, Leg};
use regatta_plugin::world::Orientation;
use rustc_hash::FxHashSet;

use super::catalogue::Catalogue;
use super::errors::{Cause, Fault};
use super::jobs::{Job, Place};
use super::progress::Step;
use crate::map::Map;
use crate::message::{Action, ActionScope, AllowedDeviation, Edge, Node, Order, OrientationType};

/// The tolerance of a speed that an order repeats from the layout, as a part of it.
const SAME_SPEED: f64 = 1e-3;
/// The tolerance of an orientation, in radians.
const SAME_ANGLE: f64 = 1e-3;

/// Checks the form of an order (2.x: 6.6.1, 6.6.2; 3.0: 6.1.1).
pub(super) fn check_form(order: &Order) -> Result<(), Fault> {
    let Some(first) = order.nodes.first() else {
        return malformed(order, "the order has no nodes");
    };
    if order.edges.len() + 1 != order.nodes.len() {
        let (nodes, edges) = (order.nodes.len(), order.edges.len());
        return malformed(
            order,
            &format!("the order has {nodes} nodes and {edges} edges, not one less"),
        );
    }
    if !first.released {
        return malformed(order, &format!("the first node '{}' isn't released", first.node_id));
    }
    let mut previous = first;
    for (edge, node) in order.edges.iter().zip(&order.nodes[1..]) {
        if let Some(reason) = link_fault(previous, edge, node) {
            return malformed(order, &reason);
        }
        previous = node;
    }
    let mut ids = FxHashSet::default();
    let repeated = actions(order).find(|action| !ids.insert(action.action_id.as_str()));
    match repeated {
        Some(action) => {
            malformed(order, &format!("two actions have the id '{}'", action.action_id))
        }
        None => Ok(()),
    }
}

fn malformed(order: &Order, reason: &str) -> Result<(), Fault> {
    Fault::reject(order, Cause::Malformed, reason)
}

/// All actions of an order.
fn actions(order: &Order) -> impl Iterator<Item = &Action> {
    let of_nodes = order.nodes.iter().flat_map(|node| &node.actions);
    of_nodes.chain(order.edges.iter().flat_map(|edge| &edge.actions))
}

/// The fault of an edge between two nodes, if it has one.
fn link_fault(from: &Node, edge: &Edge, to: &Node) -> Option<String> {
    let id = &edge.edge_id;
    let next = [from.sequence_id.checked_add(1), from.sequence_id.checked_add(2)];
    if next != [Some(edge.sequence_id), Some(to.sequence_id)] {
        let place = from.sequence_id;
        return Some(format!("edge '{id}' or its end doesn't follow the place {place} of a node"));
    }
    if (edge.released || to.released) && !(from.released && edge.released && to.released) {
        return Some(format!("edge '{id}' or its end is released, and not what is before it"));
    }
    let ends = [(&edge.start_node_id, from), (&edge.end_node_id, to)];
    let mut ends = ends.into_iter().filter_map(|(end, node)| Some((end.as_ref()?, node)));
    let wrong = ends.find(|(end, node)| **end != node.node_id);
    wrong.map(|(end, _)| format!("edge '{id}' has the end '{end}', which isn't the node beside it"))
}

/// The meaning of an order to a vehicle.
#[derive(Debug, Default)]
pub(super) struct Plan {
    pub steps: Vec<Step>,
    pub jobs: Vec<Job>,
}

/// Turns the edges and nodes of an order after its first node into steps, from the node `start`.
/// A first edge that leads there counts as driven.
pub(super) fn plan(
    order: &Order,
    start: u32,
    map: &Map,
    catalogue: &Catalogue,
) -> Result<Plan, Fault> {
    let mut plan = Plan::default();
    let mut at = start;
    for (edge, ends) in order.edges.iter().zip(order.nodes.windows(2)) {
        let to = find_node(order, &ends[1], map)?;
        let leg = if at == to { None } else { Some(find_leg(order, edge, [at, to], map)?) };
        check_parameters(order, edge, leg, map)?;
        plan.steps.push(Step { edge: edge.clone(), node: ends[1].clone(), leg, place: to });
        at = to;
    }
    for node in &order.nodes {
        for action in &node.actions {
            plan.jobs.push(job(order, action, Place::Node, node.sequence_id, catalogue)?);
        }
    }
    for edge in &order.edges {
        for action in &edge.actions {
            plan.jobs.push(job(order, action, Place::Edge, edge.sequence_id, catalogue)?);
        }
    }
    plan.jobs.sort_by_key(|job| job.sequence_id);
    Ok(plan)
}

fn find_node(order: &Order, node: &Node, map: &Map) -> Result<u32, Fault> {
    let id = &node.node_id;
    check_map(order, node, map)?;
    map.find_node(id).ok_or_else(|| {
        let fault = Fault::new(Cause::NoRoute, format!("the layout has no node '{id}'"));
        fault.about_order(order).about("nodeId", id)
    })
}

/// Checks the map of a node.
pub(super) fn check_map(order: &Order, node: &Node, map: &Map) -> Result<(), Fault> {
    let unknown = node.node_position.as_ref().filter(|position| !map.has_map(&position.map_id));
    match unknown {
        None => Ok(()),
        Some(position) => {
            let id = &position.map_id;
            let fault = Fault::new(Cause::UnknownMap, format!("the layout has no map '{id}'"));
            Err(fault.about_order(order).about("nodeId", &node.node_id).about("mapId", id))
        }
    }
}

fn find_leg(order: &Order, edge: &Edge, ends: [u32; 2], map: &Map) -> Result<Leg, Fault> {
    let id = &edge.edge_id;
    let Some(index) = map.find_edge(id) else {
        return Err(no_route(order, id, format!("the layout has no edge '{id}'")));
    };
    let Some(gear) = map.gear(index, ends[0], ends[1]) else {
        let [from, to] = ends.map(|node| map.node(node).map_or("?", |place| place.id.as_str()));
        let reason = format!("edge '{id}' can't be driven from '{from}' to '{to}'");
        return Err(no_route(order, id, reason));
    };
    Ok(Leg { edge: EdgeIndex(index), gear })
}

fn no_route(order: &Order, edge: &str, reason: String) -> Fault {
    Fault::new(Cause::NoRoute, reason).about_order(order).about("edgeId", edge)
}

/// Refuses fields that the vehicle can't obey (2.x: 6.6.4.2; 3.0: 6.1.4.2).
fn check_parameters(order: &Order, edge: &Edge, leg: Option<Leg>, map: &Map) -> Result<(), Fault> {
    let Some(leg) = leg else { return Ok(()) };
    let name = if edge.trajectory.is_some() {
        "trajectory"
    } else if edge.maximum_speed.is_some_and(|most| most < map.speed(leg) * (1.0 - SAME_SPEED)) {
        "maximumSpeed"
    } else if !edge.orientation.is_none_or(|angle| is_obeyed(edge, angle, leg, map)) {
        "orientation"
    } else {
        return Ok(());
    };
    let reason = format!("edge '{}' has a '{name}' that isn't that of the layout", edge.edge_id);
    let fault = Fault::new(Cause::UnsupportedParameter, reason).about_order(order);
    Err(fault.about("edgeId", &edge.edge_id).about("parameter", name))
}

/// Whether vehicles drive a leg in an orientation anyway, by the layout.
fn is_obeyed(edge: &Edge, angle: f64, leg: Leg, map: &Map) -> bool {
    let Some(road) = map.edge(leg.edge.0) else { return false };
    let wanted = match (edge.orientation_type.unwrap_or_default(), road.orientation) {
        (OrientationType::Tangential, Orientation::Tangential) => 0.0,
        (OrientationType::Tangential, Orientation::Offset(offset)) => f64::from(offset),
        (OrientationType::Global, Orientation::Fixed(heading)) => f64::from(heading),
        _ => return false,
    };
    // In reverse gear a robot faces against its way.
    let is_turned = leg.gear == Gear::Reverse
        && edge.orientation_type.unwrap_or_default() == OrientationType::Tangential;
    let turned = if is_turned { wanted + PI } else { wanted };
    let difference = (angle - turned).rem_euclid(TAU);
    difference.min(TAU - difference) < SAME_ANGLE
}

fn job(
    order: &Order,
    action: &Action,
    place: Place,
    sequence_id: u32,
    catalogue: &Catalogue,
) -> Result<Job, Fault> {
    let (scope, word) = match place {
        Place::Node => (ActionScope::Node, "node"),
        Place::Edge => (ActionScope::Edge, "edge"),
    };
    let kind = &action.action_type;
    match catalogue.find(kind, scope) {
        Some(ability) => Ok(Job::new(action.clone(), ability.clone(), place, sequence_id)),
        None => {
            let reason = format!("the vehicle can't carry out '{kind}' at a {word}");
            let fault = Fault::new(Cause::InvalidOrderAction, reason).about_order(order);
            Err(fault.about("actionId", &action.action_id).about("actionType", kind))
        }
    }
}

/// Whether a vehicle at a place is within the deviation that its first node allows.
pub(super) fn is_near(node: &Node, x: f64, y: f64) -> bool {
    /// The tolerance of a node without one: its position may be rounded. Metres.
    const TOLERANCE: f64 = 0.1;
    node.node_position.as_ref().is_some_and(|position| {
        let (east, north) = (x - position.x, y - position.y);
        let deviation = position.allowed_deviation.unwrap_or(AllowedDeviation::Radius(TOLERANCE));
        east.hypot(north) <= TOLERANCE || deviation.contains(east, north)
    })
}
