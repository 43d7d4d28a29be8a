//! The progress of a vehicle along its order, by two states that follow each other.

use super::finding::{Notes, quoted};
use super::route::{Extent, Route};
use super::rule::Rule;
use crate::message::{EmergencyStop, Node, OperatingMode, State};

/// A state of a vehicle that has an order, and the state before.
#[derive(Clone, Copy, Debug)]
pub(super) struct Step<'a> {
    pub route: &'a Route,
    pub state: &'a State,
    pub before: Option<&'a State>,
    pub clearing: Clearing,
}

/// Whether a vehicle may have cleared its order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Clearing {
    /// It has to carry it out.
    No,
    /// The order was cancelled, or a person has the vehicle.
    Allowed,
}

impl<'a> Step<'a> {
    /// Whether the order is gone because it may, or ends at a node before its last one.
    fn is_cleared(&self) -> bool {
        let left = &self.state.node_states;
        self.clearing == Clearing::Allowed && (left.is_empty() || self.is_cut_short())
    }

    /// Whether the nodes that are left are some of the order's, without its last one.
    fn is_cut_short(&self) -> bool {
        let (left, all) = (&self.state.node_states, &self.route.nodes);
        let is_known = left.iter().all(|shown| {
            let node = self.route.node(shown.sequence_id);
            node.is_some_and(|node| node.node_id == shown.node_id)
        });
        let ends = [left.last().map(|shown| shown.sequence_id), all.last().map(|n| n.sequence_id)];
        is_known && ends[0] < ends[1]
    }

    /// Whether the vehicle has reached a node of the order.
    fn is_begun(&self) -> bool {
        !self.is_cleared() && self.route.is_begun(&self.state.node_states)
    }

    /// The state before, if that was of the same order and the order was begun.
    fn before_on_order(&self) -> Option<&'a State> {
        self.before.filter(|before| {
            before.order_id == self.state.order_id && self.route.is_begun(&before.node_states)
        })
    }

    /// The node that the vehicle has just reached, if it is one of the order.
    pub fn reached(&self) -> Option<&'a Node> {
        let id = self.state.last_node_sequence_id;
        let is_new = self.before.is_some_and(|before| {
            before.last_node_sequence_id != id || before.order_id != self.state.order_id
        });
        let node = self.route.node(id).filter(|_| is_new && self.is_begun())?;
        (node.node_id == self.state.last_node_id).then_some(node)
    }

    /// Whether the vehicle is on the edge after its last node.
    pub fn is_on_edge(&self) -> bool {
        self.is_begun() && !self.state.node_states.is_empty()
    }
}

/// Judges a state of a vehicle that has an order.
pub(super) fn judge(step: &Step<'_>, notes: &mut Notes<'_>) {
    judge_mode(step.state, notes);
    if !step.is_cleared() {
        judge_nodes(step, notes);
        judge_edges(step, notes);
    }
    if step.is_begun() {
        judge_last_node(step, notes);
    }
    let (now, before) = (step.state, step.before_on_order());
    if let Some(before) = before
        && now.last_node_sequence_id < before.last_node_sequence_id
        && !now.last_node_id.is_empty()
    {
        let (old, new) = (before.last_node_sequence_id, now.last_node_sequence_id);
        let text = format!("lastNodeSequenceId goes from {old} to {new}");
        notes.add(Rule::SequenceBackwards, text);
    }
}

fn judge_nodes(step: &Step<'_>, notes: &mut Notes<'_>) {
    let (left, all) = (&step.state.node_states, &step.route.nodes);
    let pairs = left.iter().rev().zip(all.iter().rev());
    let mut wrong = pairs.filter(|(shown, node)| {
        (&shown.node_id, shown.sequence_id, shown.released)
            != (&node.node_id, node.sequence_id, node.released)
    });
    if let Some((shown, node)) = wrong.next_back() {
        let (shown_id, node_id) = (quoted(&shown.node_id), quoted(&node.node_id));
        let text = format!(
            "nodeStates has {shown_id} ({}, released {}), the order {node_id} ({}, released {})",
            shown.sequence_id, shown.released, node.sequence_id, node.released
        );
        notes.add(Rule::NodeStates, text);
    } else if left.len() > all.len() && step.route.extent == Extent::Whole {
        let text = format!("{} nodeStates, the order has {} nodes", left.len(), all.len());
        notes.add(Rule::NodeStates, text);
    }
}

fn judge_edges(step: &Step<'_>, notes: &mut Notes<'_>) {
    let (left, all) = (&step.state.edge_states, &step.route.edges);
    let pairs = left.iter().rev().zip(all.iter().rev());
    let mut wrong = pairs.filter(|(shown, edge)| {
        (&shown.edge_id, shown.sequence_id, shown.released)
            != (&edge.edge_id, edge.sequence_id, edge.released)
    });
    if let Some((shown, edge)) = wrong.next_back() {
        let (shown_id, edge_id) = (quoted(&shown.edge_id), quoted(&edge.edge_id));
        let text = format!(
            "edgeStates has {shown_id} ({}, released {}), the order {edge_id} ({}, released {})",
            shown.sequence_id, shown.released, edge.sequence_id, edge.released
        );
        notes.add(Rule::EdgeStates, text);
        return;
    }
    let nodes = step.state.node_states.len();
    let is_at_start = left.len() + 1 == nodes && !step.is_begun();
    if left.len() != nodes && !is_at_start {
        let text = format!("{} edgeStates with {nodes} nodeStates", left.len());
        notes.add(Rule::EdgeStates, text);
    }
}

/// The last node is the one before those that are left.
fn judge_last_node(step: &Step<'_>, notes: &mut Notes<'_>) {
    let (state, route) = (step.state, step.route);
    let last = state.last_node_sequence_id;
    let next = state.node_states.first().map(|node| node.sequence_id);
    let end = route.nodes.last().map_or(0, |node| node.sequence_id);
    let wanted = next.map_or(end, |next| next.saturating_sub(2));
    if last != wanted {
        let text = format!("lastNodeSequenceId is {last}, by nodeStates it is {wanted}");
        notes.add(Rule::NodeUnnamed, text);
    }
    let Some(node) = route.node(last) else { return };
    if node.node_id != state.last_node_id {
        let (shown, node) = (quoted(&state.last_node_id), quoted(&node.node_id));
        let text = format!("lastNodeId is {shown}, the order has {node} at {last}");
        notes.add(Rule::LastNode, text);
    } else if !node.released {
        let text = format!("node {} was reached and isn't released", quoted(&node.node_id));
        notes.add(Rule::HorizonDriven, text);
    }
}

fn judge_mode(state: &State, notes: &mut Notes<'_>) {
    let clears = match state.operating_mode {
        OperatingMode::Manual => true,
        OperatingMode::Service | OperatingMode::TeachIn | OperatingMode::Startup => notes.is_3(),
        _ => false,
    };
    if clears && !state.node_states.is_empty() {
        let (mode, left) = (state.operating_mode, state.node_states.len());
        notes.add(Rule::OrderInManualMode, format!("{left} nodes are left in mode {mode:?}"));
    }
}

/// Judges whether a vehicle may drive. It may need the time between two states to stop.
pub(super) fn judge_driving(state: &State, before: Option<&State>, notes: &mut Notes<'_>) {
    let Some(before) = before.filter(|before| before.driving && state.driving) else { return };
    let both = [before, state];
    if both.iter().all(|state| state.paused == Some(true)) {
        notes.add(Rule::DrivingWhilePaused, "driving and paused are both true".to_owned());
    }
    if both.iter().all(|state| state.safety_state.active_emergency_stop != EmergencyStop::None) {
        let stop = state.safety_state.active_emergency_stop;
        let text = format!("driving while the emergency stop is active ({stop:?})");
        notes.add(Rule::DrivingInEmergency, text);
    }
    if both.iter().all(|state| is_lost(state)) {
        notes.add(Rule::DrivingUnlocalized, "driving without a known position".to_owned());
    }
}

fn is_lost(state: &State) -> bool {
    state.operating_mode == OperatingMode::Automatic
        && state.mobile_robot_position.as_ref().is_some_and(|position| !position.localized)
}
