//! An order alone: nodes, edges, sequence ids, base and horizon, trajectories, scopes of actions.

use super::finding::{Notes, quoted};
use super::rule::Rule;
use crate::message::{Action, Edge, Node, Order, Trajectory};

/// The node on which an order begins, and whether the order can be followed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Form {
    /// Nodes and edges alternate: it can be followed.
    Sound,
    /// They don't: it is judged alone.
    Broken,
}

/// Judges an order by itself.
pub(super) fn judge(order: &Order, notes: &mut Notes<'_>) -> Form {
    if order.nodes.is_empty() {
        notes.add(Rule::NoNodes, "the order has no nodes".to_owned());
        return Form::Broken;
    }
    for node in &order.nodes {
        judge_map(node, notes);
        node.actions.iter().for_each(|action| judge_scope(action, Scope::Node, notes));
    }
    for edge in &order.edges {
        edge.trajectory.iter().for_each(|path| judge_trajectory(edge, path, notes));
        edge.actions.iter().for_each(|action| judge_scope(action, Scope::Edge, notes));
    }
    if order.edges.len() + 1 != order.nodes.len() {
        let (nodes, edges) = (order.nodes.len(), order.edges.len());
        notes.add(Rule::EdgeCount, format!("{nodes} nodes and {edges} edges"));
        return Form::Broken;
    }
    judge_release(order, notes);
    judge_joints(order, notes);
    judge_sequence(order, notes)
}

fn judge_map(node: &Node, notes: &mut Notes<'_>) {
    if node.node_position.as_ref().is_some_and(|position| position.map_id.is_empty()) {
        let name = quoted(&node.node_id);
        notes.add(Rule::MapMissing, format!("the position of node {name} has an empty mapId"));
    }
}

/// The sequence ids, from that of the first node on.
fn judge_sequence(order: &Order, notes: &mut Notes<'_>) -> Form {
    let first = u64::from(order.nodes[0].sequence_id);
    let nodes = order.nodes.iter().map(|node| node.sequence_id).zip((first..).step_by(2));
    let edges = order.edges.iter().map(|edge| edge.sequence_id).zip((first + 1..).step_by(2));
    let mut wrong = nodes.chain(edges).filter(|(id, wanted)| u64::from(*id) != *wanted);
    match wrong.next() {
        Some((id, wanted)) => {
            notes.add(Rule::SequenceIds, format!("sequenceId {id} stands where {wanted} belongs"));
            Form::Broken
        }
        None => Form::Sound,
    }
}

fn judge_release(order: &Order, notes: &mut Notes<'_>) {
    if !order.nodes[0].released {
        let name = quoted(&order.nodes[0].node_id);
        notes.add(Rule::FirstNodeUnreleased, format!("the first node {name} isn't released"));
        return;
    }
    let mut is_horizon = false;
    for (edge, end) in order.edges.iter().zip(&order.nodes[1..]) {
        let name = quoted(&edge.edge_id);
        is_horizon |= !edge.released;
        if is_horizon && (edge.released || end.released) {
            let text = format!("edge {name} or its end is released, what is before it isn't");
            notes.add(Rule::ReleasedAfterHorizon, text);
            return;
        }
        if edge.released && !end.released {
            let end = quoted(&end.node_id);
            let text = format!("edge {name} is released, its end {end} isn't");
            notes.add(Rule::EdgeBeforeNode, text);
        }
        is_horizon |= !end.released;
    }
}

fn judge_joints(order: &Order, notes: &mut Notes<'_>) {
    for (edge, ends) in order.edges.iter().zip(order.nodes.windows(2)) {
        let named = [&edge.start_node_id, &edge.end_node_id];
        for (named, node) in named.into_iter().zip(ends) {
            if let Some(named) = named.as_ref().filter(|named| **named != node.node_id) {
                let (edge, named) = (quoted(&edge.edge_id), quoted(named));
                let node = quoted(&node.node_id);
                let text = format!("edge {edge} names node {named}, the order has {node} there");
                notes.add(Rule::EdgeEnds, text);
            }
        }
    }
}

fn judge_trajectory(edge: &Edge, path: &Trajectory, notes: &mut Notes<'_>) {
    let degree = path.degree.unwrap_or(1) as usize;
    let points = path.control_points.len();
    let fault = if degree == 0 || points < degree.saturating_add(1) {
        Some(format!("degree {degree} and {points} control points"))
    } else {
        path.knot_vector.as_ref().and_then(|knots| knot_fault(knots, degree + 1 + points))
    };
    if let Some(fault) = fault {
        let edge = quoted(&edge.edge_id);
        notes.add(Rule::Trajectory, format!("the trajectory of edge {edge} has {fault}"));
    }
}

fn knot_fault(knots: &[f64], wanted: usize) -> Option<String> {
    if knots.len() != wanted {
        return Some(format!("{} knots, not {wanted}", knots.len()));
    }
    let is_rising = knots.windows(2).all(|pair| pair[0] <= pair[1]);
    (!is_rising).then(|| "knots that fall".to_owned())
}

/// The place of an action.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scope {
    Instant,
    Node,
    Edge,
}

/// The predefined actions that the standard allows in some places only, with those places. An
/// elevator may initialize a position at a node.
const SCOPES: &[(&str, &[Scope])] = &[
    ("startPause", &[Scope::Instant]),
    ("stopPause", &[Scope::Instant]),
    ("startCharging", &[Scope::Instant, Scope::Node]),
    ("stopCharging", &[Scope::Instant, Scope::Node]),
    ("initPosition", &[Scope::Instant, Scope::Node]),
    ("initializePosition", &[Scope::Instant, Scope::Node]),
    ("downloadMap", &[Scope::Instant]),
    ("deleteMap", &[Scope::Instant]),
    ("stateRequest", &[Scope::Instant]),
    ("logReport", &[Scope::Instant]),
    ("cancelOrder", &[Scope::Instant]),
    ("factsheetRequest", &[Scope::Instant]),
    ("pick", &[Scope::Node, Scope::Edge]),
    ("drop", &[Scope::Node, Scope::Edge]),
    ("detectObject", &[Scope::Node, Scope::Edge]),
    ("waitForTrigger", &[Scope::Node]),
];

/// Judges whether a predefined action may stand in a place.
pub(super) fn judge_scope(action: &Action, place: Scope, notes: &mut Notes<'_>) {
    let row = SCOPES.iter().find(|(kind, _)| *kind == action.action_type);
    if let Some((kind, scopes)) = row
        && !scopes.contains(&place)
    {
        let place = match place {
            Scope::Instant => "an instant action",
            Scope::Node => "an action of a node",
            Scope::Edge => "an action of an edge",
        };
        notes.add(Rule::ActionScope, format!("{kind} is sent as {place}"));
    }
}
