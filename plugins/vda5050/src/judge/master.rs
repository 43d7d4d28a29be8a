//! The master: its orders after each other, and its instant actions.

use super::actions::Outlook;
use super::finding::{Notes, quoted};
use super::order::{self, Form, Scope};
use super::route::{Cancelling, Route};
use super::rule::Rule;
use super::vehicle::{Link, Vehicle};
use crate::message::{Action, BlockingType, InstantActions, Node, OperatingMode, Order, State};

/// Metres by which the first node of an order may be away without an allowed deviation.
const START_TOLERANCE: f64 = 1.0;

/// Judges an order, and notes it.
pub(super) fn take_order(vehicle: &mut Vehicle, order: &Order, now: f64, notes: &mut Notes<'_>) {
    let form = order::judge(order, notes);
    vehicle.actions.add_order(order, notes);
    judge_receiver(vehicle, notes);
    let latest = vehicle.orders.latest();
    let is_update = latest.is_some_and(|latest| latest.order_id == order.order_id);
    let is_copy = is_update && is_sent_again(vehicle, order, notes);
    if is_copy {
        return;
    }
    let route = match (form, is_update) {
        (Form::Broken, _) => None,
        (Form::Sound, true) => updated(vehicle, order, notes),
        (Form::Sound, false) => {
            judge_new(vehicle, order, notes);
            Some(Route::new(order))
        }
    };
    vehicle.orders.last = Some(order.clone());
    vehicle.orders.push(order, route, now);
}

/// Whether the vehicle may take orders.
fn judge_receiver(vehicle: &Vehicle, notes: &mut Notes<'_>) {
    if matches!(vehicle.link, Link::Offline | Link::Broken) {
        notes.add(Rule::OrderOffline, "the vehicle isn't online".to_owned());
    }
    let Some(state) = &vehicle.state else { return };
    let refuses = matches!(
        state.operating_mode,
        OperatingMode::Manual
            | OperatingMode::Service
            | OperatingMode::TeachIn
            | OperatingMode::Startup
    );
    if refuses {
        let text = format!("the operating mode is {:?}", state.operating_mode);
        notes.add(Rule::OrderInMode, text);
    }
}

/// Whether an update has the number of the last one. Its content has to be the same, too.
fn is_sent_again(vehicle: &Vehicle, order: &Order, notes: &mut Notes<'_>) -> bool {
    let last = vehicle.orders.last.as_ref().filter(|last| {
        last.order_id == order.order_id && last.order_update_id == order.order_update_id
    });
    if let Some(last) = last
        && (&last.nodes, &last.edges) != (&order.nodes, &order.edges)
    {
        let id = order.order_update_id;
        notes.add(Rule::UpdateIdReused, format!("orderUpdateId {id} again with other content"));
    }
    last.is_some()
}

/// The order after an update; `None` if the vehicle has to reject it.
fn updated(vehicle: &Vehicle, order: &Order, notes: &mut Notes<'_>) -> Option<Route> {
    let latest = vehicle.orders.latest()?;
    if order.order_update_id <= latest.update_id {
        let (id, last) = (order.order_update_id, latest.update_id);
        notes.add(Rule::UpdateIdBackwards, format!("orderUpdateId {id} after {last}"));
        return None;
    }
    if vehicle.orders.cancelling == Cancelling::Asked {
        let name = quoted(&order.order_id);
        notes.add(Rule::UpdateAfterCancel, format!("order {name} was cancelled"));
        return None;
    }
    let is_waiting = vehicle.orders.sent.iter().any(|sent| sent.route.is_some());
    if is_waiting {
        let id = latest.update_id;
        notes.add(Rule::UpdateTooEarly, format!("no state shows update {id} yet"));
    }
    let (first, end) = (order.nodes.first()?, latest.base_end()?);
    judge_stitch(first, end, notes).then(|| latest.updated(order))
}

/// A node with its sequence id.
fn place(node: &Node) -> String {
    format!("{} ({})", quoted(&node.node_id), node.sequence_id)
}

/// Whether an update begins at the end of the base.
fn judge_stitch(first: &Node, end: &Node, notes: &mut Notes<'_>) -> bool {
    let text = format!("the update begins at {}, the base ends at {}", place(first), place(end));
    if first.sequence_id < end.sequence_id {
        notes.add(Rule::BaseSentAgain, text);
        return false;
    }
    if (first.sequence_id, &first.node_id) != (end.sequence_id, &end.node_id) {
        notes.add(Rule::Stitching, text);
        return false;
    }
    if let (Some(new), Some(old)) = (&first.node_position, &end.node_position)
        && (new.x, new.y, &new.map_id) != (old.x, old.y, &old.map_id)
    {
        let text = format!("node {} has another position than before", place(first));
        notes.add(Rule::StitchingNodeChanged, text);
    }
    true
}

fn judge_new(vehicle: &Vehicle, order: &Order, notes: &mut Notes<'_>) {
    // Without an order before, and a state that shows another one, this may be an update.
    let shows_other = vehicle.state.as_ref().is_some_and(|state| state.order_id != order.order_id);
    if vehicle.orders.latest().is_none() && !shows_other {
        return;
    }
    if order.order_update_id != 0 {
        let id = order.order_update_id;
        notes.add(Rule::FirstUpdateId, format!("a new order has the orderUpdateId {id}"));
    }
    let Some(first) = order.nodes.first() else { return };
    if first.sequence_id != 0 {
        let id = first.sequence_id;
        notes.add(Rule::SequenceStart, format!("a new order begins with the sequence id {id}"));
    }
    let Some(state) = &vehicle.state else { return };
    if vehicle.is_under_way() && vehicle.orders.cancelling == Cancelling::No {
        let (new, old) = (quoted(&order.order_id), quoted(&state.order_id));
        let text = format!("order {new} is sent while {old} is under way");
        notes.add(Rule::OrderWhileActive, text);
    } else if let Some(text) = start_fault(state, first) {
        notes.add(Rule::StartOutOfRange, text);
    }
}

/// The reason why a vehicle can't begin at a node.
fn start_fault(state: &State, first: &Node) -> Option<String> {
    let position = state.mobile_robot_position.as_ref().filter(|position| position.localized)?;
    let place = first.node_position.as_ref()?;
    let name = quoted(&first.node_id);
    if place.map_id != position.map_id {
        let (node, vehicle) = (quoted(&place.map_id), quoted(&position.map_id));
        return Some(format!("node {name} is on the map {node}, the vehicle on {vehicle}"));
    }
    let (east, north) = (position.x - place.x, position.y - place.y);
    let distance = east.hypot(north);
    let is_near = distance <= START_TOLERANCE
        || place.allowed_deviation.is_some_and(|deviation| deviation.contains(east, north));
    (!is_near).then(|| format!("node {name} is {distance:.2} m from the vehicle"))
}

/// Judges instant actions, and notes them.
pub(super) fn take_actions(
    vehicle: &mut Vehicle,
    message: &InstantActions,
    now: f64,
    notes: &mut Notes<'_>,
) {
    for action in &message.actions {
        order::judge_scope(action, Scope::Instant, notes);
        if notes.is_3() {
            judge_instant_3(vehicle, action, notes);
        }
        let outlook = match action.action_type.as_str() {
            "cancelOrder" => cancel(vehicle, notes),
            _ => Outlook::Open,
        };
        vehicle.actions.add_instant(action, now, outlook, notes);
    }
}

fn cancel(vehicle: &mut Vehicle, notes: &mut Notes<'_>) -> Outlook {
    if vehicle.state.is_some() && !vehicle.has_order() {
        notes.add(Rule::CancelWithoutOrder, "the vehicle has no order to cancel".to_owned());
        return Outlook::Vain;
    }
    vehicle.orders.cancelling = Cancelling::Asked;
    Outlook::Open
}

fn judge_instant_3(vehicle: &Vehicle, action: &Action, notes: &mut Notes<'_>) {
    let name = quoted(&action.action_type);
    if action.blocking_type != BlockingType::None {
        let text = format!("{name} has the blocking type {:?}", action.blocking_type);
        notes.add(Rule::InstantBlocking, text);
    }
    let Some(mode) = vehicle.state.as_ref().map(|state| state.operating_mode) else { return };
    let is_allowed = match mode {
        OperatingMode::Automatic | OperatingMode::SemiAutomatic => true,
        OperatingMode::Intervened => action.action_type == "cancelOrder",
        _ => false,
    };
    if !is_allowed {
        notes.add(Rule::InstantInMode, format!("{name} in the operating mode {mode:?}"));
    }
}
