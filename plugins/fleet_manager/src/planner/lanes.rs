//! The planner `lanes`, for roads whose lanes are driven one way.
//!
//! Robots take the way that costs the least time, with the time added that others have lost on it
//! lately. Rings of robots that wait for each other are taken apart by sending one of them another
//! way.

mod congestion;
mod detours;

use std::panic::resume_unwind;

pub use self::congestion::CongestionSettings;
use self::congestion::{Congestion, Guide};
use super::route::Hints;
use super::{Bound, DrivingTimes, Planner, Plans, Router, Search};
use crate::roads::{Leg, Roads};
use crate::traffic::{Robot, Traffic};

/// The settings of the planner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LanesSettings {
    /// The time that a robot waits before its route is planned again, in seconds.
    pub reroute_secs: f64,
    /// The number of legs that searches may expand in a cycle; later searches are put off to the
    /// next cycle.
    pub legs_per_cycle: usize,
    /// Whether rings of waiters are taken apart.
    pub detours: bool,
    /// The influence of delays on routes.
    pub congestion: CongestionSettings,
}

impl Default for LanesSettings {
    fn default() -> Self {
        let congestion = CongestionSettings::default();
        Self { reroute_secs: 5.0, legs_per_cycle: 40_000, detours: true, congestion }
    }
}

/// The largest number of routes that are searched in parallel, without knowing of each other. As it
/// doesn't depend on the number of threads, routes don't, either.
const BATCH: usize = 16;
/// The number of routes in the first batch: the length of searches isn't known yet.
const FIRST_BATCH: usize = 4;
/// The number of edges from which on searches take longer than to start a thread.
const FEWEST_EDGES: usize = 10_000;
/// The number of trees of fastest ways that are computed in a cycle.
const TREES: usize = 1;
/// The same after a cycle in which routes were put off, as when a whole fleet gets its first ones:
/// then delays change fast.
const TREES_BEHIND: usize = 4;
/// The share by which a route may take longer than the fastest one, on many edges. Expected delays
/// are by far less exact.
const SLACK: f32 = 0.1;
/// The same while routes are put off.
const SLACK_BEHIND: f32 = 0.3;
/// The number of routes that take less time to search without driving times than these take.
const FEW_ROUTES: u8 = 5;
/// The interval at which the robots on the way to each edge are counted, in seconds.
const COUNT_SECS: f64 = 1.0;

/// The planner.
#[derive(Debug)]
pub struct Lanes {
    settings: LanesSettings,
    congestion: Congestion,
    /// None on few edges, where driving times are known.
    guide: Option<Guide>,
    /// The driving times to the goals of most routes, without a guide.
    times: DrivingTimes,
    /// By node: how many routes to it were planned, up to [`FEW_ROUTES`].
    planned_to: Vec<u8>,
    /// One for each thread.
    routers: Vec<Router>,
    /// The routes of the next batch.
    batch: usize,
    /// Whether routes were put off to the next cycle.
    is_behind: bool,
    last: f64,
    next_count: f64,
    next_rings: f64,
    routes: u64,
    rings: u64,
    detours: u64,
}

/// A route that is to be planned.
#[derive(Clone, Copy)]
struct Due {
    /// When the last one was planned, in simulated seconds.
    planned: f64,
    robot: u32,
}

impl Lanes {
    /// Makes the planner for some roads.
    pub fn new(roads: &Roads, settings: LanesSettings) -> Self {
        let cores = std::thread::available_parallelism().map_or(1, usize::from).min(BATCH);
        let threads = if roads.edges().len() < FEWEST_EDGES { 1 } else { cores };
        Self {
            congestion: Congestion::new(roads, settings.congestion),
            guide: (roads.edges().len() >= FEWEST_EDGES).then(|| Guide::new(roads)),
            times: DrivingTimes::default(),
            planned_to: vec![0; roads.nodes() as usize],
            routers: (0..threads).map(|_| Router::new(roads)).collect(),
            settings,
            batch: FIRST_BATCH,
            is_behind: false,
            last: 0.0,
            next_count: 0.0,
            next_rings: 0.0,
            routes: 0,
            rings: 0,
            detours: 0,
        }
    }

    /// Updates the delays and the load of edges.
    fn observe(&mut self, traffic: &Traffic<'_>) {
        let passed = traffic.now - self.last;
        self.last = traffic.now;
        self.congestion.pass(passed);
        for (_, state) in traffic.robots() {
            if let Some(blocker) = state.blocker.filter(|_| state.waiting_since.is_finite()) {
                self.congestion.lose(blocker.edge, passed as f32);
            }
        }
        if traffic.now >= self.next_count {
            self.next_count = traffic.now + COUNT_SECS;
            self.congestion.count(traffic.robots().flat_map(|(_, state)| &state.horizon));
        }
        if let Some(guide) = &mut self.guide {
            let trees = if self.is_behind { TREES_BEHIND } else { TREES };
            guide.go_on(traffic.roads, &mut self.congestion, trees, self.routers.len());
        }
        self.congestion.settle();
    }

    /// Plans routes for robots that need one, those first that need it the longest.
    fn plan_routes(&mut self, traffic: &Traffic<'_>, plans: &mut Plans) {
        self.times.begin();
        let mut looked_at = 0;
        let due = self.due(traffic);
        let mut due = due.as_slice();
        while !due.is_empty() && looked_at < self.settings.legs_per_cycle {
            let (batch, rest) = due.split_at(self.batch.min(due.len()));
            due = rest;
            let mut spent = 0;
            for (due, (legs, cost)) in batch.iter().zip(self.search(traffic, batch)) {
                spent += cost;
                self.set_route(*due, legs, traffic, plans);
            }
            looked_at += spent;
            // If searches are long, because goals can't be reached or delays change fast, few of
            // them begin at once.
            self.batch =
                (self.settings.legs_per_cycle * batch.len() / spent.max(1)).clamp(1, BATCH);
        }
        self.is_behind = !due.is_empty();
    }

    fn set_route(
        &mut self,
        due: Due,
        legs: Option<Vec<Leg>>,
        traffic: &Traffic<'_>,
        plans: &mut Plans,
    ) {
        self.routes += 1;
        let Some(legs) = legs else { return plans.unreachable(due.robot) };
        let before = traffic.robot(due.robot).map(|state| &state.horizon);
        self.congestion.replace(before.into_iter().flatten(), &legs);
        plans.route(due.robot, legs);
    }

    /// The robots that need a route, in the order in which they get one: those without a route come
    /// before those that wait.
    fn due(&self, traffic: &Traffic<'_>) -> Vec<Due> {
        let reroute = traffic.now - self.settings.reroute_secs;
        let mut due: Vec<(bool, Due)> = Vec::new();
        for (robot, state) in traffic.robots() {
            let waits = !state.is_held
                && !state.horizon.is_empty()
                && state.waiting_since.max(state.planned) < reroute;
            if state.is_under_way() && (state.needs_route() || waits) {
                due.push((!state.needs_route(), Due { planned: state.planned, robot }));
            }
        }
        // The sort is stable: among equals, robots come in the order of their ids.
        due.sort_by(|(a, x), (b, y)| a.cmp(b).then(x.planned.total_cmp(&y.planned)));
        due.into_iter().map(|(_, due)| due).collect()
    }

    /// Prepares the driving times to the goals to which routes are planned again and again.
    fn prepare_times(&mut self, traffic: &Traffic<'_>, batch: &[Due]) {
        for goal in batch.iter().filter_map(|due| traffic.robot(due.robot)?.goal()) {
            let planned = &mut self.planned_to[goal as usize];
            if *planned == FEW_ROUTES {
                self.times.prepare(traffic.roads, goal);
            } else {
                *planned += 1;
            }
        }
    }

    /// Searches the routes of some robots; with each comes the number of legs that were looked at.
    fn search(&mut self, traffic: &Traffic<'_>, batch: &[Due]) -> Vec<(Option<Vec<Leg>>, usize)> {
        if self.guide.is_none() {
            self.prepare_times(traffic, batch);
        }
        let congestion = &self.congestion;
        let estimates = Estimates {
            guide: self.guide.as_ref(),
            times: &self.times,
            slack: if self.is_behind { SLACK_BEHIND } else { SLACK },
        };
        let share = batch.len().div_ceil(self.routers.len());
        if let [router] = self.routers.as_mut_slice() {
            return search_all(router, congestion, estimates, traffic, batch);
        }
        std::thread::scope(|scope| {
            let mut threads = Vec::new();
            for (router, part) in self.routers.iter_mut().zip(batch.chunks(share)) {
                threads.push(
                    scope.spawn(move || search_all(router, congestion, estimates, traffic, part)),
                );
            }
            // A panic is propagated: robots must not get the routes of other robots.
            threads
                .into_iter()
                .flat_map(|thread| thread.join().unwrap_or_else(|panic| resume_unwind(panic)))
                .collect()
        })
    }
}

/// The estimates of the times to goals.
#[derive(Clone, Copy)]
struct Estimates<'a> {
    guide: Option<&'a Guide>,
    times: &'a DrivingTimes,
    slack: f32,
}

impl<'a> Estimates<'a> {
    fn bound(&self, roads: &'a Roads, goal: u32) -> Bound<'a> {
        match (self.guide, self.times.millis_to(roads, goal)) {
            (Some(guide), _) => Bound::Landmarks(guide.landmarks()),
            (None, Some(millis)) => Bound::Millis(millis),
            (None, None) => Bound::Distance,
        }
    }
}

impl Planner for Lanes {
    fn plan(&mut self, traffic: &Traffic<'_>, plans: &mut Plans) {
        self.observe(traffic);
        self.plan_routes(traffic, plans);
        self.take_rings_apart(traffic, plans);
    }

    fn counts(&self) -> Vec<(&'static str, u64)> {
        vec![("routes", self.routes), ("rings", self.rings), ("detours", self.detours)]
    }
}

/// Searches the routes of some robots with one router, as [`Lanes::search`] does.
fn search_all(
    router: &mut Router,
    congestion: &Congestion,
    estimates: Estimates<'_>,
    traffic: &Traffic<'_>,
    batch: &[Due],
) -> Vec<(Option<Vec<Leg>>, usize)> {
    let mut found = Vec::with_capacity(batch.len());
    for due in batch {
        let goal = traffic.robot(due.robot).and_then(Robot::goal);
        let hints = Hints {
            bound: goal.map_or(Bound::Distance, |goal| estimates.bound(traffic.roads, goal)),
            slack: estimates.slack,
        };
        found.push(router.route_of(traffic, due.robot, hints, |leg| {
            (!traffic.is_closed(leg)).then(|| congestion.delay(leg.edge()))
        }));
    }
    found
}

#[cfg(test)]
mod tests;
