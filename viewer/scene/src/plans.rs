//! The plans of robots, to be drawn and shown: routes, goals, and the robots that robots wait for.

use bytemuck::{Pod, Zeroable};

use crate::route::RouteSegment;

/// The plans: lists to draw, and facts to show.
#[derive(Clone, Debug, Default)]
pub struct PlanReport {
    /// The routes of robots that match and of selected ones.
    pub lines: Vec<RouteSegment>,
    /// Their goals.
    pub goals: Vec<GoalMark>,
    /// Arrows to the robots that they wait for.
    pub arrows: Vec<WaitArrow>,
    /// Counts, also of robots that the lists leave out.
    pub facts: PlanFacts,
}

/// Counts of the plans.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PlanFacts {
    /// Whether only robots that match a filter are counted.
    pub is_filtered: bool,
    /// The routes of robots, while they are watched.
    pub routes: Option<Coverage>,
    /// Whether a fleet manager publishes the goals of robots.
    pub has_goals: bool,
    /// The robots that wait for others; `None` if no fleet manager publishes this.
    pub waiting: Option<Waiting>,
}

/// The number of robots that wait for others.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Waiting {
    /// All of them.
    pub robots: u32,
    /// Those in rings of robots that wait for each other.
    pub in_rings: u32,
}

impl PlanFacts {
    /// Whether the routes of a notable part of the robots under way are not known (yet).
    pub fn lacks_routes(&self) -> bool {
        self.routes
            .is_some_and(|routes| f64::from(routes.known) < 0.95 * f64::from(routes.under_way))
    }
}

/// The known part of the routes of all robots, or of those that match a filter.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Coverage {
    /// Robots under way whose routes are known.
    pub known: u32,
    /// Robots under way.
    pub under_way: u32,
    /// Seconds that the last round through all robots took; infinity before its end.
    pub round_secs: f32,
}

/// A mark at a goal: an instance of goals.wgsl.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct GoalMark {
    /// Index of the node in the world.
    pub node: u32,
    /// 1 for the goal of a selected robot, else 0.
    pub selected: u32,
}

/// An arrow from a robot that waits to the robot in its way: an instance of waits.wgsl.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct WaitArrow {
    /// The robot that waits, by id.
    pub from: u32,
    /// The robot that it waits for.
    pub to: u32,
    /// 1 if both are in a ring of robots that wait for each other, else 0.
    pub in_ring: u32,
}
