//! Planners: decide the routes of robots and their precedence.
//!
//! A planner may decide anything: whatever it plans, robots get only space that no other robot
//! claims.

mod backstop;
mod driving_times;
mod landmarks;
mod lanes;
mod pibt;
mod route;
mod tea;

use clap::ValueEnum;
use std::fmt;

pub use self::backstop::{Backstop, BackstopSettings};
pub use self::driving_times::DrivingTimes;
pub use self::landmarks::Landmarks;
pub use self::lanes::{CongestionSettings, Lanes, LanesSettings};
pub use self::pibt::{Pibt, PibtSettings};
pub use self::route::{Router, Search};
pub use self::tea::{Tea, TeaSettings};
use crate::roads::{Leg, Roads};
use crate::steering::{AdmissionSettings, Settings};
use crate::traffic::{Permit, Traffic};

/// Decides the routes of robots and their precedence.
///
/// The plans of a lockstep run must be a function of the traffic that the planner has seen: neither
/// of the time of day nor of the order of threads.
pub trait Planner: fmt::Debug + Send {
    /// Plans after a frame. A robot with [`needs_route`](crate::traffic::Robot::needs_route) stands
    /// still at the end of its base until it gets a route, or is told unreachable.
    fn plan(&mut self, traffic: &Traffic<'_>, plans: &mut Plans);

    /// Figures of the run so far, by name, for logs and reports.
    fn counts(&self) -> Vec<(&'static str, u64)> {
        Vec::new()
    }
}

/// The decisions of a planner in one cycle.
#[derive(Debug, Default)]
pub struct Plans {
    /// New routes; `None` where no way leads to a robot's goal.
    pub(crate) routes: Vec<(u32, Option<Vec<Leg>>)>,
    /// Idle robots that are sent to a node, out of the way of others.
    pub(crate) evicted: Vec<(u32, u32)>,
    /// Robots that need a route in the next cycle.
    pub(crate) released: Vec<u32>,
    /// By robot; the default beyond its end.
    permits: Vec<Permit>,
}

impl Plans {
    /// Gives a robot a route: these legs, from the end of its base on, instead of those it had. No
    /// leg may be one of its base.
    pub fn route(&mut self, robot: u32, legs: Vec<Leg>) {
        self.routes.push((robot, Some(legs)));
    }

    /// Marks a robot's goal as unreachable.
    pub fn unreachable(&mut self, robot: u32) {
        self.routes.push((robot, None));
    }

    /// The permission of a robot for this cycle, to be changed.
    pub fn permit(&mut self, robot: u32) -> &mut Permit {
        let count = self.permits.len().max(robot as usize + 1);
        self.permits.resize(count, Permit::default());
        &mut self.permits[robot as usize]
    }

    /// Takes the permits of all robots, by robot; beyond the end, robots have the default.
    pub(crate) fn take_permits(&mut self) -> impl Iterator<Item = Permit> + '_ {
        self.permits.drain(..)
    }
}

/// The planner that decides which way robots go.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum PlannerKind {
    /// The fastest way, with the time added that others lose on it; for roads whose lanes are
    /// driven one way
    #[default]
    Lanes,
    /// Time-enhanced A*: whole paths in time layers; for some tens of robots
    Tea,
    /// Priority inheritance with backtracking: from place to place; where opposing traffic shares
    /// one track
    Pibt,
}

impl PlannerKind {
    /// Makes the planner for some roads.
    pub fn planner(self, roads: &Roads) -> Box<dyn Planner> {
        match self {
            Self::Lanes => Box::new(Lanes::new(roads, LanesSettings::default())),
            Self::Tea => Box::new(Tea::new(roads, TeaSettings::default())),
            Self::Pibt => Box::new(Pibt::new(roads, PibtSettings::default())),
        }
    }

    /// The settings of steering for it.
    pub(crate) fn settings(self) -> Settings {
        match self {
            Self::Lanes => Settings::default(),
            // They decide themselves in which order robots drive: a robot that isn't admitted would
            // hold up all that are to follow it.
            Self::Tea | Self::Pibt => Settings {
                admission: AdmissionSettings::unlimited(),
                stub_guard: false,
                ..Settings::default()
            },
        }
    }
}
