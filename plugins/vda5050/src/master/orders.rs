//! Orders, as a vehicle is told its course: the legs between two numbers, as nodes and edges.

use core::f64::consts::PI;

use regatta_base::graph::{Gear, Leg};
use regatta_plugin::world::Orientation;

use super::course::Course;
use super::roads::Roads;
use crate::message::{
    Action, AllowedDeviation, BlockingType, Edge, Node, NodePosition, Order, OrientationType,
};

/// The edges of the horizon that a vehicle is told.
const MOST_HORIZON: u64 = 10;

/// The part of a course that an order, or an update of one, tells.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// The id of the order.
    pub order_id: String,
    /// The number of the update.
    pub update_id: u32,
    /// The number of the leg after the first node of the order.
    pub start: u64,
    /// The number of the leg after the first node of this message.
    pub from: u64,
    /// The number of the leg after the base.
    pub base_end: u64,
    /// The action at the first node.
    pub action: Option<Action>,
    /// The first node as the vehicle names it, if it isn't by its own id.
    pub first_id: Option<String>,
    /// Metres from the first node within which the vehicle may be.
    pub deviation: Option<f64>,
}

impl Part {
    /// Returns the message, and whether it has a horizon. The headers are missing.
    pub fn order(&self, course: &Course, roads: &Roads) -> (Order, bool) {
        let mut nodes = vec![self.first_node(course, roads)];
        let mut edges = Vec::new();
        let end = self.base_end + MOST_HORIZON;
        for number in self.from..end {
            let Some(leg) = course.leg(number) else { break };
            let released = number < self.base_end;
            edges.push(Edge { released, sequence_id: self.place(number) + 1, ..edge(leg, roads) });
            let place = self.place(number) + 2;
            nodes.push(node(roads.end(leg), place, released, roads));
        }
        if let (Some(edge), Some(first)) = (edges.first_mut(), nodes.first()) {
            edge.start_node_id = Some(first.node_id.clone());
        }
        let has_horizon = nodes.iter().any(|node| !node.released);
        let order = Order {
            order_id: self.order_id.clone(),
            order_update_id: self.update_id,
            nodes,
            edges,
            ..Order::default()
        };
        (order, has_horizon)
    }

    /// The sequence id of the node before the leg with a number.
    fn place(&self, number: u64) -> u32 {
        2 * (number - self.start) as u32
    }

    fn first_node(&self, course: &Course, roads: &Roads) -> Node {
        let index = match course.leg(self.from) {
            Some(leg) => roads.start(leg),
            None => {
                let before = course.leg(self.from.saturating_sub(1));
                roads.end(before.unwrap_or(course.place().0))
            }
        };
        let mut first = node(index, self.place(self.from), true, roads);
        if let Some(id) = &self.first_id {
            first.node_id.clone_from(id);
        }
        if let Some(position) = &mut first.node_position {
            position.allowed_deviation = self.deviation.map(AllowedDeviation::Radius);
        }
        first.actions.extend(self.action.clone());
        first
    }
}

fn node(index: u32, sequence_id: u32, released: bool, roads: &Roads) -> Node {
    let place = roads.node(index);
    let position = NodePosition {
        x: place.x,
        y: place.y,
        map_id: place.map_id.clone(),
        ..NodePosition::default()
    };
    Node {
        node_id: place.id.clone(),
        sequence_id,
        released,
        node_position: Some(position),
        ..Node::default()
    }
}

fn edge(leg: Leg, roads: &Roads) -> Edge {
    let road = roads.edge(leg);
    let ends = [roads.start(leg), roads.end(leg)].map(|end| Some(roads.node(end).id.clone()));
    let [start_node_id, end_node_id] = ends;
    let (orientation, orientation_type) = orientation(leg.gear, road.orientation).unzip();
    let speed = if leg.gear == Gear::Forward { road.speed } else { road.reverse_speed };
    Edge {
        edge_id: road.id.clone(),
        start_node_id,
        end_node_id,
        maximum_speed: Some(speed).filter(|speed| speed.is_finite()),
        orientation,
        orientation_type,
        ..Edge::default()
    }
}

/// The orientation of robots on an edge, if it isn't along the way.
fn orientation(gear: Gear, of_edge: Orientation) -> Option<(f64, OrientationType)> {
    let turned = if gear == Gear::Reverse { PI } else { 0.0 };
    match of_edge {
        Orientation::Fixed(heading) => Some((f64::from(heading), OrientationType::Global)),
        Orientation::Tangential if gear == Gear::Forward => None,
        Orientation::Tangential => Some((turned, OrientationType::Tangential)),
        Orientation::Offset(offset) => {
            let angle = (f64::from(offset) + turned + PI).rem_euclid(2.0 * PI) - PI;
            Some((angle, OrientationType::Tangential))
        }
    }
}

/// An action of an order, which nothing else may go on beside.
pub fn action(action_type: &str, action_id: String) -> Action {
    Action {
        action_type: action_type.to_owned(),
        action_id,
        blocking_type: BlockingType::Hard,
        ..Action::default()
    }
}
