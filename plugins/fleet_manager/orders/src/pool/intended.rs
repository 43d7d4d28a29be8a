//! Orders that only one robot may get: those that say so, and those by which a robot is sent
//! somewhere on request.

use super::{Assignments, Candidate, Change, NewOrder, OrderId, OrderName, OrderPool, State, Stop};
use crate::order::Action;

impl OrderPool {
    /// Gives robots the waiting orders that only they may get, the most urgent first. These robots
    /// are candidates no longer.
    pub(super) fn assign_intended(
        &mut self,
        robots: &mut Vec<Candidate>,
        now_secs: f64,
        driving_secs: &dyn Fn(u32, u32) -> Option<f64>,
    ) -> Assignments {
        let mut changes = Assignments::default();
        if self.intended.is_empty() {
            return changes;
        }
        robots.retain(|candidate| {
            let robot = candidate.robot;
            let Some(id) = self.next_intended(robot, driving_secs) else { return true };
            changes.withdrawn.extend(self.withdraw(robot, now_secs).map(|id| (id, robot)));
            self.give(id, robot, now_secs);
            changes.assigned.push((id, robot));
            false
        });
        changes
    }

    /// Returns the waiting order for a robot only that comes next: of the highest priority, then
    /// the oldest.
    fn next_intended(
        &self,
        robot: u32,
        driving_secs: &dyn Fn(u32, u32) -> Option<f64>,
    ) -> Option<OrderId> {
        let theirs = self.intended.range((robot, OrderId(0))..=(robot, OrderId(u64::MAX)));
        let waiting = theirs.map(|(_, id)| *id).filter(|id| self.waiting.contains(id));
        let orders = waiting.filter_map(|id| self.open.get(&id));
        let possible =
            orders.filter(|order| driving_secs(robot, order.content.stops[0].node).is_some());
        possible
            .max_by_key(|order| (order.content.priority, std::cmp::Reverse(order.id)))
            .map(|order| order.id)
    }

    /// Sends a robot to a node, in place of what it was sent for before. An order that it hasn't
    /// begun is taken from it; one that it has begun is finished first. `run_id` is that of the
    /// world. Returns the new order, and whether the robot is free for it now.
    pub fn send(&mut self, robot: u32, node: u32, run_id: u64, now_secs: f64) -> (OrderId, bool) {
        self.recall(robot, now_secs);
        let name = OrderName::of_request(robot, self.next_id, run_id);
        let stops = vec![Stop { node, action: Action::None, dwell_secs: 0.0 }];
        let content = NewOrder {
            name,
            stops,
            priority: u8::MAX,
            earliest_secs: 0.0,
            deadline_secs: None,
            intended_robot: Some(robot),
        };
        let id = OrderId(self.next_id);
        self.create(now_secs, now_secs, content);
        let is_free = self.order_of(robot).is_none() || self.withdraw(robot, now_secs).is_ok();
        (id, is_free)
    }

    /// Takes back what a robot was sent for. Returns whether it was sent anywhere.
    pub fn recall(&mut self, robot: u32, now_secs: f64) -> bool {
        let is_sent = |(other, id): &&(u32, OrderId)| {
            *other == robot
                && self.open.get(id).is_some_and(|order| order.content.name.is_of_request())
        };
        let sent: Vec<OrderId> = self.intended.iter().filter(is_sent).map(|(_, id)| *id).collect();
        for id in &sent {
            let holder = self.open.get(id).and_then(|order| order.state.robot());
            let change = Change::Cancelled { robot: holder, reason: "recalled".to_owned() };
            self.close(*id, State::Cancelled, now_secs, change);
        }
        !sent.is_empty()
    }
}
