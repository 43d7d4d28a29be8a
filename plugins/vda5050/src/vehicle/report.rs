//! The state of a vehicle as a message.

use core::f64::consts::PI;

use regatta_base::graph::Gear;
use regatta_plugin::frame::RobotState;

use super::jobs::{Job, Paused};
use super::progress::Step;
use super::{Charging, Seen, Site, Vehicle};
use crate::message::{
    EdgeState, Header, NodeState, Position, PowerSupply, State, Velocity, Visualization,
};

/// The distance to the end of the base below which a vehicle asks for more of it, in seconds of
/// driving; and at least so many metres.
const SHORT_SECONDS: f64 = 3.0;
const SHORT_METRES: f64 = 1.0;

/// Rounds metres, radians and the like to millionths: more than that is noise of 32 bits.
fn rounded(value: f64) -> f64 {
    (value * 1e6).round() / 1e6
}

/// Rounds a heading, but not to more than π, as π itself would be.
fn heading(theta: f64) -> f64 {
    let most = (PI * 1e6).floor() / 1e6;
    rounded(theta).clamp(-most, most)
}

impl Vehicle {
    /// Returns the state of the vehicle, with a header.
    pub fn state(&self, header: Header, site: &Site) -> State {
        let order = self.order.as_ref().map(|held| &held.last);
        State {
            header,
            order_id: order.map(|order| order.order_id.clone()).unwrap_or_default(),
            order_update_id: order.map_or(0, |order| order.order_update_id),
            zone_set_id: order.and_then(|order| order.zone_set_id.clone()),
            last_node_id: self.progress.last_node_id.clone(),
            last_node_sequence_id: self.progress.last_sequence_id,
            node_states: self.progress.steps.iter().map(Step::node_state).collect(),
            edge_states: self.progress.steps.iter().map(Step::edge_state).collect(),
            mobile_robot_position: self.position(site),
            velocity: self.seen.as_ref().map(Seen::velocity),
            loads: Some(self.loads.clone()),
            driving: self.seen.as_ref().is_some_and(Seen::is_driving),
            paused: Some(self.is_paused()),
            new_base_request: Some(self.needs_base(site)),
            distance_since_last_node: self.distance_since_last_node(site),
            action_states: self.jobs.iter().map(Job::state).collect(),
            instant_action_states: Some(self.instants.iter().map(Job::state).collect()),
            power_supply: self.power_supply(),
            operating_mode: self.condition.operating_mode(),
            errors: self.faults.iter().map(|fault| fault.report(self.version)).collect(),
            information: None,
            safety_state: self.condition.safety_state(),
        }
    }

    /// Returns the position of the vehicle for those who watch. `state_id` is the number of its
    /// last state.
    pub fn visualization(&self, header: Header, state_id: u32, site: &Site) -> Visualization {
        Visualization {
            header,
            reference_state_header_id: Some(state_id),
            mobile_robot_position: self.position(site),
            velocity: self.seen.as_ref().map(Seen::velocity),
        }
    }

    fn position(&self, site: &Site) -> Option<Position> {
        let seen = self.seen?;
        let node = match seen.edge.and_then(|edge| site.map.edge(edge)) {
            Some(road) => Some(road.origin),
            None => self.here,
        };
        let node = node.and_then(|node| site.map.node(node)).or(site.map.nodes().first());
        Some(Position {
            x: rounded(seen.x),
            y: rounded(seen.y),
            theta: heading(seen.theta),
            map_id: node.map(|node| node.map_id.clone()).unwrap_or_default(),
            localized: self.condition.is_localized(),
            localization_score: None,
            deviation_range: None,
        })
    }

    /// Whether the vehicle is paused: while it still brakes, the pause only begins (2.x: 6.8.2;
    /// 3.0: 6.2.3.2).
    fn is_paused(&self) -> bool {
        let stands = self.seen.is_none_or(|seen| !seen.is_driving());
        let is_held = self.seen.is_some_and(|seen| seen.state == RobotState::Held);
        match self.paused {
            Paused::Yes => stands,
            Paused::Ending => false,
            Paused::No => is_held && stands,
        }
    }

    /// Whether the base comes to its end while there is a horizon (2.x: 6.10.3; 3.0: 6.6.3).
    pub(super) fn needs_base(&self, site: &Site) -> bool {
        let released = self.progress.released();
        let Some(seen) = self.seen.filter(|_| released < self.progress.steps.len()) else {
            return false;
        };
        let base = self.progress.steps.iter().take(released);
        let length: f64 = base.filter_map(|step| step.length(site)).sum();
        let driven = self.distance_since_last_node(site).unwrap_or(0.0);
        length - driven <= SHORT_METRES.max(seen.speed.abs() * SHORT_SECONDS)
    }

    fn distance_since_last_node(&self, site: &Site) -> Option<f64> {
        let seen = self.seen?;
        let step = self.progress.steps.front();
        let leg = step.and_then(|step| step.leg).filter(|leg| Some(leg.edge.0) == seen.edge);
        let road = leg.and_then(|leg| site.map.edge(leg.edge.0));
        Some(match (leg.map(|leg| leg.gear), road) {
            (Some(Gear::Forward), _) => rounded(seen.s.max(0.0)),
            (Some(Gear::Reverse), Some(road)) => rounded((road.length - seen.s).max(0.0)),
            _ => 0.0,
        })
    }

    /// A vehicle without a battery is always full.
    fn power_supply(&self) -> PowerSupply {
        let charge = self.seen.and_then(|seen| seen.charge).unwrap_or(100.0);
        let charging = self.charging == Charging::Yes && self.here.is_some();
        PowerSupply { state_of_charge: charge.clamp(0.0, 100.0), charging }
    }
}

impl Step {
    fn length(&self, site: &Site) -> Option<f64> {
        Some(site.map.edge(self.leg?.edge.0)?.length)
    }

    fn node_state(&self) -> NodeState {
        let node = &self.node;
        NodeState {
            node_id: node.node_id.clone(),
            sequence_id: node.sequence_id,
            node_descriptor: node.node_descriptor.clone(),
            released: node.released,
            node_position: node.node_position.clone(),
        }
    }

    fn edge_state(&self) -> EdgeState {
        let edge = &self.edge;
        EdgeState {
            edge_id: edge.edge_id.clone(),
            sequence_id: edge.sequence_id,
            edge_descriptor: edge.edge_descriptor.clone(),
            released: edge.released,
            trajectory: None,
        }
    }
}

impl Seen {
    fn velocity(&self) -> Velocity {
        Velocity { vx: Some(rounded(self.speed)), vy: Some(0.0), omega: None }
    }
}
