//! A round of planning: the paths of all robots, one after the other.

use std::collections::BTreeMap;

use super::layers::{Change, Layers};
use super::search::{Finder, Query};
use super::space::Space;
use super::{Counts, Path, Step, TeaSettings};
use crate::roads::Leg;
use crate::traffic::{Robot, Traffic};

/// A robot whose path is planned.
#[derive(Debug)]
struct Planned {
    start: Path,
    /// The robot ahead of it on the leg where its base ends.
    ahead: Option<u32>,
    swaps: u32,
    path: Option<Path>,
}

/// A round.
pub(super) struct Round<'a> {
    traffic: &'a Traffic<'a>,
    space: &'a Space,
    layers: &'a mut Layers,
    finder: &'a mut Finder,
    settings: &'a TeaSettings,
    counts: &'a mut Counts,
    robots: BTreeMap<u32, Planned>,
    /// Robots with a goal, in descending order of their priorities.
    order: Vec<u32>,
}

impl<'a> Round<'a> {
    pub(super) fn new(
        traffic: &'a Traffic<'a>,
        space: &'a Space,
        layers: &'a mut Layers,
        finder: &'a mut Finder,
        settings: &'a TeaSettings,
        counts: &'a mut Counts,
    ) -> Self {
        let robots = starts(traffic);
        let order = order(traffic, &robots);
        Self { traffic, space, layers, finder, settings, counts, robots, order }
    }

    /// Plans all paths; returns them by robot, and the robots with goals in descending order of
    /// their priorities.
    pub(super) fn run(mut self) -> (BTreeMap<u32, Path>, Vec<u32>) {
        let all: Vec<u32> = self.robots.keys().copied().collect();
        for &robot in &all {
            self.hold(robot, Change::Store);
        }
        let mut index = 0;
        while index < self.order.len() {
            index = self.plan_at(index);
        }
        self.validate();
        self.counts.looked_at += std::mem::take(&mut self.finder.looked_at);
        for &robot in &all {
            self.hold(robot, Change::Remove);
        }
        let paths = self
            .robots
            .into_iter()
            .map(|(robot, planned)| (robot, planned.path.unwrap_or(planned.start)));
        (paths.collect(), self.order)
    }

    /// Plans the path of the robot with a priority. Returns the priority to go on with.
    fn plan_at(&mut self, index: usize) -> usize {
        let robot = self.order[index];
        self.hold(robot, Change::Remove);
        let is_in_time = self.finder.looked_at < self.settings.states_per_round;
        let mut path = if is_in_time { self.find(robot, true) } else { None };
        if path.is_none() && is_in_time && self.may_swap(index) {
            self.hold(robot, Change::Store);
            self.swap(index);
            return index - 1;
        }
        if path.is_none() {
            path = self.find(robot, false);
            self.counts.relaxed += u64::from(path.is_some());
        }
        self.counts.paths += u64::from(path.is_some());
        self.counts.none += u64::from(path.is_none());
        if let Some(planned) = self.robots.get_mut(&robot) {
            planned.path = path;
        }
        self.hold(robot, Change::Store);
        index + 1
    }

    /// Whether a robot may swap its priority with the next higher one.
    fn may_swap(&self, index: usize) -> bool {
        let planned = &self.robots[&self.order[index]];
        index > 0
            && planned.swaps < self.settings.most_swaps
            && planned.ahead != Some(self.order[index - 1])
    }

    fn swap(&mut self, index: usize) {
        self.counts.swaps += 1;
        let higher = self.order[index - 1];
        self.hold(higher, Change::Remove);
        if let Some(planned) = self.robots.get_mut(&higher) {
            planned.path = None;
        }
        self.hold(higher, Change::Store);
        self.order.swap(index - 1, index);
        if let Some(planned) = self.robots.get_mut(&self.order[index - 1]) {
            planned.swaps += 1;
        }
    }

    /// From the lowest priority to the highest: plans those paths again that cross another one.
    fn validate(&mut self) {
        for index in (0..self.order.len()).rev() {
            let robot = self.order[index];
            self.hold(robot, Change::Remove);
            let path = self.robots[&robot].path.as_ref();
            let is_clear =
                path.is_none_or(|path| self.layers.is_clear(self.traffic.roads, self.space, path));
            let other = if is_clear { None } else { self.find(robot, false) };
            if let (Some(planned), Some(path)) = (self.robots.get_mut(&robot), other) {
                planned.path = Some(path);
            }
            self.hold(robot, Change::Store);
        }
    }

    /// Stores the path of a robot, or as long as it has none, its start in the first two layers.
    fn hold(&mut self, robot: u32, change: Change) {
        let (roads, planned) = (self.traffic.roads, &self.robots[&robot]);
        let until = self.layers.count() - 1;
        match (&planned.path, self.traffic.robot(robot)) {
            (Some(path), _) => self.layers.alter(roads, self.space, path, change),
            (None, Some(state))
                if stays(state, roads.end(planned.start.steps[0].leg), &planned.start) =>
            {
                self.layers.hold(roads, self.space, &planned.start, until, false, change);
            }
            (None, state) => {
                let is_under_way = state.is_some_and(|state| state.goal().is_some());
                self.layers.hold(roads, self.space, &planned.start, 1, is_under_way, change);
            }
        }
    }

    /// Searches the path of a robot to its goal.
    fn find(&mut self, robot: u32, strict: bool) -> Option<Path> {
        let planned = &self.robots[&robot];
        let goal = self.traffic.robot(robot)?.goal()?;
        let ahead = planned.ahead.and_then(|ahead| self.robots.get(&ahead));
        let path_ahead =
            ahead.filter(|ahead| ahead.start.starts_inside).and_then(|ahead| ahead.path.as_ref());
        let query = Query {
            roads: self.traffic.roads,
            space: self.space,
            layers: self.layers,
            start: &planned.start,
            earliest: path_ahead.map_or(1, |path| path.steps[0].layer.saturating_add(1)),
            goal,
            strict,
            most_states: self.settings.states_per_path,
        };
        let (traffic, base) = (self.traffic, self.traffic.claims.of(robot));
        self.finder.find(query, |leg| {
            !traffic.is_closed(leg) && base.iter().all(|stretch| stretch.leg != Some(leg))
        })
    }
}

/// Whether a robot stays where its base ends until something else happens. Idle robots don't: they
/// are sent out of the way of others.
fn stays(state: &Robot, node: u32, start: &Path) -> bool {
    state.is_pinned() || state.is_adopted() || (state.goal() == Some(node) && !start.starts_inside)
}

/// Returns the starts of robots: the end of the leg on which their base ends, or for those behind
/// others there, the inside of the leg.
fn starts(traffic: &Traffic<'_>) -> BTreeMap<u32, Planned> {
    let mut bases: Vec<(Leg, f32, u32)> = traffic
        .robots()
        .filter_map(|(robot, _)| {
            let (leg, _) = traffic.base_end(robot)?;
            Some((leg, traffic.claims.end(robot)?.to, robot))
        })
        .collect();
    bases.sort_unstable_by(|a, b| a.0.cmp(&b.0).then(b.1.total_cmp(&a.1)).then(a.2.cmp(&b.2)));
    let mut last: Option<(Leg, u32)> = None;
    let mut robots = BTreeMap::new();
    for (leg, _, robot) in bases {
        let ahead = last.filter(|last| last.0 == leg).map(|last| last.1);
        let goal = traffic.robot(robot).and_then(Robot::goal);
        let start = Path {
            steps: vec![Step { leg, layer: 0 }],
            starts_inside: ahead.is_some(),
            is_planned: false,
            done: 0,
            goal,
        };
        robots.insert(robot, Planned { start, ahead, swaps: 0, path: None });
        last = Some((leg, robot));
    }
    robots
}

/// Returns the robots with goals. Robots that were sent the longest ago come first, but each robot
/// comes after the robots ahead of it.
fn order(traffic: &Traffic<'_>, robots: &BTreeMap<u32, Planned>) -> Vec<u32> {
    let mut sorted: Vec<(f64, u32)> = Vec::new();
    for &robot in robots.keys().filter(|robot| is_planned(traffic, robots, **robot)) {
        sorted.push((traffic.robot(robot).map_or(0.0, |state| state.sent), robot));
    }
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut order: Vec<u32> = Vec::new();
    for (_, robot) in sorted {
        let chain = std::iter::successors(Some(robot), |robot| robots[robot].ahead);
        let mut queue: Vec<u32> = chain
            .filter(|robot| is_planned(traffic, robots, *robot) && !order.contains(robot))
            .collect();
        queue.reverse();
        order.append(&mut queue);
    }
    order
}

/// Whether a robot has a goal to drive to.
fn is_planned(traffic: &Traffic<'_>, robots: &BTreeMap<u32, Planned>, robot: u32) -> bool {
    let Some(state) = traffic.robot(robot) else { return false };
    let start = &robots[&robot].start;
    state.goal().is_some() && !stays(state, traffic.roads.end(start.steps[0].leg), start)
}
