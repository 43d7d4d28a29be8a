//! The manager's part of charging: it carries out what [`charging`](crate::charging) decides.

use std::collections::BTreeMap;

use regatta_plugin::frame::RobotState;

use super::{Errand, Manager};
use crate::charging::{Charging, Decision, Situation};

/// The cost of an order after its first stop: the largest of all orders with that stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Rest {
    /// Seconds of driving on empty roads, from the first stop to the last.
    driving_secs: f64,
    /// Seconds at stops.
    standing_secs: f64,
    /// The node of the last stop.
    last: u32,
}

impl Rest {
    /// Whether a robot's battery lasts for it, after some seconds of driving to the first stop.
    pub fn is_affordable(&self, charging: &Charging, robot: u32, secs: f64) -> bool {
        charging.suffices(robot, secs + self.driving_secs, self.standing_secs, self.last)
    }

    fn secs(&self) -> f64 {
        self.driving_secs + self.standing_secs
    }
}

impl Manager {
    /// Sends robots to chargers, and lets them go.
    pub(super) fn charge(&mut self, now_secs: f64, states: &[u8]) {
        if !self.charging.is_needed() {
            return;
        }
        let roads = self.steering.roads().clone();
        self.charging.chargers().for_each(|charger| self.times.prepare(&roads, charger));
        let situations: Vec<Situation> =
            self.present.iter().map(|&robot| self.situation(robot, states)).collect();
        let times = &self.times;
        let secs = |node: u32, goal: u32| times.between(&roads, node, goal);
        self.charging.measure(&secs);
        let decisions = self.charging.decide(now_secs, &roads, &situations, &secs).to_vec();
        decisions.into_iter().for_each(|decision| self.carry_out(decision, now_secs));
    }

    fn situation(&self, robot: u32, states: &[u8]) -> Situation {
        let goal = self.charging.goal(robot);
        Situation {
            robot,
            node: self.steering.base_end_node(robot),
            stop: self.orders.current_stop(robot).map(|stop| stop.node),
            is_bound: self.orders.is_bound(robot)
                || matches!(self.errands[robot as usize], Errand::Handling(_)),
            has_arrived: goal.is_some_and(|node| self.steering.has_arrived(robot, node)),
            is_unreachable: goal.is_some() && self.steering.is_unreachable(robot),
            is_broken: states[robot as usize] == RobotState::Broken as u8,
        }
    }

    fn carry_out(&mut self, decision: Decision, now_secs: f64) {
        match decision {
            Decision::Go { robot, node } => {
                self.take_order(robot, now_secs);
                self.steering.send(robot, node);
            }
            Decision::Wait { robot } => self.take_order(robot, now_secs),
            Decision::Stay { robot } => self.steering.stay(robot),
            Decision::Free { robot } => self.steering.halt(robot),
            Decision::Flat { robot } => {
                if self.orders.withdraw(robot, now_secs).is_err() {
                    self.orders.failed(robot, now_secs, "the robot's battery is flat");
                }
                self.halt(robot);
            }
        }
    }

    /// Takes the order from a robot that hasn't begun it.
    fn take_order(&mut self, robot: u32, now_secs: f64) {
        // Without an order there is nothing to take.
        let _ = self.orders.withdraw(robot, now_secs);
        self.halt(robot);
    }

    /// Returns what orders cost after their first stops, by the node of that stop; nothing if it
    /// doesn't matter.
    pub(super) fn after_first_stops(&self) -> BTreeMap<u32, Rest> {
        let mut rests: BTreeMap<u32, Rest> = BTreeMap::new();
        if !self.charging.is_needed() {
            return rests;
        }
        let roads = self.steering.roads();
        for order in self.orders.open_orders().filter(|order| !order.is_bound()) {
            let stops = &order.content.stops;
            let (Some(first), Some(last)) = (stops.first(), stops.last()) else { continue };
            let driving = |pair: &[regatta_orders::Stop]| {
                self.times.between(roads, pair[0].node, pair[1].node)
            };
            let rest = Rest {
                driving_secs: stops.windows(2).filter_map(driving).sum(),
                standing_secs: stops.iter().map(|stop| stop.dwell_secs).sum(),
                last: last.node,
            };
            rests
                .entry(first.node)
                .and_modify(|most| {
                    if rest.secs() > most.secs() {
                        *most = rest
                    }
                })
                .or_insert(rest);
        }
        rests
    }
}
