//! Planners: decide the routes of robots and their precedence.
//!
//! A planner may decide anything: whatever it plans, robots get only space that no other robot
//! claims.

mod backstop;
mod committed;
mod driving_times;
mod fallback;
mod landmarks;
mod lanes;
mod pibt;
mod route;
mod tea;
#[cfg(test)]
mod tests;

use clap::ValueEnum;
use regatta_base::components::{largest, strong_components};
use regatta_base::rows::Rows;
use std::fmt;

pub use self::backstop::{Backstop, BackstopSettings};
pub use self::committed::Committed;
pub use self::driving_times::DrivingTimes;
pub use self::fallback::{Candidate, Fallback, Rate};
pub use self::landmarks::Landmarks;
pub use self::lanes::{CongestionSettings, Lanes, LanesSettings};
pub use self::pibt::{Pibt, PibtSettings};
pub use self::route::{Bound, Router, Search};
pub use self::tea::{Tea, TeaSettings};
use crate::rehearsal::Rehearsal;
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

    /// Returns a robot that another one has to wait for instead of keeping the extension of its
    /// base that it has just claimed; by default, none.
    fn objection(&mut self, _traffic: &Traffic<'_>, _robot: u32) -> Option<u32> {
        None
    }

    /// Whether robots that close a ring of waiters are held back; by default, yes. A planner that
    /// keeps the traffic free of such rings says no.
    fn guards_rings(&self) -> bool {
        true
    }

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

/// The share of legs that are driven in both directions from which on robots may meet head-on, and
/// that from which on a plant counts as one of single tracks.
const SOME_TWO_WAY: f32 = 0.02;
const LEAST_TWO_WAY: f32 = 0.25;
/// The largest number of robots with committed ways: each looks at the ways of all others.
const MOST_COMMITTED: usize = 64;
/// The number of robots for each node from which on one-way blocks that are short for a robot jam.
const CROWDED: f32 = 0.1;
/// The length of a short block, in lengths of a robot.
const SHORT_BLOCK: f32 = 4.0;

/// Puts the backstop under committed ways, where it helps only if all robots stand: else it would
/// lead robots away from their ways.
fn with_last_resort(planner: Committed) -> Box<dyn Planner> {
    Box::new(Backstop::new(Box::new(planner), BackstopSettings::of_last_resort()))
}

/// The share of the legs that have a leg in the opposite direction, from 0 to 1. Only the largest
/// part of the roads counts in which all nodes can be reached from each other: robots work there.
fn two_way_share(roads: &Roads) -> f32 {
    let parts = strong_components(&Rows::of_sorted(
        roads.nodes() as usize,
        (0..roads.nodes())
            .flat_map(|node| roads.exits(node).iter().map(move |leg| (node, roads.end(*leg)))),
    ));
    let main = largest(&parts);
    let nodes = (0..roads.nodes()).filter(|node| parts[*node as usize] == main);
    let legs = nodes.flat_map(|node| roads.exits(node).iter().copied());
    let legs = legs.filter(|leg| parts[roads.end(*leg) as usize] == main);
    let (mut all, mut two_way) = (0, 0);
    for leg in legs {
        let (start, end) = (roads.start(leg), roads.end(leg));
        all += 1;
        two_way += u32::from(roads.exits(end).iter().any(|&back| roads.end(back) == start));
    }
    two_way as f32 / all.max(1) as f32
}

/// Whether most edges are short for the longest robot.
fn has_short_blocks(roads: &Roads) -> bool {
    let longest = roads.footprints().iter().map(|footprint| 2.0 * footprint.reach());
    let short = SHORT_BLOCK * longest.fold(0.0, f32::max);
    2 * roads.edges().iter().filter(|edge| edge.length < short).count() > roads.edges().len()
}

/// The planner that decides which way robots go.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum PlannerKind {
    /// The planner that suits the roads and the number of robots
    #[default]
    Auto,
    /// Committed ways to rest places; for two-way roads with dead ends
    Committed,
    /// The fastest route, counting the time that other robots lose on it; for roads with one-way
    /// lanes
    Lanes,
    /// Priority inheritance with backtracking, from place to place; for opposing traffic on one
    /// track
    Pibt,
    /// Time-enhanced A*: whole paths in time layers; for a few tens of robots
    Tea,
}

impl PlannerKind {
    /// Makes the planner for some roads and about so many robots, and returns the settings of
    /// steering for it, too.
    pub(crate) fn planner(
        self,
        roads: &Roads,
        robots: usize,
        rehearsal: Option<&Rehearsal<'_>>,
    ) -> (Box<dyn Planner>, Settings) {
        match self {
            Self::Auto => Self::suited(roads, robots, rehearsal),
            _ => (self.plain(roads), self.settings()),
        }
    }

    /// Makes the planner for some roads; committed ways for [`Auto`](Self::Auto).
    pub(crate) fn plain(self, roads: &Roads) -> Box<dyn Planner> {
        let planner: Box<dyn Planner> = match self {
            Self::Auto | Self::Committed => return with_last_resort(Committed::new(roads)),
            Self::Lanes => Box::new(Lanes::new(roads, LanesSettings::default())),
            Self::Tea => Box::new(Tea::new(roads, TeaSettings::default())),
            Self::Pibt => Box::new(Pibt::new(roads, PibtSettings::default())),
        };
        Box::new(Backstop::new(planner, BackstopSettings::default()))
    }

    /// Makes the planner that suits some roads and a number of robots: the best in a rehearsal.
    /// It is `lanes` if roads are driven one way, and robots don't crowd short blocks.
    fn suited(
        roads: &Roads,
        robots: usize,
        rehearsal: Option<&Rehearsal<'_>>,
    ) -> (Box<dyn Planner>, Settings) {
        let kinds = match two_way_share(roads) {
            share if share < SOME_TWO_WAY => Self::candidates_one_way(roads, robots),
            share => Self::candidates_two_way(robots, share),
        };
        let mut candidates: Vec<Candidate> = kinds.into_iter().map(Candidate::from).collect();
        if let Some(rehearsal) = rehearsal.filter(|_| candidates.len() > 1) {
            rehearsal.sort(&mut candidates);
        }
        let (first, settings) = (candidates[0].kind.plain(roads), candidates[0].kind.settings());
        match candidates.len() {
            1 => (first, settings),
            _ => (Box::new(Fallback::new(first, candidates)), settings),
        }
    }

    /// The planners that may suit roads that are driven one way, the likely one first.
    fn candidates_one_way(roads: &Roads, robots: usize) -> Vec<Self> {
        let is_crowded = robots > 1 && robots as f32 > roads.nodes() as f32 * CROWDED;
        match is_crowded && has_short_blocks(roads) {
            true => vec![Self::Pibt, Self::Lanes],
            false => vec![Self::Lanes],
        }
    }

    /// The planners that may suit roads of which a share is driven both ways, the likely one first.
    fn candidates_two_way(robots: usize, share: f32) -> Vec<Self> {
        let mut kinds = vec![Self::Lanes, Self::Pibt];
        if robots <= MOST_COMMITTED {
            kinds.insert(if share < LEAST_TWO_WAY { 2 } else { 0 }, Self::Committed);
        }
        kinds
    }

    /// The settings of steering for it.
    pub(crate) fn settings(self) -> Settings {
        match self {
            Self::Auto | Self::Lanes => Settings::default(),
            // They decide themselves in which order robots drive: a robot that isn't admitted would
            // hold up all that are to follow it.
            Self::Tea | Self::Pibt => Settings {
                admission: AdmissionSettings::unlimited(),
                stub_guard: false,
                ..Settings::default()
            },
            // It keeps every state free of robots that can't come out of a dead end.
            Self::Committed => Settings {
                admission: AdmissionSettings::unlimited(),
                stub_guard: false,
                ..Settings::default()
            },
        }
    }
}
