//! Planners: which way robots go, and who goes first.
//!
//! A planner is free to decide as it likes: robots get only space that nobody else claims, whatever
//! it says.

mod backstop;
mod driving_times;
mod landmarks;
mod lanes;
mod pibt;
mod route;
mod tea;

use std::fmt;

pub use self::backstop::{Backstop, BackstopSettings};
pub use self::driving_times::DrivingTimes;
pub use self::landmarks::Landmarks;
pub use self::lanes::{CongestionSettings, Lanes, LanesSettings};
pub use self::pibt::{Pibt, PibtSettings};
pub use self::route::{Router, Search};
pub use self::tea::{Tea, TeaSettings};
use crate::roads::Leg;
use crate::traffic::Traffic;

/// Decides which way robots go, and who goes first.
///
/// The plans of a lockstep run must be a function of what the planner has seen: no time of day, no
/// order of threads.
pub trait Planner: fmt::Debug + Send {
    /// Plans after a frame. A robot with [`needs_route`](crate::traffic::Robot::needs_route) stands
    /// still at the end of its base until it gets a route, or is told unreachable.
    fn plan(&mut self, traffic: &Traffic<'_>, plans: &mut Plans);

    /// Figures of the run so far, by name, for logs and reports.
    fn counts(&self) -> Vec<(&'static str, u64)> {
        Vec::new()
    }
}

/// What a planner has decided in a cycle.
#[derive(Debug, Default)]
pub struct Plans {
    pub(crate) routes: Vec<(u32, Option<Vec<Leg>>)>,
    pub(crate) precedences: Vec<(u32, f64)>,
    pub(crate) holds: Vec<(u32, usize)>,
    pub(crate) follows: Vec<u32>,
    /// By how many legs the bases of robots may grow that are kept out of a region. Unlike those
    /// that are held, they wait for room: the ring guard knows where they will go on to.
    pub(crate) kept_out: Vec<(u32, usize)>,
    /// Robots whose bases stay as they are in this cycle.
    pub(crate) frozen: Vec<u32>,
    /// Robots that may enter the roads in this cycle, however many are there.
    pub(crate) admitted: Vec<u32>,
    /// Idle robots that are sent to a node, out of others' way.
    pub(crate) evicted: Vec<(u32, u32)>,
    /// Robots that need a route in the next cycle.
    pub(crate) released: Vec<u32>,
}

impl Plans {
    /// Gives a robot a route: these legs, from the end of its base on, instead of those it had. No
    /// leg may be one of its base.
    pub fn route(&mut self, robot: u32, legs: Vec<Leg>) {
        self.routes.push((robot, Some(legs)));
    }

    /// Says that no way leads to a robot's goal.
    pub fn unreachable(&mut self, robot: u32) {
        self.routes.push((robot, None));
    }

    /// Sets when a robot's base is extended, in ascending order of the keys; the default key of a
    /// robot is the time at which it was sent to its goal, in simulated seconds. Holds for this
    /// cycle.
    pub fn precede(&mut self, robot: u32, key: f64) {
        self.precedences.push((robot, key));
    }

    /// Lets a robot's base grow by this many legs at most. Holds for this cycle.
    pub fn hold(&mut self, robot: u32, legs: usize) {
        self.holds.push((robot, legs));
    }

    /// Lets a robot follow closely: its base may end anywhere, as far as those ahead let it, not
    /// only where it is in nobody's way. That is for robots which are sure to go on, as those ahead
    /// drive on to places of their own. Holds for this cycle.
    pub fn follow(&mut self, robot: u32) {
        self.follows.push(robot);
    }
}
