//! Eviction: idle robots that are in the way of others are sent to the next place where they are
//! not.

use std::collections::VecDeque;

use regatta_base::sweep::Span;

use super::Steering;
use crate::roads::Leg;
use crate::traffic::Errand;

/// The time that a robot waits for an idle one before the idle one is sent away, in seconds.
const PATIENCE_SECS: f64 = 1.0;
/// The time that it waits for one that can't go anywhere without being in the way of others, in
/// seconds.
const LONG_PATIENCE_SECS: f64 = 10.0;
/// The largest number of legs that are searched for a refuge.
const MOST_LEGS: usize = 400;
/// The number of legs ahead of the waiting robot on which an idle robot would be in its way again.
const LEGS_AHEAD: usize = 40;

impl Steering {
    /// Sends idle robots away that others wait for.
    pub(super) fn evict_idle(&mut self) {
        for robot in 0..self.robots.len() as u32 {
            let Some(state) = self.robot(robot) else { continue };
            if self.now - state.waiting_since < PATIENCE_SECS {
                continue;
            }
            let Some(blocker) = state.blocker.map(|blocker| blocker.robot) else { continue };
            // A robot that can't reach its goal, as roads are closed, is sent on like an idle one.
            let is_idle = self.robot(blocker).is_some_and(|other| {
                other.is_idle() && !other.is_pinned() && other.stuck_since.is_infinite()
            });
            if is_idle && let Some(goal) = self.refuge(blocker, robot) {
                self.counts.evictions += 1;
                self.evict(blocker, goal);
            }
        }
    }

    /// Sends an idle robot to a node, where it is idle again.
    pub(super) fn evict(&mut self, robot: u32, goal: u32) {
        self.send(robot, goal);
        if let Some(state) = self.robot_mut(robot) {
            state.errand = Errand::Evicted(goal);
        }
    }

    /// Ends the errands of evicted robots that have arrived.
    pub(super) fn settle_evicted(&mut self) {
        for robot in 0..self.robots.len() as u32 {
            let Some(state) = self.robot(robot) else { continue };
            if let Errand::Evicted(goal) = state.errand
                && (self.has_arrived(robot, goal) || state.is_unreachable())
            {
                self.halt(robot);
            }
        }
    }

    /// Finds the nearest node where an idle robot blocks neither the robot that waits for it nor a
    /// robot that is there already. It is one where the robot is in nobody's way; on small plants,
    /// which may have none, one beside the route of the robot that waits for long.
    fn refuge(&self, idle: u32, waiting: u32) -> Option<u32> {
        let (last, start) = self.traffic().base_end(idle)?;
        let footprint = self.robot(idle)?.class.footprint;
        let waits = self.robot(waiting)?;
        let is_patient = self.now - waits.waiting_since < LONG_PATIENCE_SECS;
        let route: Vec<u32> = waits.horizon.iter().take(LEGS_AHEAD).map(|leg| leg.edge()).collect();
        let mut beside = None;
        let mut seen: Vec<Leg> = vec![last];
        let mut open: VecDeque<Leg> = self.roads.exits(start).iter().copied().collect();
        while let Some(leg) = open.pop_front() {
            let is_closed = self.closures.legs[leg.index()];
            if leg.is_reverse() || is_closed || seen.contains(&leg) || seen.len() > MOST_LEGS {
                continue;
            }
            seen.push(leg);
            let length = self.roads.edge(leg.edge()).length;
            let reach = self.claims.reach(
                &self.roads,
                idle,
                footprint,
                leg.edge(),
                Some(leg),
                Span::new(length, length),
            );
            let end = self.roads.end(leg);
            if reach.blocker.is_none() && !route.contains(&leg.edge()) {
                let is_open = self.roads.stops(footprint).last_open(leg, length, length, length);
                if is_open.is_some() {
                    return Some(end);
                }
                let is_on_route = waits.horizon.iter().any(|leg| self.roads.end(*leg) == end);
                beside = beside.or((!is_patient && !is_on_route).then_some(end));
            }
            open.extend(self.roads.exits(end));
        }
        beside
    }
}
