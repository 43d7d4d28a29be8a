//! The fastest route between two nodes: A* over legs.
//!
//! P. Hart, N. Nilsson, B. Raphael: A Formal Basis for the Heuristic Determination of Minimum Cost
//! Paths, 1968.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::Landmarks;
use crate::roads::{Leg, Roads, RobotClass};
use crate::traffic::Traffic;

/// Seconds that a change of gear costs, beside the time of driving.
const GEAR_CHANGE_SECS: f32 = 2.0;
/// Seconds that a turn on the spot costs.
const TURN_SECS: f32 = 4.0;
/// Seconds that a corner costs at which the heading jumps because the robot can't turn.
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
    /// The bound of the time to the goal.
    pub bound: Bound<'a>,
    /// The share by which the route may take longer than the fastest one, at least 0, if there are
    /// landmarks: that shortens the search.
    pub slack: f32,
}

/// The source of the lower bound of the time from a node to the goal of a search.
#[derive(Clone, Copy, Debug, Default)]
pub enum Bound<'a> {
    /// The distance.
    #[default]
    Distance,
    /// Landmarks that bound the times in forward gear, delays included. For routes in reverse gear
    /// it is the distance.
    Landmarks(&'a Landmarks),
    /// By node: the driving time to the goal on empty roads, in milliseconds, as of
    /// [`Roads::millis_to`]. As these are rounded up, a route may take a millisecond longer than
    /// the fastest one for each of its legs.
    Millis(&'a [u32]),
}

impl Search<'_> {
    /// The goal of a search for the nearest of several nodes.
    pub const NO_NODE: u32 = u32::MAX;
}

/// Searches routes, one after the other. It keeps its memory in between.
#[derive(Debug, Default)]
pub struct Router {
    /// By leg.
    marks: Vec<Mark>,
    search: u32,
    open: BinaryHeap<Reverse<Open>>,
    fastest: f32,
    /// Legs that the last search looked at.
    looked_at: usize,
}

/// The state of a leg in a search.
#[derive(Clone, Copy, Debug)]
struct Mark {
    /// Twice the number of the search that reached it, and one more if the cost is final.
    stamp: u32,
    /// The cost of the best way to its end, in seconds.
    cost: f32,
    /// The leg before it.
    before: u32,
}

/// A leg that may be looked at next, by its cost. The order of numbers of one integer is found
/// faster than that of a cost and a leg.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Open(u64);

impl Open {
    /// Makes it of a leg and a cost, which is at least 0. Of legs with equal costs, that with the
    /// largest index comes first.
    fn new(cost: f32, leg: Leg) -> Self {
        // The bits of floats from 0 on are in the order of the floats.
        Self(u64::from(cost.to_bits()) << 32 | u64::from(!(leg.index() as u32)))
    }

    fn leg(self) -> Leg {
        Leg::from_index(!(self.0 as u32))
    }
}

const NO_LEG: u32 = u32::MAX;

impl Router {
    /// Makes a router for some roads.
    pub fn new(roads: &Roads) -> Self {
        let legs = 2 * roads.edges().len();
        let speeds = roads.edges().iter().map(|edge| edge.speed.max(edge.reverse_speed));
        let fastest = speeds.fold(0.1, f32::max);
        let mark = Mark { stamp: 0, cost: 0.0, before: NO_LEG };
        Self { marks: vec![mark; legs], fastest, ..Self::default() }
    }

    /// Returns the legs of the fastest route for a class of robots; `None` if there is none. `cost`
    /// returns the seconds that are added to the driving time of a leg; `None` if it is closed.
    pub fn route(
        &mut self,
        roads: &Roads,
        class: &RobotClass,
        search: Search<'_>,
        cost: impl FnMut(Leg) -> Option<f32>,
    ) -> Option<Vec<Leg>> {
        self.nearest(roads, class, search, cost, |node| node == search.goal)
    }

    /// Returns the legs of the fastest route to the nearest node that is a goal, as
    /// [`route`](Self::route) does. The estimate of a search for several goals has to be
    /// [none](Search::NO_NODE).
    pub fn nearest(
        &mut self,
        roads: &Roads,
        class: &RobotClass,
        search: Search<'_>,
        mut cost: impl FnMut(Leg) -> Option<f32>,
        is_goal: impl Fn(u32) -> bool,
    ) -> Option<Vec<Leg>> {
        self.search += 1;
        self.looked_at = 0;
        self.open.clear();
        let query = Query { roads, class, search, fastest: self.fastest.min(class.max_speed) };
        let start = Reached { last: search.last, before: NO_LEG, node: search.start, so_far: 0.0 };
        self.expand(&query, start, &mut cost);
        while let Some(Reverse(open)) = self.open.pop() {
            let leg = open.leg();
            let mark = &mut self.marks[leg.index()];
            if mark.stamp != 2 * self.search {
                continue;
            }
            mark.stamp += 1;
            let so_far = mark.cost;
            self.looked_at += 1;
            let node = roads.end(leg);
            if is_goal(node) {
                return Some(self.legs_to(leg));
            }
            let before = leg.index() as u32;
            let reached = Reached { last: Some(leg), before, node, so_far };
            self.expand(&query, reached, &mut cost);
        }
        None
    }

    /// The number of legs that the last search looked at.
    pub fn looked_at(&self) -> usize {
        self.looked_at
    }

    fn expand(
        &mut self,
        query: &Query<'_>,
        from: Reached,
        cost: &mut impl FnMut(Leg) -> Option<f32>,
    ) {
        let Query { roads, class, search, .. } = *query;
        let Reached { last, before, node, so_far } = from;
        for &leg in roads.exits(node) {
            if leg.is_reverse() && !search.reverse {
                continue;
            }
            let mark = self.marks[leg.index()];
            if mark.stamp == 2 * self.search + 1 {
                continue;
            }
            let Some(extra) = cost(leg) else { continue };
            let road = roads.edge(leg.edge());
            let driving = road.length / roads.speed(class, leg) + road.delay_secs;
            let total = so_far
                + driving
                + extra
                + last.map_or(0.0, |last| join_secs(roads, class.turns, last, leg));
            if mark.stamp == 2 * self.search && mark.cost <= total {
                continue;
            }
            self.marks[leg.index()] = Mark { stamp: 2 * self.search, cost: total, before };
            let estimate = total + query.least_secs(roads.end(leg));
            self.open.push(Reverse(Open::new(estimate, leg)));
        }
    }

    fn legs_to(&self, leg: Leg) -> Vec<Leg> {
        let mut legs = vec![leg];
        let mut before = self.marks[leg.index()].before;
        while before != NO_LEG {
            let leg = Leg::from_index(before);
            legs.push(leg);
            before = self.marks[leg.index()].before;
        }
        legs.reverse();
        legs
    }

    /// Returns the fastest route of a robot to its goal from the end of its base, as
    /// [`route`](Self::route) does, and the number of legs that the search looked at.
    pub(super) fn route_of(
        &mut self,
        traffic: &Traffic<'_>,
        robot: u32,
        hints: Hints<'_>,
        cost: impl Fn(Leg) -> Option<f32>,
    ) -> (Option<Vec<Leg>>, usize) {
        let (Some(state), Some((last, start))) = (traffic.robot(robot), traffic.base_end(robot))
        else {
            return (None, 0);
        };
        let Some(goal) = state.goal() else { return (None, 0) };
        if start == goal {
            return (Some(Vec::new()), 0);
        }
        let Hints { bound, slack } = hints;
        let search = Search { last: Some(last), start, goal, reverse: false, bound, slack };
        let found = self.route(traffic.roads, &state.class, search, &cost);
        let looked_at = self.looked_at;
        if found.is_some() {
            return (found, looked_at);
        }
        // Robots in reverse gear meet others head-on: only if no other way leads to the goal.
        let search = Search { reverse: true, ..search };
        let found = self.route(traffic.roads, &state.class, search, &cost);
        (found, looked_at + self.looked_at)
    }
}

/// Bounds that shorten a search.
#[derive(Clone, Copy, Default)]
pub(super) struct Hints<'a> {
    pub bound: Bound<'a>,
    pub slack: f32,
}

/// The constants of a search.
struct Query<'a> {
    roads: &'a Roads,
    class: &'a RobotClass,
    search: Search<'a>,
    /// The highest speed of a robot of the class, in metres per second.
    fastest: f32,
}

impl Query<'_> {
    /// The estimate of the time from a node to the goal, in seconds.
    fn least_secs(&self, node: u32) -> f32 {
        let Search { goal, slack, reverse, bound, .. } = self.search;
        if goal == Search::NO_NODE {
            return 0.0;
        }
        match bound {
            Bound::Landmarks(landmarks) if !reverse => {
                (1.0 + slack) * landmarks.least_secs(node, goal)
            }
            Bound::Millis(millis) => millis[node as usize] as f32 * 1e-3,
            Bound::Landmarks(_) | Bound::Distance => {
                let offset = self.roads.position(node) - self.roads.position(goal);
                offset.x.hypot(offset.y) / self.fastest
            }
        }
    }
}

/// A node that a search has reached.
struct Reached {
    last: Option<Leg>,
    /// Index of the last leg, if the search has driven it; or else [`NO_LEG`].
    before: u32,
    node: u32,
    so_far: f32,
}

/// Returns the time from the end of a leg to the start of the next one, in seconds, for robots that
/// turn on the spot or don't.
pub(super) fn join_secs(roads: &Roads, turns: bool, from: Leg, to: Leg) -> f32 {
    let gear = if from.is_reverse() == to.is_reverse() { 0.0 } else { GEAR_CHANGE_SECS };
    match roads.is_turn(from, to) {
        false => gear,
        true if turns => gear + TURN_SECS,
        true => gear + JUMP_SECS,
    }
}

#[cfg(test)]
mod tests;
