//! The manager's part of charging: it carries out what [`charging`](crate::charging) decides.

use std::collections::BTreeMap;

use regatta_orders::{NewOrder, State};
use regatta_plugin::frame::RobotState;

use super::{Manager, Progress};
use crate::charging::{Charge, ChargeAction, Charging, Decision, Situation};

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

    /// Whether a robot's battery would last for it with a charge at a charger, from which it drives
    /// for some seconds to the first stop.
    fn is_affordable_with(&self, charging: &Charging, robot: (u32, Charge), secs: f64) -> bool {
        charging.would_suffice(robot, secs + self.driving_secs, self.standing_secs, self.last)
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
        for charger in self.charging.chargers() {
            self.times.prepare(&roads, charger);
        }
        self.for_full_batteries.retain(|id| self.orders.waiting_order(*id).is_some());
        self.charging.need_all(!self.for_full_batteries.is_empty());
        let situations: Vec<Situation> =
            self.present.iter().map(|&robot| self.situation(robot, states)).collect();
        let times = &self.times;
        let secs = |node: u32, goal: u32| times.between(&roads, node, goal);
        self.charging.measure(&secs);
        let decisions = self.charging.decide(now_secs, &roads, &situations, &secs).to_vec();
        for decision in decisions {
            self.carry_out(decision, now_secs);
        }
    }

    fn situation(&self, robot: u32, states: &[u8]) -> Situation {
        let goal = self.charging.goal(robot);
        Situation {
            robot,
            node: self.steering.base_end_node(robot),
            stop: self.orders.current_stop(robot).map(|stop| stop.node),
            is_bound: self.orders.is_bound(robot)
                || matches!(self.progress[robot as usize], Progress::AtStop(_)),
            has_arrived: goal.is_some_and(|node| self.steering.has_arrived(robot, node)),
            is_unreachable: goal.is_some() && self.steering.is_unreachable(robot),
            is_broken: states[robot as usize] == RobotState::Broken as u8,
        }
    }

    fn carry_out(&mut self, decision: Decision, now_secs: f64) {
        let Decision { robot, action } = decision;
        match action {
            ChargeAction::Go(node) => {
                self.take_order(robot, now_secs);
                self.steering.send(robot, node);
            }
            ChargeAction::Wait => self.take_order(robot, now_secs),
            ChargeAction::Stay => self.steering.stay(robot),
            ChargeAction::Free => self.steering.halt(robot),
            ChargeAction::Flat => {
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

    /// Returns the cost of orders after their first stops, by the node of that stop; none if no
    /// robot has a battery.
    pub(super) fn after_first_stops(&self) -> BTreeMap<u32, Rest> {
        let mut rests: BTreeMap<u32, Rest> = BTreeMap::new();
        if !self.charging.is_needed() {
            return rests;
        }
        let open = self.orders.open_orders();
        let orders =
            open.filter(|order| !matches!(order.state, State::Unplaced | State::Unroutable));
        for order in orders.filter(|order| !order.is_bound()) {
            let Some(first) = order.content.stops.first() else { continue };
            let Some(rest) = self.rest(&order.content) else { continue };
            let most = rests.entry(first.node).or_insert(rest);
            if rest.secs() > most.secs() {
                *most = rest;
            }
        }
        rests
    }

    /// Returns the cost of an order after its first stop; `None` if it has no stops.
    fn rest(&self, order: &NewOrder) -> Option<Rest> {
        let roads = self.steering.roads();
        let ways = order.stops.windows(2);
        let driving = ways.filter_map(|pair| self.times.between(roads, pair[0].node, pair[1].node));
        Some(Rest {
            driving_secs: driving.sum(),
            standing_secs: order.stops.iter().map(|stop| stop.dwell_secs).sum(),
            last: order.stops.last()?.node,
        })
    }

    /// Whether a robot is of a type that may get an order.
    fn may_get(&self, order: &NewOrder, robot: u32) -> bool {
        let types = &order.robot_types;
        types.is_empty() || types.contains(&self.robot_types[robot as usize])
    }

    /// Whether no robot can carry an order out even if it begins with some charge at the nearest
    /// charger. Nothing is said while a driving time isn't known.
    pub(super) fn exceeds_batteries(&self, order: &NewOrder, charge: Charge) -> bool {
        let is_known = order.stops.iter().all(|stop| self.times.knows(stop.node));
        if !(self.charging.is_needed() && self.charging.is_measured() && is_known) {
            return false;
        }
        let (Some(first), Some(rest)) = (order.stops.first(), self.rest(order)) else {
            return false;
        };
        let roads = self.steering.roads();
        let ways = self.charging.chargers();
        let ways = ways.filter_map(|charger| self.times.between(roads, charger, first.node));
        let Some(secs) = ways.min_by(f64::total_cmp) else { return false };
        let mut fitting = self.present.iter().filter(|robot| self.may_get(order, **robot));
        !fitting.any(|robot| rest.is_affordable_with(&self.charging, (*robot, charge), secs))
    }
}
