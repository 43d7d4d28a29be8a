//! The fastest route between two nodes: A* over legs.
//!
//! P. Hart, N. Nilsson, B. Raphael: A Formal Basis for the Heuristic Determination of Minimum Cost
//! Paths, 1968.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::Landmarks;
use crate::roads::{Leg, Roads, RobotClass};

/// Seconds that a change of gear costs, beside the time of driving.
const GEAR_CHANGE_SECS: f32 = 2.0;
/// Seconds that a turn on the spot costs.
const TURN_SECS: f32 = 4.0;
/// Seconds that a corner costs which the robot can't drive: its heading jumps there.
const JUMP_SECS: f32 = 60.0;

/// The start and the goal of a search.
#[derive(Clone, Copy, Debug)]
pub struct Search<'a> {
    /// The leg at whose end the route starts; none if the robot stands on a node.
    pub last: Option<Leg>,
    /// The node where it starts.
    pub start: u32,
    /// The node that it leads to.
    pub goal: u32,
    /// Whether it may lead along legs in reverse gear.
    pub reverse: bool,
    /// Landmarks that bound the times in forward gear, delays included; without them, or with
    /// reverse gear, the estimate is made from the distance.
    pub landmarks: Option<&'a Landmarks>,
    /// By which share of its time the route may take longer than the fastest one, at least 0, if
    /// there are landmarks: that spares much of the search.
    pub slack: f32,
}

/// Searches routes, one after the other. It keeps its memory in between.
#[derive(Debug, Default)]
pub struct Router {
    /// By leg.
    marks: Vec<Mark>,
    search: u32,
    open: BinaryHeap<(Reverse<Cost>, u32)>,
    fastest: f32,
    /// Legs that the last search looked at.
    looked_at: usize,
}

/// The state of a leg in a search.
#[derive(Clone, Copy, Debug)]
struct Mark {
    /// Twice the number of the search that this is about, and one more if the cost is final.
    stamp: u32,
    /// The cost of the best way to its end, in seconds.
    cost: f32,
    /// The leg before it.
    before: u32,
}

/// A cost in the order of numbers; costs are never NaN.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Cost(f32);

impl Eq for Cost {}

impl PartialOrd for Cost {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Cost {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0)
    }
}

const NO_LEG: u32 = u32::MAX;

impl Router {
    /// Makes a router for some roads.
    pub fn new(roads: &Roads) -> Self {
        let legs = 2 * roads.edges().len();
        let fastest = roads.edges().iter().flat_map(|edge| edge.speeds).fold(0.1, f32::max);
        let mark = Mark { stamp: 0, cost: 0.0, before: NO_LEG };
        Self { marks: vec![mark; legs], fastest, ..Self::default() }
    }

    /// Returns the legs of the route that takes the least time for a class of robots; `None` if
    /// there is none. A leg that `cost` gives no number for is closed; otherwise that many seconds
    /// are added to its driving time.
    pub fn route(
        &mut self,
        roads: &Roads,
        class: &RobotClass,
        search: Search<'_>,
        mut cost: impl FnMut(Leg) -> Option<f32>,
    ) -> Option<Vec<Leg>> {
        self.search += 1;
        self.looked_at = 0;
        self.open.clear();
        let goal = roads.position(search.goal);
        let fastest = self.fastest.min(class.max_speed);
        let landmarks = search.landmarks.filter(|_| !search.reverse);
        let estimate = |node: u32| match landmarks {
            Some(landmarks) => (1.0 + search.slack) * landmarks.least_secs(node, search.goal),
            None => {
                let [x, y] = roads.position(node);
                (x - goal[0]).hypot(y - goal[1]) / fastest
            }
        };
        let mut cost =
            |leg: Leg| if leg.is_reverse() && !search.reverse { None } else { cost(leg) };
        self.expand(roads, class, (search.last, NO_LEG, search.start, 0.0), &estimate, &mut cost);
        while let Some((_, index)) = self.open.pop() {
            let leg = Leg::from_index(index);
            let mark = &mut self.marks[leg.index()];
            if mark.stamp != 2 * self.search {
                continue;
            }
            mark.stamp += 1;
            let so_far = mark.cost;
            self.looked_at += 1;
            let node = roads.end(leg);
            if node == search.goal {
                return Some(self.legs_to(leg));
            }
            self.expand(roads, class, (Some(leg), index, node, so_far), &estimate, &mut cost);
        }
        None
    }

    /// The number of legs that the last search looked at.
    pub fn looked_at(&self) -> usize {
        self.looked_at
    }

    fn expand(
        &mut self,
        roads: &Roads,
        class: &RobotClass,
        (last, before, node, so_far): (Option<Leg>, u32, u32, f32),
        estimate: &impl Fn(u32) -> f32,
        cost: &mut impl FnMut(Leg) -> Option<f32>,
    ) {
        for &leg in roads.exits(node) {
            let mark = self.marks[leg.index()];
            if mark.stamp == 2 * self.search + 1 {
                continue;
            }
            let Some(extra) = cost(leg) else { continue };
            let driving = roads.edge(leg.edge()).length / roads.speed(class, leg);
            let total = so_far
                + driving
                + extra
                + last.map_or(0.0, |last| join_secs(roads, class, last, leg));
            if mark.stamp == 2 * self.search && mark.cost <= total {
                continue;
            }
            self.marks[leg.index()] = Mark { stamp: 2 * self.search, cost: total, before };
            self.open.push((Reverse(Cost(total + estimate(roads.end(leg)))), leg.index() as u32));
        }
    }

    fn legs_to(&self, leg: Leg) -> Vec<Leg> {
        let before = |leg: &Leg| {
            Some(self.marks[leg.index()].before)
                .filter(|before| *before != NO_LEG)
                .map(Leg::from_index)
        };
        let mut legs: Vec<Leg> = std::iter::successors(Some(leg), before).collect();
        legs.reverse();
        legs
    }
}

/// Returns the time that it takes from the end of a leg to the start of the next, in seconds.
fn join_secs(roads: &Roads, class: &RobotClass, from: Leg, to: Leg) -> f32 {
    let gear = if from.is_reverse() == to.is_reverse() { 0.0 } else { GEAR_CHANGE_SECS };
    match roads.is_turn(from, to) {
        false => gear,
        true if class.turns => gear + TURN_SECS,
        true => gear + JUMP_SECS,
    }
}

#[cfg(test)]
mod tests;
