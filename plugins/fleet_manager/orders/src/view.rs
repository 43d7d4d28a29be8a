//! Orders and vehicles as the web API shows them: as JSON, in the shape of openTCS's web API.
//!
//! The fields are in the order of the alphabet, as they are in answers. All times are in seconds of
//! simulated time, of the run in which something happened.

use regatta_plugin::activity::Activity;
use serde::Serialize;
use serde_json::Value;
use utoipa::ToSchema;
use utoipa::openapi::schema::{Object, ObjectBuilder, Type};

use super::order::{Action, Order, OrderName, State};
use super::places::Places;
use super::threads::{ABSENT, Vehicle};

/// A page of orders, in the order of their names.
pub(crate) struct Page {
    /// `open`, a state, or any.
    pub(crate) state: Option<String>,
    /// Only names after this one.
    pub(crate) after: Option<OrderName>,
    /// The largest number of orders.
    pub(crate) limit: usize,
}

#[derive(Debug, Serialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub(super) struct TransportOrder {
    /// when it came
    pub(super) created: Option<f64>,
    pub(super) deadline: Option<f64>,
    #[schema(value_type = Vec<Object>)]
    pub(super) destinations: Vec<Destination>,
    pub(super) earliest_start: f64,
    #[schema(value_type = Vec<Object>)]
    pub(super) history: Vec<Value>,
    pub(super) intended_vehicle: Option<String>,
    pub(super) name: String,
    pub(super) priority: u8,
    pub(super) processing_vehicle: Option<String>,
    pub(super) reason: String,
    /// names of the robot types that may get it; any may if empty
    pub(super) robot_types: Vec<String>,
    #[schema(schema_with = order_states)]
    pub(super) state: String,
}

/// A stop of an order.
#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Destination {
    pub(super) dwell: f64,
    pub(super) location_name: String,
    pub(super) node: u32,
    pub(super) operation: Action,
    pub(super) state: &'static str,
}

impl TransportOrder {
    /// Returns an order of the pool.
    pub(super) fn new(order: &Order, places: &Places) -> Self {
        let content = &order.content;
        let mut destinations = Vec::with_capacity(content.stops.len());
        for (index, stop) in content.stops.iter().enumerate() {
            let state = match order.state {
                _ if index < order.handled_stops => "finished",
                State::Travelling(_) if index == order.handled_stops => "travelling",
                State::Handling(_) if index == order.handled_stops => "handling",
                _ => "pristine",
            };
            destinations.push(Destination {
                dwell: stop.dwell_secs,
                location_name: places.label(stop.node),
                node: places.place(stop.node).id,
                operation: stop.action,
                state,
            });
        }
        // An entry of the history has numbers and texts only: it is always valid JSON.
        let history = order.history.iter().map(serde_json::to_value);
        Self {
            created: Some(order.created_secs),
            deadline: content.deadline_secs,
            destinations,
            earliest_start: content.earliest_secs,
            history: history.map(Result::unwrap_or_default).collect(),
            intended_vehicle: content.intended_robot.map(|robot| robot.to_string()),
            name: content.name.to_string(),
            priority: content.priority,
            processing_vehicle: order.state.robot().map(|robot| robot.to_string()),
            reason: order.reason.clone(),
            robot_types: places.robot_type_names(&content.robot_types),
            state: order.state.name().to_owned(),
        }
    }
}

/// A robot; looked at about once a second.
#[derive(Debug, Serialize, ToSchema)]
#[serde(rename_all = "camelCase")]
#[schema(as = Vehicle)]
pub(super) struct VehicleView {
    #[schema(schema_with = activities)]
    activity: &'static str,
    /// name or id of the node that it reached last
    current_position: Option<String>,
    /// id of the edge that it is on
    edge: Option<u32>,
    /// charge of its battery in per cent
    #[schema(minimum = 0, maximum = 100)]
    energy_level: Option<u8>,
    /// the robot's id
    name: String,
    /// metres east and north of the world's origin
    #[schema(min_items = 2, max_items = 2)]
    position: [f64; 2],
    #[schema(schema_with = robot_states)]
    state: &'static str,
    transport_order: Option<String>,
}

impl VehicleView {
    pub(super) fn new(vehicle: &Vehicle, places: &Places) -> Self {
        Self {
            activity: vehicle.activity,
            current_position: vehicle.node.map(|node| places.label(node)),
            edge: vehicle.edge,
            energy_level: vehicle.energy_level,
            name: vehicle.robot.to_string(),
            position: vehicle.position.as_dvec2().to_array(),
            state: vehicle.state,
            transport_order: vehicle.transport_order.as_ref().map(ToString::to_string),
        }
    }
}

fn one_of(names: &[&str]) -> ObjectBuilder {
    ObjectBuilder::new().schema_type(Type::String).enum_values(Some(names.iter().copied()))
}

fn order_states() -> Object {
    one_of(State::NAMES).build()
}

fn activities() -> Object {
    one_of(&Activity::ALL.map(Activity::name)).build()
}

fn robot_states() -> Object {
    let names =
        ["idle", "driving", "waiting", "held", "faulted", "turning", "stalled", "broken", ABSENT];
    let note = "absent only in the event of one that has left";
    one_of(&names).description(Some(note)).build()
}
