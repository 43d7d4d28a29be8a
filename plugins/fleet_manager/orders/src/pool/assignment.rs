//! The assignment of open orders to robots, by the pool's [`Assigner`](crate::Assigner).

use super::{Candidate, Change, Held, Order, OrderId, OrderPool, State};
use crate::assign::{Limits, OpenOrder, Problem, allowed};

/// The seconds of driving that each step of priority is worth.
const PRIORITY_SECS: f64 = 30.0;
/// The seconds of driving that each second is worth that an order waits.
const AGE: f64 = 0.5;
/// An order is more urgent from so many seconds before its deadline on, by a second each second.
const BEFORE_DEADLINE_SECS: f64 = 600.0;
/// The simulated seconds after which orders that have a robot, but that it hasn't begun, may get
/// another one.
const REASSIGNMENT_SECS: f64 = 5.0;

/// The changes of an assignment. Withdrawals come before the assignments.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Assignments {
    /// Orders that were taken from their robots.
    pub withdrawn: Vec<(OrderId, u32)>,
    /// Orders that robots have got.
    pub assigned: Vec<(OrderId, u32)>,
}

impl OrderPool {
    /// Whether the next [`assign`](Self::assign) also reassigns orders whose robots haven't begun
    /// them. If not, only robots without an order can get one.
    pub fn is_reassignment_due(&self, now_secs: f64) -> bool {
        now_secs >= self.next_reassignment_secs
    }

    /// Assigns waiting orders to robots. `available` are the robots that may get an order, or
    /// another one. Robots that are at a stop, or have begun their order, are ignored. Orders that
    /// aren't begun are reassigned every few seconds. `driving_secs` returns how long a robot
    /// drives to a node, in seconds; `None` if it can't.
    pub fn assign(
        &mut self,
        now_secs: f64,
        available: &[Candidate],
        driving_secs: &dyn Fn(u32, u32) -> Option<f64>,
    ) -> Assignments {
        let is_reassignment = self.is_reassignment_due(now_secs);
        if is_reassignment {
            self.next_reassignment_secs = now_secs + REASSIGNMENT_SECS;
        }
        let mut robots = self.candidates(available, is_reassignment);
        let mut changes = self.assign_intended(&mut robots, now_secs, driving_secs);
        if robots.is_empty() {
            return changes;
        }
        let (orders, limits) = self.assignable(&robots, now_secs);
        let problem =
            Problem { now_secs, orders: &orders, robots: &robots, limits: &limits, driving_secs };
        let pairs = allowed(&problem, self.assigner.assign(&problem));
        self.carry_out(&orders, &pairs, now_secs, &mut changes);
        changes
    }

    /// Returns the robots without an order, and those that may get another one, by id.
    fn candidates(&self, available: &[Candidate], is_reassignment: bool) -> Vec<Candidate> {
        let mut robots = available.to_vec();
        robots.retain(|candidate| {
            match self.order_of(candidate.robot).and_then(|id| self.order(id)) {
                None => true,
                // An order for this robot alone stays with it.
                Some(order) if order.content.intended_robot.is_some() => false,
                Some(order) => {
                    is_reassignment
                        && !order.is_bound()
                        && order.state == State::Travelling(candidate.robot)
                }
            }
        });
        robots.sort_by_key(|candidate| candidate.robot);
        robots.dedup_by_key(|candidate| candidate.robot);
        robots
    }

    /// Returns the waiting orders, and those of the robots, by number, with the robot types that
    /// some of them are for.
    fn assignable(&self, robots: &[Candidate], now_secs: f64) -> (Vec<OpenOrder>, Limits) {
        let theirs = robots.iter().filter_map(|candidate| self.order_of(candidate.robot));
        let mut orders: Vec<_> = self.waiting.iter().copied().chain(theirs).collect();
        orders.sort_unstable();
        let orders = orders.iter().filter_map(|id| self.open.get(id));
        let (mut assignable, mut limits) = (Vec::new(), Limits::new());
        for order in orders.filter(|order| order.content.intended_robot.is_none()) {
            let types = &order.content.robot_types;
            if !types.is_empty() {
                limits.insert(order.id, types.clone());
            }
            assignable.push(self.open_order(order, now_secs));
        }
        (assignable, limits)
    }

    fn open_order(&self, order: &Order, now_secs: f64) -> OpenOrder {
        let node = order.content.stops[0].node;
        let nearness = match order.content.deadline_secs {
            Some(deadline) => (BEFORE_DEADLINE_SECS - (deadline - now_secs)).max(0.0),
            None => 0.0,
        };
        let urgency_secs = f64::from(order.content.priority) * PRIORITY_SECS
            + (now_secs - order.ready_secs()).max(0.0) * AGE
            + nearness;
        let position = self.places.place(node).position;
        OpenOrder { id: order.id, node, position, urgency_secs, robot: order.state.robot() }
    }

    fn carry_out(
        &mut self,
        orders: &[OpenOrder],
        pairs: &std::collections::BTreeMap<OrderId, u32>,
        now_secs: f64,
        changes: &mut Assignments,
    ) {
        for OpenOrder { id, robot, .. } in orders {
            if let Some(robot) = robot.filter(|robot| pairs.get(id) != Some(robot)) {
                changes.withdrawn.extend(self.withdraw(robot, now_secs).map(|id| (id, robot)));
            }
        }
        for OpenOrder { id, robot, .. } in orders {
            let new = pairs.get(id).filter(|new| *robot != Some(**new));
            if let Some(new) = new {
                self.give(*id, *new, now_secs);
                changes.assigned.push((*id, *new));
            }
        }
    }

    /// Gives a waiting order to a robot that has none.
    pub(super) fn give(&mut self, id: OrderId, robot: u32, now_secs: f64) {
        let Some(order) = self.open.get_mut(&id) else { return };
        order.state = State::Travelling(robot);
        self.waiting.remove(&id);
        self.by_robot.insert(robot, Held { id, is_bound: order.is_bound() });
        self.note(id, now_secs, Change::Assigned { robot });
    }

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
}
