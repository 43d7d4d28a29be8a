//! The traffic as planners see it: positions, goals, and the distance that each robot could drive.

mod extension;
mod robot;

use std::collections::VecDeque;

pub use self::extension::{Extension, LEAST};
pub use self::robot::{Blocker, Custody, Errand, Permit, Robot, RouteState, Seen};
use crate::claims::Claims;
use crate::roads::{Leg, Roads};

/// The places where the bases of robots may end.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BaseEnds {
    /// At nodes, and within edges.
    #[default]
    Anywhere,
    /// At nodes: robots drive whole edges.
    Nodes,
}

/// The traffic of a cycle.
#[derive(Clone, Copy, Debug)]
pub struct Traffic<'a> {
    /// The roads.
    pub roads: &'a Roads,
    /// The claims of all robots.
    pub claims: &'a Claims,
    /// By robot; `None` where there is none with this id.
    pub robots: &'a [Option<Robot>],
    /// By leg: whether it is closed. Robots on it may leave it.
    pub closed: &'a [bool],
    /// Whether a dead end is entered only while it is empty.
    pub stub_guard: bool,
    /// The places where bases may end.
    pub ends: BaseEnds,
    /// Simulated seconds.
    pub now: f64,
}

impl<'a> Traffic<'a> {
    /// A robot; `None` if there is none with this id.
    pub fn robot(&self, robot: u32) -> Option<&'a Robot> {
        self.robots.get(robot as usize)?.as_ref()
    }

    /// All robots, in ascending order of their ids.
    pub fn robots(&self) -> impl Iterator<Item = (u32, &'a Robot)> + use<'a> {
        (0..).zip(self.robots).filter_map(|(robot, state)| Some((robot, state.as_ref()?)))
    }

    /// Whether a leg is closed.
    pub fn is_closed(&self, leg: Leg) -> bool {
        self.closed.get(leg.index()).is_some_and(|closed| *closed)
    }

    /// The last leg of a robot's base and the node at its end.
    pub fn base_end(&self, robot: u32) -> Option<(Leg, u32)> {
        let last = self.claims.of(robot).iter().rev().find_map(|stretch| stretch.leg)?;
        Some((last, self.roads.end(last)))
    }

    /// Metres from where a robot was last seen to the end of its base.
    pub fn left(&self, robot: u32) -> f32 {
        self.claims.of(robot).iter().map(|stretch| stretch.to - stretch.from).sum()
    }

    /// Whether a robot could drive on at once if this were its route beyond its base.
    pub fn can_drive(&self, robot: u32, legs: &[Leg]) -> bool {
        let horizon: VecDeque<Leg> = legs.iter().copied().collect();
        !self.extension_along(robot, &horizon, 0.1, true).stretches.is_empty()
    }

    /// Returns a robot in the stub that another robot would enter, from one leg to the next.
    pub(crate) fn stub_occupant(&self, robot: u32, leg: Leg, next: Leg) -> Option<u32> {
        let stubs = self.roads.stubs();
        let stub = stubs
            .of(next.edge())
            .filter(|_| self.stub_guard && stubs.of(leg.edge()) != stubs.of(next.edge()))?;
        // The backstop decides the order of the robots that it admits.
        self.robot(robot).filter(|state| !state.permit.is_admitted)?;
        self.claims.occupant(stubs.edges(stub), robot)
    }

    /// The robot for which a robot has been waiting for at least some seconds.
    pub fn waits_for(&self, robot: u32, secs: f64) -> Option<u32> {
        let state = self.robot(robot)?;
        let is_patient = self.now - state.waiting_since < secs;
        let blocker = state.blocker?.robot;
        (!is_patient && self.robot(blocker).is_some()).then_some(blocker)
    }
}
