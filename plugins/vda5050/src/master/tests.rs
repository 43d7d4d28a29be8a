//! Tests of the master, and the small plants that they use.

mod course;
mod faults;
mod orders;

use regatta_plugin::event::EventKind;
use regatta_plugin::frame::RobotState;
use serde_json::{Value, json};

use super::course::Step;
use super::roads::Roads;
use super::talk::Saying;
use super::vehicle::{Limits, Row, Vehicle};
use crate::message::{Order, State, decode};
use regatta_plugin::world::{CurveRecord, EdgeRecord, NodeRecord, RobotTypeRecord, WorldData};

/// A line of `nodes` nodes, 5 m apart, with the numbers 1, 2, 3 … and the names N1, N2, N3 …; the
/// edges between them have the numbers 10, 11 …, and its origin is at (100, 200). Also returns the
/// names of the nodes.
pub(super) fn line(nodes: u32) -> (WorldData, Vec<String>) {
    let mut world = WorldData { origin: [100.0, 200.0], ..WorldData::default() };
    let names: Vec<String> = (1..=nodes).map(|number| format!("N{number}")).collect();
    for (id, name) in (1..).zip(&names) {
        let name = world.texts.add(name);
        let x = 5.0 * (id - 1) as f32;
        world.nodes.push(NodeRecord { id, name, x, ..NodeRecord::default() });
    }
    for origin in 0..nodes - 1 {
        let destination = origin + 1;
        let (length, speed, id) = (5.0, 1.0, 10 + origin);
        let edge = EdgeRecord { id, origin, destination, length, speed, ..EdgeRecord::default() };
        let ends = [origin, destination].map(|node| [5.0 * node as f32, 0.0]);
        world.add_edge(edge, [CurveRecord::straight(ends[0], ends[1])]);
    }
    world.robot_types.push(RobotTypeRecord::new("amr", 0.8, 0.6));
    (world, names)
}

/// The limits of the tests.
const LIMITS: Limits = Limits { tolerance: 0.5, silence: 35.0 };

/// A vehicle at N1 of a line of nodes, and the time.
struct Trial {
    roads: Roads,
    vehicle: Vehicle,
    now: f64,
    state: Value,
}

impl Trial {
    /// A vehicle that has told its state and its size.
    fn new(nodes: u32) -> Self {
        let roads = Roads::of(&line(nodes).0.view(1, 1), "map");
        let vehicle = Vehicle::new("run-0".to_owned());
        let state = json!({"orderId": "", "orderUpdateId": 0, "lastNodeId": "N1",
            "lastNodeSequenceId": 0, "nodeStates": [], "edgeStates": [], "driving": false,
            "actionStates": [], "batteryState": {"batteryCharge": 80.0, "charging": false},
            "operatingMode": "AUTOMATIC", "errors": [],
            "agvPosition": {"x": 100.0, "y": 200.0, "theta": 0.0, "mapId": "map",
                "positionInitialized": true},
            "safetyState": {"eStop": "NONE", "fieldViolation": false}});
        let mut trial = Self { roads, vehicle, now: 0.0, state };
        trial.tell(json!({}));
        trial
    }

    /// The vehicle tells its state, with some fields changed.
    fn tell(&mut self, changes: Value) -> &mut Self {
        for (key, value) in changes.as_object().expect("an object") {
            self.state[key] = value.clone();
        }
        let state: State = decode(self.state.to_string().as_bytes()).expect("a state");
        self.vehicle.take_state(state, &self.roads, LIMITS, self.now);
        self.vehicle.look(LIMITS, self.now);
        self
    }

    /// The position of a vehicle so many metres from N1.
    fn at(metres: f64) -> Value {
        json!({"x": 100.0 + metres, "y": 200.0, "theta": 0.0, "mapId": "map",
            "positionInitialized": true})
    }

    /// The next seconds pass.
    fn wait(&mut self, seconds: f64) -> &mut Self {
        self.now += seconds;
        self.vehicle.look(LIMITS, self.now);
        self
    }

    fn say(&mut self) -> Option<Saying> {
        self.vehicle.say(&self.roads, |_| false, self.now)
    }

    /// The next message, which is an order.
    fn order(&mut self) -> Order {
        match self.say() {
            Some(Saying::Order(order)) => order,
            other => panic!("no order: {other:?}"),
        }
    }

    /// The kind of the next message, which is an instant action, and its id.
    fn instant(&mut self) -> (String, String) {
        match self.say() {
            Some(Saying::Instant(action)) => (action.action_type, action.action_id),
            other => panic!("no action: {other:?}"),
        }
    }

    /// Gives it a route along the edges with numbers, which is released up to the first of them.
    fn route(&mut self, edges: &[u32], released: usize) -> &mut Self {
        let legs = edges.iter().enumerate().map(|(place, edge)| Step {
            leg: self.roads.leg(*edge, false).expect("an edge"),
            released: place < released,
        });
        let legs: Vec<Step> = legs.collect();
        let course = self.vehicle.course_mut().expect("a place");
        course.extend(&legs, &self.roads).expect("a route");
        self
    }

    /// Releases its route up to an edge.
    fn release(&mut self, edge: u32) -> &mut Self {
        let leg = self.roads.leg(edge, false).expect("an edge");
        let course = self.vehicle.course_mut().expect("a place");
        course.release(leg, f64::INFINITY, &self.roads).expect("it is ahead");
        self
    }

    /// The vehicle takes an order: its state shows it.
    fn take(&mut self, order: &Order) -> &mut Self {
        let nodes: Vec<Value> = order.nodes[1..]
            .iter()
            .map(|node| {
                json!({"nodeId": node.node_id, "sequenceId": node.sequence_id,
                "released": node.released})
            })
            .collect();
        self.tell(json!({"orderId": order.order_id, "orderUpdateId": order.order_update_id,
            "lastNodeSequenceId": order.nodes[0].sequence_id, "nodeStates": nodes}))
    }

    fn row(&mut self) -> Row {
        self.vehicle.row(&self.roads).expect("a vehicle")
    }

    fn shown(&mut self) -> RobotState {
        self.row().state
    }

    /// The edge that it is on, and the metres from its origin.
    fn place(&mut self) -> (u32, f64) {
        self.row().place.expect("a place")
    }

    /// The kinds of the events since the last call.
    fn events(&mut self) -> Vec<EventKind> {
        self.vehicle.take_events().iter().filter_map(|event| event.kind()).collect()
    }
}

/// The nodes of an order, and whether they are released.
fn nodes(order: &Order) -> Vec<(&str, u32, bool)> {
    let nodes = order.nodes.iter();
    nodes.map(|node| (node.node_id.as_str(), node.sequence_id, node.released)).collect()
}
