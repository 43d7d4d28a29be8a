//! A vehicle by the clauses of the standard. The engine is played by the tests.

mod actions;
mod cancelling;
mod disturbed;
mod orders;
mod rejections;

use regatta_plugin::frame::RobotState;
use regatta_plugin::world::{EdgeRecord, NodeRecord, Role, WorldData};
use serde_json::{Value, json};

use super::*;
use crate::message::{Header, InstantActions, Order, State, decode};

/// A row of nodes A, B, C, D, 10 m apart, with edges both ways; the one from D to C can be driven
/// in reverse gear only. At D is a charger.
fn site() -> Site {
    let mut world = WorldData::default();
    for (name, number) in ["A", "B", "C", "D"].into_iter().zip(1..) {
        let role = if name == "D" { Role::Charge } else { Role::None };
        let (id, x, name) = (number, 10.0 * (number - 1) as f32, world.texts.add(name));
        world.nodes.push(NodeRecord { id, x, name, role: role as u32, ..Default::default() });
    }
    let ways = [("AB", 0, 1), ("BA", 1, 0), ("BC", 1, 2), ("CB", 2, 1), ("CD", 2, 3)];
    for ((name, origin, destination), id) in ways.into_iter().zip(1..) {
        let (name, length) = (world.texts.add(name), 10.0);
        let reverse_speed = if id == 5 { 0.5 } else { 0.0 };
        let edge = EdgeRecord { id, origin, destination, length, name, ..Default::default() };
        world.add_edge(EdgeRecord { speed: 1.0, reverse_speed, ..edge }, []);
    }
    Site { map: Map::of(&world.view(1, 1), "map"), catalogue: Catalogue::default() }
}

/// A vehicle, and the time.
struct Trial {
    site: Site,
    vehicle: Vehicle,
    time: f64,
    /// The node at which its robot stands or was last.
    x: f64,
    commands: Vec<Command>,
}

impl Trial {
    /// A vehicle at A.
    fn new(version: Version) -> Self {
        let (site, vehicle) = (site(), Vehicle::new(version));
        let mut trial = Self { site, vehicle, time: 0.0, x: 0.0, commands: Vec::new() };
        trial.stand();
        trial.commands.clear();
        trial
    }

    fn see(&mut self, speed: f64, state: RobotState) {
        let edge = None;
        let (time, x) = (self.time, self.x);
        let seen = Seen { time, x, y: 0.0, theta: 0.0, speed, s: 0.0, edge, state, charge: None };
        self.vehicle.see(seen, &self.site);
        self.commands.extend(self.vehicle.take_outbox().commands);
    }

    /// The robot stands for a tick.
    fn stand(&mut self) {
        self.see(0.0, RobotState::Idle);
    }

    /// The robot stands for so many seconds.
    fn wait(&mut self, seconds: f64) {
        self.time += seconds;
        self.stand();
    }

    /// The robot is under way.
    fn drive(&mut self) {
        self.time += 1.0;
        self.see(1.0, RobotState::Driving);
    }

    /// The robot reaches a node, and stands there.
    fn reach(&mut self, node: &str) {
        self.drive();
        self.pass(node);
        self.stand();
    }

    /// The robot passes a node.
    fn pass(&mut self, node: &str) {
        let place = self.site.map.find_node(node).expect("a node");
        let place = self.site.map.node(place).expect("a node");
        self.x = place.x;
        self.vehicle.reached(place.number, &self.site);
        self.commands.extend(self.vehicle.take_outbox().commands);
    }

    fn order(&mut self, order: &Value) -> &mut Self {
        let order = decode::<Order>(order.to_string().as_bytes()).expect("an order");
        self.vehicle.take_order(order, &self.site);
        self.commands.extend(self.vehicle.take_outbox().commands);
        self
    }

    fn instant(&mut self, id: &str, kind: &str, parameters: Value) -> &mut Self {
        let action = json!({"actionId": id, "actionType": kind, "blockingType": "NONE",
            "actionParameters": parameters});
        let message = json!({"actions": [action]}).to_string();
        let actions = decode::<InstantActions>(message.as_bytes()).expect("actions");
        self.vehicle.take_instant_actions(actions, &self.site);
        self.commands.extend(self.vehicle.take_outbox().commands);
        self
    }

    fn state(&self) -> State {
        self.vehicle.state(Header::default(), &self.site)
    }

    /// The errors: types and levels.
    fn errors(&self) -> Vec<(String, String)> {
        let errors = self.state().errors.into_iter();
        errors.map(|error| (error.error_type, format!("{:?}", error.error_level))).collect()
    }

    /// The status of an action, of the order or not.
    fn status(&self, id: &str) -> String {
        let state = self.state();
        let mut all =
            state.action_states.iter().chain(state.instant_action_states.iter().flatten());
        let found = all.find(|action| action.action_id == id);
        found.map_or("none".to_owned(), |action| format!("{:?}", action.action_status))
    }

    /// The ids of the nodes ahead, those of the horizon in brackets.
    fn ahead(&self) -> String {
        let nodes = self.state().node_states.into_iter();
        let texts = nodes.map(|node| match node.released {
            true => node.node_id,
            false => format!("({})", node.node_id),
        });
        texts.collect::<Vec<_>>().join(" ")
    }

    /// The legs of the last command to drive: numbers of edges, those of the horizon negative.
    fn last_legs(&self) -> Vec<i32> {
        let legs = self.commands.iter().rev().find_map(|command| match command {
            Command::Extend(legs) => Some(legs.clone()),
            _ => None,
        });
        let legs = legs.unwrap_or_default().into_iter();
        legs.map(|leg| leg.edge as i32 * if leg.released { 1 } else { -1 }).collect()
    }
}

/// An order along nodes from a place on. Those after `|` are horizon; `B:x,HARD` has an action.
fn order(id: &str, update: u32, first: u32, text: &str) -> Value {
    let (mut released, mut nodes, mut edges) = (true, Vec::new(), Vec::<Value>::new());
    let mut before = String::new();
    for word in text.split_whitespace() {
        if word == "|" {
            released = false;
            continue;
        }
        let (node, action) = word.split_once(':').unwrap_or((word, ""));
        let place = first + 2 * nodes.len() as u32;
        if !before.is_empty() {
            edges.push(json!({"edgeId": edge(&before, node), "sequenceId": place - 1,
                "released": released, "actions": []}));
        }
        nodes.push(json!({"nodeId": node, "sequenceId": place, "released": released,
            "actions": actions(action)}));
        before = node.to_owned();
    }
    json!({"orderId": id, "orderUpdateId": update, "nodes": nodes, "edges": edges})
}

/// The edge between two nodes of the row.
fn edge(from: &str, to: &str) -> String {
    if (from, to) == ("D", "C") { "CD".to_owned() } else { format!("{from}{to}") }
}

/// Actions from a text: `a,pick,HARD;b,drop,NONE`.
fn actions(text: &str) -> Value {
    let actions = text.split(';').filter(|text| !text.is_empty()).map(|text| {
        let mut words = text.split(',');
        let mut word = || words.next().expect("id,type,blocking");
        json!({"actionId": word(), "actionType": word(), "blockingType": word()})
    });
    Value::Array(actions.collect())
}
