//! The planner `tea`: time-enhanced A* (TEA*). It plans complete paths of some tens of robots.
//!
//! J. Santos, P. Costa, L. Rocha, A. P. Moreira, G. Veiga: Time Enhanced A*: Towards the
//! Development of a New Approach for Multi-Robot Coordination, 2015; as in *Robotics* 2021, 10, 55
//! and 72.
//!
//! Time is divided into layers; a robot drives along one edge in a layer, however long that edge
//! is, or waits. Robots are planned one after the other, in the order of their priorities, on nodes
//! and layers that no stored path blocks. A robot that gets no path swaps its priority with the
//! next higher one, and both are planned again. The supervision plans all paths again when robots
//! have left their paths.
//!
//! Unlike in the publication, a robot that gets no path even so may come as near to others as the
//! conflicts of the roads allow, and counts on those being sent on that have reached their goals
//! (*relaxed*); failing that, it takes the fastest route, whatever the others do. Robots pass roads
//! in the planned order: a base isn't extended by a leg before all have passed that come earlier
//! there.

mod layers;
mod round;
mod search;
mod space;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;

use self::layers::Layers;
use self::round::Round;
use self::search::Finder;
use self::space::Space;
use super::route::Hints;
use super::{Planner, Plans, Router};
use crate::roads::{Leg, Roads};
use crate::traffic::Traffic;

/// The settings of the planner.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TeaSettings {
    /// Number of time layers: the longest path.
    pub layers: u16,
    /// The number of times that a robot swaps its priority with the next higher one before it gets
    /// no path.
    pub most_swaps: u32,
    /// The number of layers by which the steps of two robots may differ before all paths are
    /// planned again.
    pub most_steps_apart: u16,
    /// The largest number of states (of node and layer) that the search of one path looks at.
    pub states_per_path: u64,
    /// The number of states in a round after which robots only get relaxed paths.
    pub states_per_round: u64,
}

impl Default for TeaSettings {
    fn default() -> Self {
        Self {
            layers: 210,
            most_swaps: 5,
            most_steps_apart: 1,
            states_per_path: 2_000,
            states_per_round: 10_000,
        }
    }
}

/// The time that a robot may stand still before all paths are planned again, in seconds.
const PATIENCE_SECS: f64 = 2.0;

/// A place on a path, and the layer from which on the robot is there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Step {
    leg: Leg,
    layer: u16,
}

/// The path of a robot.
#[derive(Clone, Debug, Default)]
struct Path {
    /// The leg on which the base ended at planning, and the following legs, each with the layer in
    /// which the robot reaches its end.
    steps: Vec<Step>,
    /// Whether the robot is behind others on the first leg, and reaches its end only in that layer.
    starts_inside: bool,
    /// Whether it was planned; else it has one step.
    is_planned: bool,
    /// Index of the step at which its base ends.
    done: usize,
    /// The node to which it leads.
    goal: Option<u32>,
}

/// Figures of the run.
#[derive(Clone, Copy, Debug, Default)]
struct Counts {
    rounds: u64,
    paths: u64,
    swaps: u64,
    relaxed: u64,
    none: u64,
    looked_at: u64,
}

/// The planner.
#[derive(Debug)]
pub struct Tea {
    settings: TeaSettings,
    space: Space,
    layers: Layers,
    finder: Finder,
    router: Router,
    /// By robot.
    paths: BTreeMap<u32, Path>,
    /// Robots of the last round, in descending order of their priorities.
    ranks: Vec<u32>,
    /// Whether a robot had no path to its goal.
    is_incomplete: bool,
    planned: f64,
    counts: Counts,
}

impl Tea {
    /// Makes the planner for some roads.
    pub fn new(roads: &Roads, settings: TeaSettings) -> Self {
        let settings = TeaSettings { layers: settings.layers.max(2), ..settings };
        let space = Space::new(roads);
        Self {
            layers: Layers::new(&space, settings.layers),
            finder: Finder::new(roads, settings.layers),
            router: Router::new(roads),
            space,
            settings,
            paths: BTreeMap::new(),
            ranks: Vec::new(),
            is_incomplete: false,
            planned: f64::NEG_INFINITY,
            counts: Counts::default(),
        }
    }

    /// Follows the robots along their paths. Returns whether all paths have to be planned again.
    fn supervise(&mut self, traffic: &Traffic<'_>) -> bool {
        let mut deviates = false;
        for (robot, state) in traffic.robots() {
            let path = self.paths.get_mut(&robot);
            let is_known = path.is_some_and(|path| {
                path.goal == state.goal() && (path.follow(traffic, robot) || !path.is_planned)
            });
            let waits = traffic.now - state.waiting_since.max(self.planned) >= PATIENCE_SECS;
            deviates |= !is_known || state.needs_route() || waits;
        }
        let is_any_gone = self.paths.keys().any(|robot| traffic.robot(*robot).is_none());
        let is_late = self.is_incomplete && traffic.now - self.planned >= PATIENCE_SECS;
        deviates || is_late || is_any_gone || self.are_apart()
    }

    /// Whether the steps of two robots differ by too many layers.
    fn are_apart(&self) -> bool {
        let planned: Vec<&Path> = self.paths.values().filter(|path| path.is_planned).collect();
        let earliest = planned.iter().filter_map(|path| path.until()).min();
        let latest = planned.iter().map(|path| path.since()).max();
        let (Some(earliest), Some(latest)) = (earliest, latest) else { return false };
        latest > earliest + self.settings.most_steps_apart
    }

    /// Plans all paths.
    fn plan_paths(&mut self, traffic: &Traffic<'_>, plans: &mut Plans) {
        self.counts.rounds += 1;
        self.planned = traffic.now;
        let Self { settings, space, layers, finder, counts, .. } = self;
        let round = Round::new(traffic, space, layers, finder, settings, counts);
        let (paths, ranks) = round.run();
        self.is_incomplete = false;
        for (&robot, path) in &paths {
            let Some(state) = traffic.robot(robot).filter(|state| state.is_under_way()) else {
                continue;
            };
            let is_there = path.end(traffic.roads) == state.goal() && !path.starts_inside;
            if path.is_planned || is_there {
                let legs: Vec<Leg> = path.steps[1..].iter().map(|step| step.leg).collect();
                if state.needs_route() || !state.horizon.iter().eq(&legs) {
                    plans.route(robot, legs);
                }
                continue;
            }
            self.is_incomplete = true;
            let leads_to_goal = state
                .horizon
                .back()
                .is_some_and(|&leg| Some(traffic.roads.end(leg)) == state.goal());
            if state.needs_route() || !leads_to_goal {
                let (route, _) = self.router.route_of(traffic, robot, Hints::default(), |leg| {
                    (!traffic.is_closed(leg)).then_some(0.0)
                });
                match route {
                    Some(legs) => plans.route(robot, legs),
                    None => plans.unreachable(robot),
                }
            }
        }
        (self.paths, self.ranks) = (paths, ranks);
    }
}

impl Planner for Tea {
    fn plan(&mut self, traffic: &Traffic<'_>, plans: &mut Plans) {
        if self.supervise(traffic) {
            self.plan_paths(traffic, plans);
        }
        keep_order(traffic, &self.space, &self.paths, &self.ranks, plans);
    }

    fn counts(&self) -> Vec<(&'static str, u64)> {
        let Counts { rounds, paths, swaps, relaxed, none, looked_at } = self.counts;
        vec![
            ("rounds", rounds),
            ("paths", paths),
            ("swaps", swaps),
            ("relaxed paths", relaxed),
            ("no path", none),
            ("states looked at", looked_at),
        ]
    }
}

impl Path {
    /// Updates the step at which the robot's base ends; `false` if it isn't on the path.
    fn follow(&mut self, traffic: &Traffic<'_>, robot: u32) -> bool {
        let Some((leg, _)) = traffic.base_end(robot) else { return false };
        let ahead = self.steps[self.done..].iter().position(|step| step.leg == leg);
        self.done += ahead.unwrap_or(0);
        ahead.is_some()
    }

    /// The node at its end.
    fn end(&self, roads: &Roads) -> Option<u32> {
        self.steps.last().map(|step| roads.end(step.leg))
    }

    /// The layer in which the robot gets to the place where its base ends.
    fn since(&self) -> u16 {
        if self.done == 0 { 0 } else { self.steps[self.done].layer }
    }

    /// The layer in which the robot leaves the place where its base ends; `None` if it stays there.
    fn until(&self) -> Option<u16> {
        self.steps.get(self.done + 1).map(|next| next.layer - 1)
    }
}

/// The number of legs beyond a base that are checked.
const MOST_LEGS: usize = 8;

/// The time that a robot waits for another one in its way before no other robot is held back for it
/// any more, in seconds.
const STUCK_SECS: f64 = 4.0;

/// The planned turn of a robot on a leg: the layer, and its rank among those of the same layer.
type Turn = (u16, usize);

/// Holds robots back that would be too early somewhere.
fn keep_order(
    traffic: &Traffic<'_>,
    space: &Space,
    paths: &BTreeMap<u32, Path>,
    ranks: &[u32],
    plans: &mut Plans,
) {
    let mut turns: Vec<Vec<(Turn, u32)>> = vec![Vec::new(); traffic.roads.edges().len()];
    for (rank, robot) in ranks.iter().enumerate() {
        let Some(state) = traffic.robot(*robot) else { continue };
        if traffic.now - state.waiting_since >= STUCK_SECS {
            continue;
        }
        for step in paths.get(robot).into_iter().flat_map(|path| &path.steps[path.done + 1..]) {
            turns[step.leg.edge() as usize].push(((step.layer, rank), *robot));
        }
    }
    for (rank, robot) in ranks.iter().enumerate() {
        let Some(path) = paths.get(robot) else { continue };
        let legs = path.steps[path.done + 1..].iter().take(MOST_LEGS).position(|step| {
            let near = space.near(step.leg.edge());
            let mut others = near.iter().flat_map(|&near| &turns[near as usize]);
            others.any(|(other, holder)| holder != robot && *other < (step.layer, rank))
        });
        if let Some(legs) = legs {
            plans.permit(*robot).max_legs = legs;
        }
    }
}
