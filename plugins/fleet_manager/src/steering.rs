//! Steering: sends robots to nodes, without one ever touching another.
//!
//! Each cycle: what a frame shows gives claims back behind the robots; robots without a route get one; then bases are
//! extended, as late as possible and one robot after the other, into space that nobody else claims.

mod adopt;
mod evict;
mod grant;
mod guard;
mod recovery;
mod robot;

use std::collections::VecDeque;
use std::sync::Arc;

pub use self::robot::{Robot, Seen};
use crate::claims::Claims;
use crate::planner::{Congestion, CongestionSettings, Router, Search};
use crate::roads::{Leg, Roads};

/// An order to a robot.
#[derive(Clone, Debug, PartialEq)]
pub enum Command {
    /// Replace what lies beyond its base by these legs, none of them released.
    Route {
        /// The robot.
        robot: u32,
        /// From the end of its base on.
        legs: Vec<Leg>,
    },
    /// Drop its route beyond the edge that it is on.
    Cancel {
        /// The robot.
        robot: u32,
    },
    /// Let it drive up to a place.
    Release {
        /// The robot.
        robot: u32,
        /// The leg on which its base ends then.
        leg: Leg,
        /// Metres from where the leg is entered; infinity for all of it.
        metres: f32,
    },
}

/// What can be set.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// The time from a frame to the moment at which an order that answers it takes effect, in seconds.
    pub latency_secs: f32,
    /// How far a base reaches at least beyond what a robot needs to brake, in metres.
    pub lead: f32,
    /// How long a robot waits before its route is planned again, in seconds.
    pub reroute_secs: f64,
    /// The most routes that are planned in a cycle.
    pub routes_per_cycle: usize,
    /// Whether robots that close a ring of waiters are held back.
    pub ring_guard: bool,
    /// Whether rings of waiters are taken apart.
    pub recovery: bool,
    /// How delays influence routes.
    pub congestion: CongestionSettings,
    /// Whether robots keep apart. Without it, throughput is the bound of what any management can reach.
    pub conflicts: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            latency_secs: 0.2,
            lead: 0.5,
            reroute_secs: 20.0,
            routes_per_cycle: 64,
            ring_guard: true,
            recovery: true,
            congestion: CongestionSettings::default(),
            conflicts: true,
        }
    }
}

/// Steers the robots of a fleet.
#[derive(Debug)]
pub struct Steering {
    roads: Arc<Roads>,
    settings: Settings,
    claims: Claims,
    robots: Vec<Option<Robot>>,
    congestion: Congestion,
    router: Router,
    commands: Vec<Command>,
    /// Simulated seconds.
    now: f64,
    next_recovery: f64,
    /// Figures of the run.
    pub counts: Counts,
}

/// What steering did so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Extensions of bases.
    pub grants: u64,
    /// Extensions that the ring guard refused.
    pub guarded: u64,
    /// Rings of waiters that were found.
    pub rings: u64,
    /// Robots that were sent another way because of a ring.
    pub detours: u64,
    /// Idle robots that were sent out of others' way.
    pub evictions: u64,
    /// Routes that were planned.
    pub routes: u64,
}

impl Steering {
    /// Makes the steering of a fleet without robots.
    pub fn new(roads: Arc<Roads>, settings: Settings) -> Self {
        Self {
            claims: Claims::new(&roads, settings.conflicts),
            congestion: Congestion::new(&roads, settings.congestion),
            router: Router::new(&roads),
            robots: Vec::new(),
            commands: Vec::new(),
            now: 0.0,
            next_recovery: 0.0,
            counts: Counts::default(),
            roads,
            settings,
        }
    }

    /// The roads.
    pub fn roads(&self) -> &Arc<Roads> {
        &self.roads
    }

    /// All claims.
    pub fn claims(&self) -> &Claims {
        &self.claims
    }

    /// A robot; `None` if there is none with this id.
    pub fn robot(&self, robot: u32) -> Option<&Robot> {
        self.robots.get(robot as usize)?.as_ref()
    }

    /// Sends a robot to a node. It drives there by the way that takes the least time.
    pub fn send(&mut self, robot: u32, goal: u32) {
        if let Some(state) = self.robots.get_mut(robot as usize).and_then(Option::as_mut) {
            state.goal = Some(goal);
            state.needs_route = true;
            state.is_pinned = false;
            state.is_evicted = false;
            state.is_unreachable = false;
        }
    }

    /// Leaves a robot without a goal: it stops at the end of its base, and may be sent out of others' way.
    pub fn halt(&mut self, robot: u32) {
        let Some(state) = self.robots.get_mut(robot as usize).and_then(Option::as_mut) else { return };
        state.goal = None;
        state.needs_route = false;
        state.is_pinned = false;
        state.is_evicted = false;
        state.blocker = None;
        state.waiting_since = f64::INFINITY;
        state.horizon.drain(..).for_each(|leg| self.congestion.leave(leg.edge()));
    }

    /// Leaves a robot where it is: it has something to do there, and nobody may send it away.
    pub fn stay(&mut self, robot: u32) {
        self.halt(robot);
        if let Some(state) = self.robots.get_mut(robot as usize).and_then(Option::as_mut) {
            state.is_pinned = true;
        }
    }

    /// Whether no way leads to the node that a robot was sent to.
    pub fn is_unreachable(&self, robot: u32) -> bool {
        self.robot(robot).is_some_and(|state| state.is_unreachable)
    }

    /// The node at the end of a robot's base; `None` if it is unknown or not taken over yet.
    pub fn base_end_node(&self, robot: u32) -> Option<u32> {
        self.robot(robot).filter(|state| !state.is_adopted)?;
        let (last, node) = self.base_end(robot);
        last.map(|_| node)
    }

    /// The simulated time of the last step, in seconds.
    pub fn now(&self) -> f64 {
        self.now
    }

    /// Whether a robot stands at the end of its route, which is a node that it was sent to.
    pub fn has_arrived(&self, robot: u32, goal: u32) -> bool {
        let Some(state) = self.robot(robot) else { return false };
        let Some(end) = self.claims.end(robot) else { return false };
        let is_at_end = state.speed == 0.0 && self.left(robot) < 0.02 && state.horizon.is_empty();
        let at_node = end
            .leg
            .is_some_and(|leg| self.roads.end(leg) == goal && end.to >= self.roads.edge(leg.edge()).length - 0.02);
        is_at_end && at_node && !state.needs_route
    }

    /// Forgets a robot that is not there any more.
    pub fn lose(&mut self, robot: u32) {
        let Some(state) = self.robots.get_mut(robot as usize).and_then(Option::take) else { return };
        state.horizon.iter().for_each(|leg| self.congestion.leave(leg.edge()));
        self.claims.release(robot);
    }

    /// Plans and extends after a frame, at a simulated time in seconds. Returns what to order.
    pub fn step(&mut self, now: f64) -> &[Command] {
        let passed = now - self.now;
        self.now = now;
        self.commands.clear();
        self.cancel_adopted();
        if self.is_ready() {
            self.congestion.pass(passed);
            self.settle_evicted();
            self.plan_routes();
            self.extend_bases(passed as f32);
            if now >= self.next_recovery {
                self.next_recovery = now + 1.0;
                self.evict_idle();
                self.recover();
            }
        }
        &self.commands
    }

    /// Gives routes to robots that need one, those first that need it the longest.
    fn plan_routes(&mut self) {
        let reroute = self.now - self.settings.reroute_secs;
        let mut due: Vec<(f64, u32)> = Vec::new();
        for (robot, state) in (0..).zip(&self.robots) {
            let Some(state) = state else { continue };
            let waits = !state.horizon.is_empty() && state.waiting_since.max(state.planned) < reroute;
            if state.goal.is_some() && !state.is_adopted && (state.needs_route || waits) {
                due.push((state.planned, robot));
            }
        }
        due.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        due.truncate(self.settings.routes_per_cycle);
        due.into_iter().for_each(|(_, robot)| self.plan(robot));
    }

    /// Plans the route of a robot to its goal, from the end of its base.
    fn plan(&mut self, robot: u32) {
        let Some(state) = self.robot(robot) else { return };
        let (Some(goal), (Some(last), start)) = (state.goal, self.base_end(robot)) else { return };
        let class = state.class;
        self.counts.routes += 1;
        let found = if start == goal {
            Some(Vec::new())
        } else {
            let congestion = &self.congestion;
            let search = Search { last: Some(last), start, goal };
            let delay = |leg: Leg| congestion.delay(leg.edge());
            // Robots in reverse gear meet others head-on: only where nothing else leads to the goal.
            let forward = |leg: Leg| (!leg.is_reverse()).then(|| delay(leg));
            let found = self.router.route(&self.roads, &class, search, forward);
            found.or_else(|| self.router.route(&self.roads, &class, search, |leg| Some(delay(leg))))
        };
        if let Some(state) = &mut self.robots[robot as usize] {
            state.planned = self.now;
            state.needs_route = false;
            state.is_unreachable = found.is_none();
        }
        if let Some(legs) = found {
            self.set_route(robot, legs);
        }
    }

    fn set_route(&mut self, robot: u32, legs: Vec<Leg>) {
        let Some(state) = &mut self.robots[robot as usize] else { return };
        state.horizon.iter().for_each(|leg| self.congestion.leave(leg.edge()));
        legs.iter().for_each(|leg| self.congestion.enter(leg.edge()));
        state.horizon = VecDeque::from(legs.clone());
        if !legs.is_empty() {
            self.commands.push(Command::Route { robot, legs });
        }
    }

    /// The last leg of a robot's base and the node at its end.
    fn base_end(&self, robot: u32) -> (Option<Leg>, u32) {
        let last = self.claims.of(robot).iter().rev().find_map(|stretch| stretch.leg);
        (last, last.map_or(0, |leg| self.roads.end(leg)))
    }

    /// Metres from where a robot was last seen to the end of its base.
    fn left(&self, robot: u32) -> f32 {
        self.claims.of(robot).iter().map(|stretch| stretch.to - stretch.from).sum()
    }
}
