//! Steering: sends robots to nodes so that they never touch.
//!
//! Each cycle, robots give back the claims behind them, and those without a route get one. Then
//! bases are extended, as late as possible and one robot after the other, into space that no other
//! robot claims.

mod admission;
mod adopt;
mod closures;
mod evict;
mod grant;
#[cfg(test)]
mod tests;

use std::collections::VecDeque;
use std::sync::Arc;

use regatta_plugin::closure::ClosedEdge;
use regatta_plugin::frame::RobotState;

use self::admission::Admission;
pub use self::admission::AdmissionSettings;
use self::closures::Closures;
use crate::claims::Claims;
use crate::planner::{Planner, Plans};
use crate::roads::{Leg, Roads};
use crate::traffic::{BaseEnds, Errand, Permit, Robot, RouteState, Traffic};

/// A command to a robot.
#[derive(Clone, Debug, PartialEq)]
pub enum Command {
    /// Replace its horizon by these legs, none of them released.
    Route {
        /// The robot.
        robot: u32,
        /// The legs from the end of its base on.
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

impl Command {
    /// The robot.
    pub const fn robot(&self) -> u32 {
        match self {
            Self::Route { robot, .. } | Self::Release { robot, .. } | Self::Cancel { robot } => {
                *robot
            }
        }
    }
}

/// The metres to the end of its base, or of an edge, within which a robot counts as being there.
const AT_REST: f32 = 2e-3;

/// The settings of steering.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// The time from a frame to the moment at which a command that answers it takes effect, in
    /// seconds.
    pub latency_secs: f32,
    /// The least distance that a base extends beyond the braking distance, in metres.
    pub lead: f32,
    /// Whether a dead end is entered only while it is empty.
    pub stub_guard: bool,
    /// The limit on robots that are on the roads at the same time.
    pub admission: AdmissionSettings,
    /// Whether robots keep apart. Without it, the throughput is an upper bound for any management.
    pub conflicts: bool,
    /// The places where bases may end.
    pub ends: BaseEnds,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            latency_secs: 0.2,
            lead: 0.5,
            stub_guard: true,
            admission: AdmissionSettings::default(),
            conflicts: true,
            ends: BaseEnds::default(),
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
    closures: Closures,
    /// Edges that are closed by a command, sorted by id.
    closed_by_command: Vec<ClosedEdge>,
    /// Their indices, sorted.
    closed_edges: Vec<u32>,
    /// Whether they have changed since closures were last computed.
    is_closed_anew: bool,
    /// Robots that block roads, and the versions of their claims.
    blockers: Vec<(u32, u64)>,
    /// The number of times that closures have changed.
    closure_changes: u64,
    admission: Admission,
    planner: Box<dyn Planner>,
    plans: Plans,
    commands: Vec<Command>,
    /// Simulated seconds.
    now: f64,
    /// The time of the next check of closures and of idle robots in the way, in simulated seconds.
    next_check: f64,
    /// Figures of the run.
    pub counts: Counts,
}

/// Counters of the run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Extensions of bases.
    pub grants: u64,
    /// Extensions that the ring guard refused.
    pub guarded: u64,
    /// Idle robots that were sent out of the way of others.
    pub evictions: u64,
}

impl Steering {
    /// Makes the steering of a fleet without robots.
    pub fn new(roads: Arc<Roads>, planner: Box<dyn Planner>, settings: Settings) -> Self {
        Self {
            claims: Claims::new(&roads, settings.conflicts),
            admission: Admission::new(&roads, settings.admission),
            closures: Closures::none(&roads),
            closed_by_command: Vec::new(),
            closed_edges: Vec::new(),
            is_closed_anew: false,
            blockers: Vec::new(),
            closure_changes: 0,
            planner,
            plans: Plans::default(),
            robots: Vec::new(),
            commands: Vec::new(),
            now: 0.0,
            next_check: 0.0,
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

    /// All robots, by id.
    pub fn robots(&self) -> impl Iterator<Item = u32> {
        let robots = (0..).zip(&self.robots);
        robots.filter(|(_, state)| state.is_some()).map(|(robot, _)| robot)
    }

    /// Sends a robot to a node. It drives there by the way that takes the least time.
    pub fn send(&mut self, robot: u32, goal: u32) {
        let now = self.now;
        if let Some(state) = self.robot_mut(robot) {
            state.errand = Errand::Sent(goal);
            state.route = RouteState::Needed;
            (state.is_fresh, state.wants_base) = (true, false);
            state.sent = now;
        }
    }

    /// Leaves a robot without a goal: it stops at the end of its base, and may be sent out of the
    /// way of others.
    pub fn halt(&mut self, robot: u32) {
        let Some(state) = self.robot_mut(robot) else { return };
        state.errand = Errand::None;
        state.route = RouteState::Planned;
        state.blocker = None;
        state.waiting_since = f64::INFINITY;
        state.horizon.clear();
    }

    /// Keeps a robot where it is: it has something to do there, and is not sent away.
    pub fn stay(&mut self, robot: u32) {
        self.halt(robot);
        if let Some(state) = self.robot_mut(robot) {
            state.errand = Errand::Pinned;
        }
    }

    /// Whether no way leads to the node that a robot was sent to.
    pub fn is_unreachable(&self, robot: u32) -> bool {
        self.robot(robot).is_some_and(Robot::is_unreachable)
    }

    /// The node at the end of a robot's base; `None` if it is unknown or not taken over yet.
    pub fn base_end_node(&self, robot: u32) -> Option<u32> {
        self.robot(robot).filter(|state| !state.is_adopted())?;
        self.traffic().base_end(robot).map(|(_, node)| node)
    }

    /// The simulated time of the last step, in seconds.
    pub fn now(&self) -> f64 {
        self.now
    }

    /// Whether a robot stands at the end of its route, which is a node that it was sent to.
    pub fn has_arrived(&self, robot: u32, goal: u32) -> bool {
        let Some(state) = self.robot(robot) else { return false };
        let Some(end) = self.claims.end(robot) else { return false };
        let is_at_end =
            state.speed == 0.0 && self.traffic().left(robot) < AT_REST && state.horizon.is_empty();
        let at_node = end.leg.is_some_and(|leg| {
            self.roads.end(leg) == goal && end.to >= self.roads.edge(leg.edge()).length - AT_REST
        });
        is_at_end && at_node && !state.needs_route()
    }

    /// Forgets a robot that is not there any more.
    pub fn lose(&mut self, robot: u32) {
        if self.robots.get_mut(robot as usize).and_then(Option::take).is_some() {
            self.claims.release(robot);
        }
    }

    /// Plans and extends after a frame, at a simulated time in seconds. Returns the commands to
    /// send.
    pub fn step(&mut self, now: f64) -> &[Command] {
        let passed = now - self.now;
        self.now = now;
        self.commands.clear();
        self.cancel_adopted();
        self.cancel_remains();
        if self.is_ready() {
            self.settle_evicted();
            if now >= self.next_check || self.is_blocker_back() {
                self.close_roads();
            }
            self.plan();
            self.extend_bases(passed as f32);
            if now >= self.next_check {
                self.next_check = now + 1.0;
                self.evict_idle();
            }
        }
        &self.commands
    }

    /// Cancels what is left of the routes of robots without a goal that stand at the end of their
    /// bases. They would wait for a release that never comes, and chargers charge idle robots only.
    fn cancel_remains(&mut self) {
        for robot in 0..self.robots.len() as u32 {
            let Some(state) = self.robot(robot) else { continue };
            let is_left =
                state.state == RobotState::Waiting && state.goal().is_none() && !state.is_adopted();
            if is_left && state.speed == 0.0 && self.traffic().left(robot) < AT_REST {
                self.commands.push(Command::Cancel { robot });
            }
        }
    }

    /// Lets the planner plan, and takes its plans over.
    fn plan(&mut self) {
        for state in self.robots.iter_mut().flatten() {
            state.permit = Permit::default();
        }
        let mut plans = std::mem::take(&mut self.plans);
        // Not `self.traffic()`, which would borrow the planner, too.
        let Self { roads, claims, robots, closures, now, .. } = self;
        let (closed, Settings { stub_guard, ends, .. }) = (&closures.legs, self.settings);
        self.planner.plan(
            &Traffic { roads, claims, robots, closed, stub_guard, ends, now: *now },
            &mut plans,
        );
        for (state, permit) in self.robots.iter_mut().zip(plans.take_permits()) {
            if let Some(state) = state {
                state.permit = permit;
            }
        }
        for state in self.robots.iter_mut().flatten() {
            // A robot that is evicted below is extended as one that was sent before.
            state.permit.precedence.get_or_insert(state.sent);
        }
        for (robot, goal) in plans.evicted.drain(..) {
            self.evict(robot, goal);
        }
        for (robot, legs) in plans.routes.drain(..) {
            self.set_route(robot, legs);
        }
        for robot in plans.released.drain(..) {
            if let Some(state) = self.robot_mut(robot) {
                state.replan();
            }
        }
        self.plans = plans;
    }

    fn set_route(&mut self, robot: u32, legs: Option<Vec<Leg>>) {
        let now = self.now;
        let Some(state) = self.robot_mut(robot) else { return };
        state.planned = now;
        let Some(legs) = legs else {
            state.route = RouteState::Unreachable;
            return;
        };
        // Most robots that wait keep their route.
        let is_same = state.route == RouteState::Planned && state.horizon == legs;
        if is_same && state.unentered.is_none() {
            return;
        }
        state.route = RouteState::Planned;
        state.blocked_by = None;
        state.horizon = VecDeque::from(legs.clone());
        let legs: Vec<Leg> = state.unentered.into_iter().chain(legs).collect();
        if !legs.is_empty() {
            self.commands.push(Command::Route { robot, legs });
        }
    }

    fn robot_mut(&mut self, robot: u32) -> Option<&mut Robot> {
        self.robots.get_mut(robot as usize)?.as_mut()
    }

    /// The traffic, as planners see it.
    pub fn traffic(&self) -> Traffic<'_> {
        let Self { roads, claims, robots, closures, now, .. } = self;
        let (closed, Settings { stub_guard, ends, .. }) = (&closures.legs, self.settings);
        Traffic { roads, claims, robots, closed, stub_guard, ends, now: *now }
    }
}
