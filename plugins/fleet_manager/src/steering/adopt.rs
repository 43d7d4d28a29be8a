//! Adoption: robots that are new to steering, or off their claims, are stopped and taken over where
//! they stand.

use regatta_plugin::frame::RobotState;

use super::{Command, Steering};
use crate::claims::Stretch;
use crate::roads::Leg;
use crate::traffic::{Custody, Robot, Seen};

/// The time after which a cancellation without effect is sent again, in seconds.
const REPEAT_SECS: f64 = 1.0;

/// The distance from the end of an edge at which a robot counts as being there, in metres.
const AT_END: f32 = 1e-3;

impl Steering {
    /// Takes the state of a robot in a frame.
    pub fn see(&mut self, robot: u32, seen: &Seen) {
        let count = self.robots.len().max(robot as usize + 1);
        self.robots.resize_with(count, || None);
        if self.robots[robot as usize].is_none() && !self.meet(robot, seen) {
            return;
        }
        let now = self.now;
        let Some(state) = &mut self.robots[robot as usize] else { return };
        state.see(seen, now);
        if state.is_adopted() && seen.state == RobotState::Idle && seen.speed == 0.0 {
            return self.take_over(robot, seen);
        }
        let Some(edge) = seen.edge else { return };
        if !self.advance(robot, edge, seen.s) {
            if let Some(state) = self.robot_mut(robot) {
                state.stop(now);
                state.custody = Custody::Stopping { cancel_at: now, is_lost: true };
            }
            self.claim_edge(robot, edge);
        }
    }

    /// Takes a robot that wasn't there before; `false` if it is on no edge.
    fn meet(&mut self, robot: u32, seen: &Seen) -> bool {
        let Some(class) = self.roads.classes().get(seen.robot_type).copied() else { return false };
        let Some((leg, _)) = self.locate(seen) else { return false };
        self.robots[robot as usize] = Some(Robot::new(class, seen, self.now));
        self.claim_edge(robot, leg.edge());
        true
    }

    /// Stops a robot, to take it over when it is idle.
    pub(super) fn adopt(&mut self, robot: u32) {
        if let Some(state) = &mut self.robots[robot as usize] {
            state.stop(self.now);
        }
    }

    /// Revokes the grants of a robot whose command was refused. The robot is stopped, and then
    /// claims only its place.
    pub fn take_back(&mut self, robot: u32) {
        // All commands of a robot in one tick are refused for the same reason.
        if let Some(state) = self.robot_mut(robot)
            && !state.is_adopted()
        {
            // A frame doesn't tell in which gear a robot drove that stands on an edge.
            state.is_backing = !state.is_backing;
            self.adopt(robot);
        }
    }

    /// Claims the whole edge that a robot is on: which way it drives may not be known.
    fn claim_edge(&mut self, robot: u32, edge: u32) {
        let Some(state) = &self.robots[robot as usize] else { return };
        let whole = Stretch::whole(&self.roads, Leg::new(edge, false));
        self.claims.seize(&self.roads, robot, state.class.footprint, whole);
    }

    /// Takes an idle robot over where it stands.
    fn take_over(&mut self, robot: u32, seen: &Seen) {
        let Some((mut leg, mut place)) = self.locate(seen) else { return };
        let Some(state) = &mut self.robots[robot as usize] else { return };
        state.custody = Custody::Steered;
        state.unentered = (seen.edge.is_none() && place == 0.0).then_some(leg);
        let edge = self.roads.edge(leg.edge());
        if state.is_backing && place < edge.length && edge.reverse_speed > 0.0 {
            (leg, place) = (Leg::new(leg.edge(), true), edge.length - place);
        }
        let stance = Stretch::at(leg, place);
        self.claims.seize(&self.roads, robot, state.class.footprint, stance);
    }

    /// The leg that a robot stands on, and the metres from its start. A robot on a node counts as
    /// one at the end of an edge that leads there: its pose is the same.
    fn locate(&self, seen: &Seen) -> Option<(Leg, f32)> {
        if let Some(edge) = seen.edge {
            let length = self.roads.edge(edge).length;
            // The engine's lengths differ by rounding: a robot at the end of an edge must not have
            // some micrometres left.
            let place = if seen.s > length - AT_END { length } else { seen.s.max(0.0) };
            return Some((Leg::new(edge, false), place));
        }
        let node = self.roads.nearest_node(seen.position)?;
        match self.roads.arrival(node) {
            Some(leg) => Some((leg, self.roads.edge(leg.edge()).length)),
            None => self.roads.exits(node).first().map(|&leg| (leg, 0.0)),
        }
    }

    /// Whether every robot stands, or stays within its claim. Before that, no robot is sent
    /// anywhere.
    pub fn is_ready(&self) -> bool {
        !self.robots.iter().flatten().any(|state| state.is_lost() && state.speed > 0.0)
    }

    /// Commands the robots that are to be taken over to stop.
    pub(super) fn cancel_adopted(&mut self) {
        for (robot, state) in (0..).zip(&mut self.robots) {
            let Some(state) = state else { continue };
            let Custody::Stopping { cancel_at, .. } = &mut state.custody else { continue };
            if self.now >= *cancel_at {
                *cancel_at = self.now + REPEAT_SECS;
                self.commands.push(Command::Cancel { robot });
            }
        }
    }

    fn advance(&mut self, robot: u32, edge: u32, s: f32) -> bool {
        let length = self.roads.edge(edge).length;
        self.claims.advance(&self.roads, robot, edge, |stretch| match stretch.leg {
            Some(leg) if leg.is_reverse() => length - s,
            _ => s,
        })
    }
}
