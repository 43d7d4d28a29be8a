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
    /// Since when it wants to drive on and can't, in simulated seconds; infinity if it drives or has nowhere to go.
    pub waiting_since: f64,
    pub(super) needs_route: bool,
    /// When its route was planned, in simulated seconds.
    pub(super) planned: f64,
    /// Whether it is to be stopped and taken over.
    pub(super) is_adopted: bool,
    /// When it is ordered to stop, then.
    pub(super) cancel_at: f64,
    /// Whether it has something to do where it stands.
    pub(super) is_pinned: bool,
    /// Whether it is only on its way out of others' way.
    pub(super) is_evicted: bool,
    /// Whether no way leads to its goal.
    pub(super) is_unreachable: bool,
}

impl Robot {
    pub(super) fn new(class: RobotClass, seen: &Seen, now: f64) -> Self {
        Self {
            class,
            goal: None,
            horizon: VecDeque::new(),
            speed: seen.speed,
            blocker: None,
            waiting_since: f64::INFINITY,
            needs_route: false,
            planned: now,
            is_adopted: true,
            cancel_at: now,
            is_pinned: false,
            is_evicted: false,
            is_unreachable: false,
        }
    }

    pub(super) fn see(&mut self, seen: &Seen) {
        self.speed = seen.speed;
    }

    /// Metres that it needs to stop from its present speed.
    pub(super) fn braking_distance(&self) -> f32 {
        0.5 * self.speed * self.speed / self.class.max_acceleration
    }
}
