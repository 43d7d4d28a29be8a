//! The routes of robots, as far as the producer has published them.

use regatta_plugin::frame::NO_EDGE;
use regatta_plugin::route::RouteResponse;

use crate::leg_table::Leg;
use crate::prediction::{RouteAhead, RouteEnd};

/// The number of legs that a robot may pass between two frames.
const MAX_PASSED: usize = 16;
/// The number of legs left from which on more of a route is wanted.
const FEW_LEGS: usize = 4;
/// The number of ticks for which a route is followed that a command has changed.
const MAX_STALE_TICKS: u64 = 100;

/// The routes that are known.
///
/// A route is known from the producer's answer until the robot leaves it or a command changes it.
/// A robot without a known route may take any way.
#[derive(Debug, Default)]
pub struct Routes {
    run_id: u64,
    tick: u64,
    /// By robot. Boxed, because few of many robots have a known route.
    known: Vec<Option<Box<KnownRoute>>>,
}

/// The route of a robot.
#[derive(Debug)]
struct KnownRoute {
    /// The edge that the robot was on when it was last seen; meaningless before `is_found`.
    edge: u32,
    /// Whether the robot was seen on its route.
    is_found: bool,
    legs: Vec<Leg>,
    /// Index of the leg after the one that the robot is on.
    next: usize,
    end: RouteEnd,
    /// Metres of the last leg that are released; infinity for all of it.
    limit: f32,
    /// Tick of the answer.
    tick: u64,
    /// Tick since which it is no longer the robot's route.
    stale_since: Option<u64>,
}

impl Routes {
    /// Forgets all routes.
    pub fn clear(&mut self) {
        self.known.clear();
    }

    /// Learns a route from the producer's answer. An answer from before a command that changed the
    /// route is ignored.
    pub fn learn(&mut self, answer: &RouteResponse) {
        if !answer.is_found() || answer.run_id != self.run_id {
            return;
        }
        let drives_on = answer.drives_on();
        let is_listed = answer.released as usize <= answer.legs().len();
        let route = KnownRoute {
            edge: NO_EDGE,
            is_found: false,
            legs: answer
                .legs()
                .filter(|leg| leg.released || drives_on)
                .map(|leg| Leg::new(leg.edge, leg.reverse))
                .collect(),
            next: 0,
            end: if is_listed && !drives_on { RouteEnd::Stop } else { RouteEnd::Open },
            limit: answer.released_metres,
            tick: answer.tick,
            stale_since: None,
        };
        let robot = answer.robot as usize;
        if robot >= self.known.len() {
            self.known.resize_with(robot + 1, || None);
        }
        let stale_since = self.known[robot].as_ref().and_then(|known| known.stale_since);
        if stale_since.is_none_or(|since| answer.tick >= since) {
            self.known[robot] = Some(Box::new(route));
        }
    }

    /// Notes that a command of a tick may have changed a robot's route. It is followed until a
    /// later answer comes, but not for long.
    pub fn mark_stale(&mut self, robot: u32, tick: u64) {
        if let Some(Some(route)) = self.known.get_mut(robot as usize) {
            route.stale_since = Some(tick);
        }
    }

    /// Whether the robot's route is unknown, stale, or nearly driven.
    pub fn is_wanted(&self, robot: u32) -> bool {
        let Some(route) = self.route(robot) else { return true };
        let left = route.legs.len() - route.next;
        // A route whose end is known has no more legs than it had.
        route.stale_since.is_some()
            || route.end == RouteEnd::Open && left <= FEW_LEGS && route.next > 1
    }

    /// Follows the robots to the next frame, of which `edges` is a column.
    pub(crate) fn follow(&mut self, run_id: u64, tick: u64, edges: &[u32]) {
        if run_id != self.run_id {
            self.clear();
        }
        (self.run_id, self.tick) = (run_id, tick);
        for (robot, slot) in self.known.iter_mut().enumerate() {
            slot.take_if(|route| !edges.get(robot).is_some_and(|edge| route.follow(*edge, tick)));
        }
    }

    /// Returns the route of a robot on an edge, from there on.
    pub(crate) fn ahead(&self, robot: u32, edge: u32) -> Option<RouteAhead<'_>> {
        let route = self.route(robot)?;
        let on = route.next.checked_sub(1).map(|on| route.legs[on].is_reverse());
        let ahead = RouteAhead {
            reverse: on,
            legs: &route.legs[route.next..],
            end: route.end,
            limit: route.limit,
        };
        (route.is_found && route.edge == edge).then_some(ahead)
    }

    fn route(&self, robot: u32) -> Option<&KnownRoute> {
        self.known.get(robot as usize)?.as_deref()
    }
}

impl KnownRoute {
    /// Follows the robot to an edge. Returns `false` if it has left its route.
    fn follow(&mut self, edge: u32, tick: u64) -> bool {
        if self.stale_since.is_some_and(|since| tick > since + MAX_STALE_TICKS) {
            return false;
        }
        if self.is_found && self.edge == edge {
            return true;
        }
        let ahead = self.legs[self.next..].iter().take(MAX_PASSED);
        if let Some(passed) = ahead.clone().position(|leg| leg.edge() == edge) {
            self.next += passed + 1;
        } else if self.is_found {
            return false;
        } else if tick < self.tick {
            // The answer is ahead of the frames.
            return true;
        }
        // A robot that is not yet on its route stands at its start.
        (self.edge, self.is_found) = (edge, true);
        true
    }
}

#[cfg(test)]
mod tests;
