//! The state that steering keeps of each robot.

use std::collections::VecDeque;

use glam::Vec2;
use regatta_plugin::frame::RobotState;

use crate::roads::{Leg, RobotClass};

/// A robot as a frame shows it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// Index of the robot type.
    pub robot_type: usize,
    /// The edge that it is on.
    pub edge: Option<u32>,
    /// Metres from the edge's origin.
    pub s: f32,
    /// Metres per second, at least 0.
    pub speed: f32,
    /// Position, in metres.
    pub position: Vec2,
    /// The state of its motion.
    pub state: RobotState,
}

/// The purpose for which a robot stands or drives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Errand {
    /// None: the robot may be sent out of the way of others.
    None,
    /// An action at the place where it stands.
    Pinned,
    /// A node that it was sent to.
    Sent(u32),
    /// A node where it is out of the way of others.
    Evicted(u32),
}

/// The state of a robot's route to its goal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RouteState {
    /// The horizon leads there, as far as a planner has planned.
    Planned,
    /// A planner has to plan it.
    Needed,
    /// No way leads there.
    Unreachable,
}

/// Whether steering controls a robot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Custody {
    /// It drives only into space that it claims.
    Steered,
    /// It is stopped, to be taken over where it stands.
    Stopping {
        /// The time at which the robot is commanded to stop (again), in simulated seconds.
        cancel_at: f64,
        /// Whether it may drive beyond what it claims until it stands.
        is_lost: bool,
    },
}

/// The permission that a planner gives a robot for one cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Permit {
    /// Robots are extended in ascending order of it; by default the time at which the robot was
    /// sent to its goal, in simulated seconds.
    pub precedence: Option<f64>,
    /// The largest number of legs by which its base may grow.
    pub max_legs: usize,
    /// The largest number of legs by which its base may grow without entering a region that it is
    /// kept out of. Unlike one that `max_legs` holds, the robot waits for room: the ring guard
    /// knows where it will go on to.
    pub max_legs_outside: usize,
    /// Whether its base may end anywhere that the robots ahead leave free, not only at places where
    /// it blocks no one.
    pub follows: bool,
    /// Whether its base stays as it is.
    pub is_frozen: bool,
    /// Whether it may enter the roads, however many robots are there.
    pub is_admitted: bool,
}

impl Default for Permit {
    fn default() -> Self {
        Self {
            precedence: None,
            max_legs: usize::MAX,
            max_legs_outside: usize::MAX,
            follows: false,
            is_frozen: false,
            is_admitted: false,
        }
    }
}

/// A robot that is in the way of another one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Blocker {
    /// The robot.
    pub robot: u32,
    /// The edge on which it is in the way.
    pub edge: u32,
}

/// A robot.
#[derive(Clone, Debug)]
pub struct Robot {
    /// Its footprint and its limits.
    pub class: RobotClass,
    /// The purpose for which it stands or drives.
    pub errand: Errand,
    /// The state of its route.
    pub route: RouteState,
    /// Whether steering controls it.
    pub custody: Custody,
    /// The permission of its planner for this cycle.
    pub permit: Permit,
    /// Legs that it will drive after its base.
    pub horizon: VecDeque<Leg>,
    /// Metres per second, at least 0.
    pub speed: f32,
    /// The state of its motion.
    pub(crate) state: RobotState,
    /// The robot that was in the way when its base was to be extended.
    pub blocker: Option<Blocker>,
    /// Since when it is held, broken or faulted, in simulated seconds; infinity if it isn't.
    pub stuck_since: f64,
    /// Since when it wants to drive on and can't, in simulated seconds; infinity if it drives or
    /// has nowhere to go.
    pub waiting_since: f64,
    /// Whether it waits until it is admitted to the roads.
    pub is_held: bool,
    /// When its route was planned, in simulated seconds.
    pub planned: f64,
    /// When it was sent to its goal, in simulated seconds.
    pub(crate) sent: f64,
    /// Whether it has asked for a longer base since its base was last extended.
    pub(crate) wants_base: bool,
    /// Whether it is taken to drive in reverse gear if it is taken over on an edge.
    pub(crate) is_backing: bool,
    /// The leg at whose beginning it counts as standing, since it is on a node to which no edge
    /// leads. Its first route has to begin with that leg.
    pub(crate) unentered: Option<Leg>,
    /// Whether it hasn't driven since it was sent to its goal.
    pub(crate) is_fresh: bool,
    /// The blocker of a standing robot, and the version of its claim. Until the version changes,
    /// the robot stays blocked.
    pub(crate) blocked_by: Option<(Blocker, u64)>,
}

impl Robot {
    /// Makes a robot that is to be taken over where it stands.
    pub(crate) fn new(class: RobotClass, seen: &Seen, now: f64) -> Self {
        Self {
            class,
            errand: Errand::None,
            route: RouteState::Needed,
            custody: Custody::Stopping { cancel_at: now, is_lost: true },
            permit: Permit::default(),
            horizon: VecDeque::new(),
            speed: seen.speed,
            state: seen.state,
            blocker: None,
            waiting_since: f64::INFINITY,
            stuck_since: f64::INFINITY,
            is_held: false,
            blocked_by: None,
            sent: now,
            is_fresh: true,
            wants_base: false,
            is_backing: false,
            unentered: None,
            planned: now,
        }
    }

    pub(crate) fn see(&mut self, seen: &Seen, now: f64) {
        self.speed = seen.speed;
        self.state = seen.state;
        let is_stuck =
            matches!(seen.state, RobotState::Held | RobotState::Broken | RobotState::Faulted);
        self.stuck_since = if is_stuck { self.stuck_since.min(now) } else { f64::INFINITY };
    }

    /// Stops the robot, so that it can be taken over when it is idle.
    pub(crate) fn stop(&mut self, now: f64) {
        self.custody = Custody::Stopping { cancel_at: now, is_lost: self.is_lost() };
        self.route = RouteState::Needed;
        self.wants_base = false;
        self.horizon.clear();
    }

    /// Drops the route of a robot that has a goal, so that another one is planned.
    pub(crate) fn replan(&mut self) {
        if self.goal().is_some() {
            self.route = RouteState::Needed;
        }
    }

    /// The node that it was sent to.
    pub fn goal(&self) -> Option<u32> {
        match self.errand {
            Errand::None | Errand::Pinned => None,
            Errand::Sent(goal) | Errand::Evicted(goal) => Some(goal),
        }
    }

    /// Whether it was sent to a goal, and has no route to it yet.
    pub fn needs_route(&self) -> bool {
        self.route == RouteState::Needed
    }

    /// Whether no way leads to its goal.
    pub fn is_unreachable(&self) -> bool {
        self.route == RouteState::Unreachable
    }

    /// Whether it has to stay where it stands.
    pub fn is_pinned(&self) -> bool {
        self.errand == Errand::Pinned
    }

    /// Whether it is to be stopped and taken over.
    pub fn is_adopted(&self) -> bool {
        self.custody != Custody::Steered
    }

    /// Whether it may drive beyond what it claims, until it stands.
    pub(crate) fn is_lost(&self) -> bool {
        matches!(self.custody, Custody::Stopping { is_lost: true, .. })
    }

    /// Whether it is steered towards a goal.
    pub(crate) fn is_under_way(&self) -> bool {
        self.goal().is_some() && !self.is_adopted()
    }

    /// Whether it has nowhere to go, and may be sent elsewhere: it has no goal, or none that it
    /// can reach.
    pub(crate) fn is_idle(&self) -> bool {
        self.goal().is_none() || self.is_unreachable()
    }

    /// Metres that it needs to stop from its present speed.
    pub(crate) fn braking_distance(&self) -> f32 {
        0.5 * self.speed * self.speed / self.class.max_acceleration
    }
}
