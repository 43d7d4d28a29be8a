//! Admission: how many robots may be on the roads at a time.
//!
//! Roads carry most robots at a certain density; with more, each waits for others, and fewer arrive (the macroscopic
//! fundamental diagram: N. Geroliminis, C. Daganzo: Existence of urban-scale macroscopic fundamental diagrams, 2008). So robots
//! are held where they are in nobody's way, in reservoirs and where they got their goals, while too many of those on the roads
//! wait for each other. Those are admitted first that others on the roads wait for.

use super::Steering;
use crate::roads::{Leg, Roads};

/// What can be set about admission.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AdmissionSettings {
    /// The share of robots on the roads that may wait for others, from 0 to 1; 1 for no limit on the robots on the roads.
    pub waiting_share: f64,
    /// Metres of road, outside of reservoirs, for each robot that is always admitted.
    pub metres_per_robot: f32,
    /// How much the number of robots changes for each unit by which the share differs, per second.
    pub gain: f64,
    /// How much earlier a robot is admitted for each one that waits for it, in seconds.
    pub secs_per_waiting: f64,
}

impl Default for AdmissionSettings {
    fn default() -> Self {
        Self { waiting_share: 0.3, metres_per_robot: 20.0, gain: 0.05, secs_per_waiting: 20.0 }
    }
}

/// How long a robot in a reservoir for which others on the roads wait is held at most, in seconds.
const HELD_SECS: f64 = 20.0;
/// The longest chain of waiting robots that is followed.
const LONGEST_CHAIN: usize = 64;

/// How many robots may be on the roads.
#[derive(Debug)]
pub(super) struct Admission {
    settings: AdmissionSettings,
    least: f64,
    most: f64,
    /// Robots on the roads.
    out: usize,
    /// By robot: how many robots on the roads wait for it, directly or not.
    pressure: Vec<u32>,
}

impl Admission {
    pub(super) fn new(roads: &Roads, settings: AdmissionSettings) -> Self {
        let edges = (0..).zip(roads.edges());
        let metres: f32 = edges.filter(|(edge, _)| !roads.is_reservoir(*edge)).map(|(_, edge)| edge.length).sum();
        let least = f64::from(metres / settings.metres_per_robot).max(1.0);
        Self { settings, least, most: least, out: 0, pressure: Vec::new() }
    }

    /// Whether one more robot may enter the roads.
    pub(super) fn is_open(&self) -> bool {
        self.settings.waiting_share >= 1.0 || (self.out as f64) < self.most
    }

    /// Records that a robot enters the roads.
    pub(super) fn enter(&mut self) {
        self.out += 1;
    }

    /// Changes the number of robots that may be on the roads, after some seconds in which `waiting` of `out` robots there
    /// have been waiting.
    fn adapt(&mut self, out: usize, waiting: usize, seconds: f32) {
        self.out = out;
        let share = waiting as f64 / out.max(1) as f64;
        let change = self.settings.gain * (self.settings.waiting_share - share) * f64::from(seconds);
        // What nobody has tried says nothing about how many may be there.
        let tried = self.least.max(1.1 * out as f64 + 1.0);
        self.most = (self.most * (1.0 + change)).clamp(self.least, tried);
    }
}

impl Steering {
    /// Counts the robots on the roads, and who waits for whom.
    pub(super) fn count_admitted(&mut self, passed: f32) {
        let (mut out, mut waiting) = (0, 0);
        let mut pressure = std::mem::take(&mut self.admission.pressure);
        pressure.clear();
        pressure.resize(self.robots.len(), 0);
        for robot in 0..self.robots.len() as u32 {
            if self.is_on_roads(robot) {
                out += 1;
                waiting += usize::from(self.robot(robot).is_some_and(|state| state.waiting_since.is_finite()));
                if let Some(held) = self.held_ahead(robot) {
                    pressure[held as usize] += 1;
                }
            }
        }
        self.admission.pressure = pressure;
        self.admission.adapt(out, waiting, passed);
    }

    /// Whether a robot is under way on roads that others need.
    pub(super) fn is_on_roads(&self, robot: u32) -> bool {
        let Some(state) = self.robot(robot) else { return false };
        let is_under_way = state.goal.is_some() && !state.is_fresh && !state.is_adopted;
        is_under_way && !self.claims.of(robot).iter().all(|stretch| self.is_in_reservoir(stretch.leg))
    }

    /// Whether a robot may enter the roads. A robot that others on the roads wait for may in any case, or they would wait for
    /// ever: at once where it is on the roads itself, and after a while in a reservoir.
    pub(super) fn may_enter(&self, robot: u32) -> bool {
        let Some(state) = self.robot(robot) else { return false };
        let is_in_way = self.admission.pressure.get(robot as usize).is_some_and(|waiting| *waiting > 0);
        let is_queued = self.claims.of(robot).iter().all(|stretch| self.is_in_reservoir(stretch.leg));
        let was_held = self.now - state.waiting_since > HELD_SECS;
        state.is_admitted
            || self.is_on_roads(robot)
            || self.admission.is_open()
            || (is_in_way && (!is_queued || was_held))
    }

    fn is_in_reservoir(&self, leg: Option<Leg>) -> bool {
        leg.is_some_and(|leg| self.roads.is_reservoir(leg.edge()))
    }

    /// The key by which robots are extended in ascending order: the planner's, less for each robot that waits for it.
    pub(super) fn precedence(&self, robot: u32, planned: f64) -> f64 {
        let pressure = self.admission.pressure.get(robot as usize).copied().unwrap_or(0);
        planned - self.settings.admission.secs_per_waiting * f64::from(pressure)
    }

    /// The robot that waits for admission, and that a robot waits for.
    fn held_ahead(&self, robot: u32) -> Option<u32> {
        let mut current = robot;
        for _ in 0..LONGEST_CHAIN {
            let state = self.robot(current)?;
            if state.is_held {
                return Some(current);
            }
            current = state.blocker.filter(|_| state.waiting_since.is_finite())?;
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn admission(least: f64) -> Admission {
        Admission { settings: AdmissionSettings::default(), least, most: least, out: 0, pressure: Vec::new() }
    }

    #[test]
    fn more_robots_are_admitted_while_few_of_them_wait() {
        let mut admission = admission(10.0);
        let mut out = 0;
        for _ in 0..600 {
            admission.adapt(out, out / 10, 0.1);
            out += usize::from(admission.is_open());
        }
        assert!(out > 15, "{out} robots after a minute");
    }

    #[test]
    fn fewer_robots_are_admitted_while_many_of_them_wait() {
        let mut admission = admission(10.0);
        admission.most = 100.0;
        (0..600).for_each(|_| admission.adapt(99, 60, 0.1));
        assert!(admission.most < 50.0 && !admission.is_open(), "{} robots after a minute", admission.most);
        (0..6000).for_each(|_| admission.adapt(9, 9, 0.1));
        assert!(admission.is_open(), "the least number is always admitted");
    }
}
