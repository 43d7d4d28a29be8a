//! What steering knows about a robot.

use std::collections::VecDeque;

use regatta_plugin::frame::RobotState;

use crate::roads::{Leg, RobotClass};

/// What a frame shows of a robot.
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
    pub position: [f32; 2],
    /// What it does.
    pub state: RobotState,
}

/// A robot.
#[derive(Clone, Debug)]
pub struct Robot {
    /// What it can do.
    pub class: RobotClass,
    /// Where it was sent.
    pub goal: Option<u32>,
    /// Legs that it will drive after its base.
    pub horizon: VecDeque<Leg>,
    /// Metres per second, at least 0.
    pub speed: f32,
    /// Who was in the way when its base was to be extended.
    pub blocker: Option<u32>,
    /// On which edge.
    pub blocked_on: Option<u32>,
    /// Since when it is held, broken or faulted, in simulated seconds; infinity if it isn't.
    pub stuck_since: f64,
    /// Since when it wants to drive on and can't, in simulated seconds; infinity if it drives or
    /// has nowhere to go.
    pub waiting_since: f64,
    /// Whether it waits until it is admitted to the roads.
    pub is_held: bool,
    /// Who was in the way on which edge, and the version of its claim: until that changes, it is
    /// still in the way.
    pub(crate) blocked_by: Option<((u32, u32), u64)>,
    /// When it was sent to its goal, in simulated seconds.
    pub(crate) sent: f64,
    /// Whether it hasn't driven since it was sent to its goal.
    pub(crate) is_fresh: bool,
    /// By how many legs its base may grow in this cycle.
    pub(crate) most_legs: usize,
    /// Whether its base may end anywhere in this cycle.
    pub(crate) is_following: bool,
    /// By how many legs its base may grow in this cycle without coming into a region that it is
    /// kept out of.
    pub(crate) legs_outside: usize,
    /// Whether its base stays as it is in this cycle.
    pub(crate) is_frozen: bool,
    /// Whether it may enter the roads in this cycle, however many are there.
    pub(crate) is_admitted: bool,
    /// Who is extended first in this cycle, in ascending order.
    pub(crate) precedence: f64,
    /// Whether it was sent to a goal, and has no route to it yet.
    pub needs_route: bool,
    /// When its route was planned, in simulated seconds.
    pub planned: f64,
    /// Whether it is to be stopped and taken over.
    pub is_adopted: bool,
    /// Whether it may drive beyond what it claims, until it stands.
    pub(crate) is_lost: bool,
    /// When it is ordered to stop, then.
    pub(crate) cancel_at: f64,
    /// Whether it has something to do where it stands.
    pub(crate) is_pinned: bool,
    /// Whether it is only on its way out of others' way.
    pub(crate) is_evicted: bool,
    /// Whether no way leads to its goal.
    pub(crate) is_unreachable: bool,
}

impl Robot {
    pub(crate) fn new(class: RobotClass, seen: &Seen, now: f64) -> Self {
        Self {
            class,
            goal: None,
            horizon: VecDeque::new(),
            speed: seen.speed,
            blocker: None,
            blocked_on: None,
            most_legs: usize::MAX,
            is_following: false,
            precedence: now,
            legs_outside: usize::MAX,
            is_frozen: false,
            is_admitted: false,
            waiting_since: f64::INFINITY,
            stuck_since: f64::INFINITY,
            is_held: false,
            blocked_by: None,
            sent: now,
            is_fresh: true,
            needs_route: false,
            planned: now,
            is_adopted: true,
            is_lost: true,
            cancel_at: now,
            is_pinned: false,
            is_evicted: false,
            is_unreachable: false,
        }
    }

    pub(crate) fn see(&mut self, seen: &Seen, now: f64) {
        self.speed = seen.speed;
        let is_stuck =
            matches!(seen.state, RobotState::Held | RobotState::Broken | RobotState::Faulted);
        self.stuck_since = if is_stuck { self.stuck_since.min(now) } else { f64::INFINITY };
    }

    /// Metres that it needs to stop from its present speed.
    pub(crate) fn braking_distance(&self) -> f32 {
        0.5 * self.speed * self.speed / self.class.max_acceleration
    }
}
