//! What steering knows about a robot.

use std::collections::VecDeque;

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
    /// Whether it was seen where it claims nothing.
    pub(super) is_lost: bool,
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
            is_lost: false,
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
