//! The assignment of orders to robots.

use std::cmp::Ordering;
use std::collections::{BTreeMap, BTreeSet, VecDeque};

use glam::Vec2;
use pathfinding::kuhn_munkres::kuhn_munkres;
use pathfinding::matrix::Matrix;

use super::order::OrderId;

/// An order that no robot has begun.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OpenOrder {
    /// The order.
    pub id: OrderId,
    /// The node of its first stop.
    pub node: u32,
    /// Metres east and north of the world's origin.
    pub position: Vec2,
    /// The seconds of driving that its priority, age and deadline are worth.
    pub urgency_secs: f64,
    /// The robot that has it, and would lose it to another one.
    pub robot: Option<u32>,
}

/// The robot types that may get an order, by order. Any robot may get an order that isn't here.
pub type Limits = BTreeMap<OrderId, Vec<u32>>;

/// A robot that may get an order.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Candidate {
    /// The robot's id.
    pub robot: u32,
    /// Its type, as an index of the world's robot types.
    pub robot_type: u32,
    /// Metres east and north of the world's origin.
    pub position: Vec2,
}

/// An assignment problem. Orders are in ascending order of their numbers, robots of their ids.
#[derive(Clone, Copy)]
pub struct Problem<'call> {
    /// Simulated time in seconds.
    pub now_secs: f64,
    /// The orders.
    pub orders: &'call [OpenOrder],
    /// The robots.
    pub robots: &'call [Candidate],
    /// The robot types of orders that not any robot may get.
    pub limits: &'call Limits,
    /// Returns the driving time of a robot to a node, in seconds; `None` if it can't drive there.
    pub driving_secs: &'call dyn Fn(u32, u32) -> Option<f64>,
}

impl Problem<'_> {
    /// Whether a robot is one of the problem.
    fn has(&self, robot: u32) -> bool {
        self.robots.binary_search_by_key(&robot, |candidate| candidate.robot).is_ok()
    }

    /// Whether a robot of the problem may get an order, by its type.
    pub fn may_get(&self, id: OrderId, robot: u32) -> bool {
        let Some(types) = self.limits.get(&id) else { return true };
        let found = self.robots.binary_search_by_key(&robot, |candidate| candidate.robot);
        found.is_ok_and(|index| types.contains(&self.robots[index].robot_type))
    }
}

/// Decides which robot gets which order. A user's own is any type with this trait.
pub trait Assigner: Send {
    /// Returns pairs of an order and a robot of the problem. An order that has a robot, and isn't
    /// in a pair with it, is taken from it. Pairs that name an order or a robot for a second time,
    /// or that the problem doesn't have, are ignored, and so are those of an order and a robot that
    /// [may not get it](Problem::may_get).
    ///
    /// The same calls must have the same results, or runs in lockstep differ.
    fn assign(&mut self, problem: &Problem) -> Vec<(OrderId, u32)>;
}

impl Default for Box<dyn Assigner> {
    fn default() -> Self {
        Box::new(Nearest::default())
    }
}

/// The default: nearest by driving time less urgency. Small problems are solved exactly
/// (Kuhn-Munkres), and large ones greedily among the robots that are nearest as the crow flies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearest {
    /// The largest number of orders and of robots that are solved exactly.
    pub exact_up_to: usize,
    /// The number of robots per order whose driving time is looked up in a large problem.
    pub nearest_robots: usize,
    /// The lead, in seconds, with which another robot gets an order that has a robot.
    pub hysteresis_secs: f64,
}

impl Default for Nearest {
    fn default() -> Self {
        Self { exact_up_to: 200, nearest_robots: 12, hysteresis_secs: 10.0 }
    }
}

/// Each waiting order for the free robot with the lowest id that can drive to it. No robot loses an
/// order. For measurements: an endless load then sends robots to random nodes, however many are
/// free at a time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct InTurn;

impl Assigner for InTurn {
    fn assign(&mut self, problem: &Problem) -> Vec<(OrderId, u32)> {
        let kept: Vec<_> =
            problem.orders.iter().filter_map(|order| Some((order.id, order.robot?))).collect();
        let busy: BTreeSet<_> = kept.iter().map(|(_, robot)| *robot).collect();
        let robots = problem.robots.iter().map(|candidate| candidate.robot);
        let mut free: VecDeque<u32> = robots.filter(|robot| !busy.contains(robot)).collect();
        let mut pairs = kept;
        for order in problem.orders.iter().filter(|order| order.robot.is_none()) {
            let able = free.iter().position(|robot| {
                problem.may_get(order.id, *robot)
                    && (problem.driving_secs)(*robot, order.node).is_some()
            });
            let Some(first) = able else { continue };
            pairs.extend(free.remove(first).map(|robot| (order.id, robot)));
            if free.is_empty() {
                break;
            }
        }
        pairs
    }
}

/// Larger than any cost in milliseconds: of pairs that can't be.
const IMPOSSIBLE_MILLIS: i64 = 1 << 44;

/// The largest number of pairs whose distances are compared in one call, which bounds its time.
const MAX_PAIRS: usize = 1_000_000;

impl Assigner for Nearest {
    fn assign(&mut self, problem: &Problem) -> Vec<(OrderId, u32)> {
        let robots = problem.robots.len();
        if problem.orders.is_empty() || robots == 0 {
            return Vec::new();
        }
        let count = self.exact_up_to.max(2 * robots).min((MAX_PAIRS / robots).max(1));
        let (orders, mut pairs) = most_urgent(problem, count);
        let keeping: BTreeSet<_> = pairs.iter().map(|(_, robot)| *robot).collect();
        let others: Vec<_> = problem
            .robots
            .iter()
            .filter(|candidate| !keeping.contains(&candidate.robot))
            .copied()
            .collect();
        if others.is_empty() {
            return pairs;
        }
        let problem = Problem { robots: &others, ..*problem };
        pairs.extend(match orders.len().max(others.len()) <= self.exact_up_to {
            true => self.exact(&problem, &orders),
            false => self.greedy(&problem, &orders),
        });
        pairs
    }
}

/// Returns the most urgent orders, those without a robot first. Other orders with a robot keep it.
/// Orders for some robot types are chosen apart from others, which would hide them from a robot
/// that may get no others.
fn most_urgent(problem: &Problem, count: usize) -> (Vec<OpenOrder>, Vec<(OrderId, u32)>) {
    if problem.orders.len() <= count {
        return (problem.orders.to_vec(), Vec::new());
    }
    let mut groups: BTreeMap<Option<&Vec<u32>>, Vec<OpenOrder>> = BTreeMap::new();
    for order in problem.orders {
        groups.entry(problem.limits.get(&order.id)).or_default().push(*order);
    }
    let (mut chosen, mut kept) = (Vec::new(), Vec::new());
    for mut orders in groups.into_values() {
        if orders.len() > count {
            // Only the most urgent ones need to be in order: there may be thousands of others.
            orders.select_nth_unstable_by(count - 1, by_urgency);
            let rest = orders.split_off(count);
            orders.sort_unstable_by(by_urgency);
            kept.extend(rest.iter().filter_map(|order| Some((order.id, order.robot?))));
        }
        chosen.extend(orders);
    }
    (chosen, kept)
}

/// Compares orders by whether a robot has them, then by descending urgency, then by number.
fn by_urgency(a: &OpenOrder, b: &OpenOrder) -> Ordering {
    let urgency = b.urgency_secs.total_cmp(&a.urgency_secs);
    a.robot.is_some().cmp(&b.robot.is_some()).then(urgency).then(a.id.cmp(&b.id))
}

impl Nearest {
    /// Returns the cost of a pair in milliseconds; `None` if the robot can't drive there, or may not
    /// get the order.
    fn cost(&self, problem: &Problem, order: &OpenOrder, robot: u32) -> Option<i64> {
        if !problem.may_get(order.id, robot) {
            return None;
        }
        let driving = (problem.driving_secs)(robot, order.node).filter(|secs| secs.is_finite())?;
        let kept = if order.robot == Some(robot) { self.hysteresis_secs } else { 0.0 };
        let millis = ((driving - order.urgency_secs - kept) * 1e3).round() as i64;
        Some(millis.clamp(-IMPOSSIBLE_MILLIS / 64, IMPOSSIBLE_MILLIS / 64))
    }

    /// Returns the pairs of the smallest total cost, of as many pairs as possible.
    fn exact(&self, problem: &Problem, orders: &[OpenOrder]) -> Vec<(OrderId, u32)> {
        let robots = problem.robots;
        let weights = Matrix::from_fn(orders.len(), robots.len(), |(order, robot)| {
            self.cost(problem, &orders[order], robots[robot].robot)
                .map_or(-IMPOSSIBLE_MILLIS, |cost| -cost)
        });
        // The algorithm needs at least as many columns as rows.
        let is_transposed = orders.len() >= robots.len();
        let weights = if is_transposed { weights.transposed() } else { weights };
        let (_, chosen) = kuhn_munkres(&weights);
        let mut pairs = Vec::with_capacity(chosen.len());
        for pair @ (row, column) in chosen.into_iter().enumerate() {
            if weights[pair] > -IMPOSSIBLE_MILLIS {
                pairs.push(if is_transposed { (column, row) } else { (row, column) });
            }
        }
        pairs.sort_unstable();
        pairs.into_iter().map(|(order, robot)| (orders[order].id, robots[robot].robot)).collect()
    }

    /// Returns pairs in ascending order of their costs, as long as both are free.
    fn greedy(&self, problem: &Problem, orders: &[OpenOrder]) -> Vec<(OrderId, u32)> {
        let mut pairs = Vec::new();
        for order in orders {
            for robot in self.near(problem, order) {
                pairs.extend(self.cost(problem, order, robot).map(|cost| (cost, order.id, robot)));
            }
        }
        pairs.sort_unstable();
        let (mut given, mut busy) = (BTreeSet::new(), BTreeSet::new());
        let mut chosen = Vec::new();
        for (_, id, robot) in pairs {
            if !given.contains(&id) && busy.insert(robot) {
                given.insert(id);
                chosen.push((id, robot));
            }
        }
        chosen
    }

    /// Returns the robots that are nearest as the crow flies, and the one that has the order.
    fn near(&self, problem: &Problem, order: &OpenOrder) -> Vec<u32> {
        let mut robots = Vec::with_capacity(problem.robots.len());
        for Candidate { robot, position, .. } in problem.robots {
            if problem.may_get(order.id, *robot) {
                robots.push((position.distance_squared(order.position), *robot));
            }
        }
        let count = self.nearest_robots.min(robots.len());
        if count > 0 && count < robots.len() {
            robots
                .select_nth_unstable_by(count - 1, |a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        }
        let mut near: Vec<_> = robots[..count].iter().map(|(_, robot)| *robot).collect();
        near.extend(order.robot.filter(|robot| problem.has(*robot)));
        near.sort_unstable();
        near.dedup();
        near
    }
}

/// Returns the pairs that a problem allows, by order: each order and each robot once.
pub(super) fn allowed(problem: &Problem, pairs: Vec<(OrderId, u32)>) -> BTreeMap<OrderId, u32> {
    let (mut allowed, mut busy) = (BTreeMap::new(), BTreeSet::new());
    for (id, robot) in pairs {
        let is_known = problem.orders.binary_search_by_key(&id, |open| open.id).is_ok()
            && problem.has(robot)
            && problem.may_get(id, robot);
        if is_known && !allowed.contains_key(&id) && busy.insert(robot) {
            allowed.insert(id, robot);
        }
    }
    allowed
}

#[cfg(test)]
mod tests;
