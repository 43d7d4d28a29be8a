//! Orders and vehicles as JSON.

use serde_json::{Value, json};

use crate::tasks::desk::Vehicle;
use crate::tasks::order::{Order, State};
use crate::tasks::places::Places;

/// Returns an order as the API shows it. Times are in seconds of simulated time.
pub(super) fn order(order: &Order, places: &Places) -> Value {
    let content = order.content();
    let state = |index: usize| match order.state() {
        _ if index < order.handled_stops() => "finished",
        State::Travelling(_) if index == order.handled_stops() => "travelling",
        State::Handling(_) if index == order.handled_stops() => "handling",
        _ => "pristine",
    };
    let destination = |(index, stop): (usize, &crate::tasks::order::Stop)| {
        json!({
            "locationName": places.label(stop.node),
            "node": places.place(stop.node).id,
            "operation": stop.action,
            "dwell": stop.dwell_secs,
            "state": state(index),
        })
    };
    json!({
        "name": content.name(),
        "state": order.state().name(),
        "reason": order.reason(),
        "processingVehicle": order.state().robot().map(|robot| robot.to_string()),
        "intendedVehicle": content.intended_robot().map(|robot| robot.to_string()),
        "priority": content.priority(),
        "created": order.created_secs(),
        "earliestStart": content.earliest_secs(),
        "deadline": content.deadline_secs(),
        "destinations": content.stops().iter().enumerate().map(destination).collect::<Vec<_>>(),
        "history": order.history(),
    })
}

/// Returns a vehicle as the API shows it.
pub(super) fn vehicle(vehicle: &Vehicle, places: &Places) -> Value {
    json!({
        "name": vehicle.robot.to_string(),
        "state": vehicle.state,
        "activity": vehicle.activity,
        "currentPosition": vehicle.node.map(|node| places.label(node)),
        "edge": vehicle.edge,
        "position": vehicle.position,
        "energyLevel": vehicle.energy_level,
        "transportOrder": vehicle.transport_order,
    })
}
