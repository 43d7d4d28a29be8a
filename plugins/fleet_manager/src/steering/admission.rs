//! Admission: a limit on the number of robots on the roads.
//!
//! Robots are held in reservoirs, and at the places where they got their goals, while too many of
//! the robots on the roads wait for each other (see [`Density`]). Robots for which others on the
//! roads wait are admitted first.

use super::Steering;
use crate::density::{Density, DensitySettings};
use crate::roads::{Leg, Roads};

/// The settings of admission.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AdmissionSettings {
    /// The limit on robots on the roads.
    pub density: DensitySettings,
    /// Metres of road, outside of reservoirs, for each robot that is always admitted.
    pub metres_per_robot: f32,
    /// The advance in admission that a robot gets for each one that waits for it, in seconds.
    pub secs_per_waiting: f64,
}

impl AdmissionSettings {
    /// Admits all robots at once.
    pub fn unlimited() -> Self {
        let density = DensitySettings { waiting_share: 1.0, ..DensitySettings::default() };
        Self { density, ..Self::default() }
    }
}

impl Default for AdmissionSettings {
    fn default() -> Self {
        Self { density: DensitySettings::default(), metres_per_robot: 20.0, secs_per_waiting: 20.0 }
    }
}

/// The longest time for which a robot in a reservoir is held while others on the roads wait for it,
/// in seconds.
const HELD_SECS: f64 = 20.0;
/// The longest chain of waiting robots that is followed.
const LONGEST_CHAIN: usize = 64;

/// The limit on robots on the roads, and the robots that wait for those that are held.
#[derive(Debug)]
pub(super) struct Admission {
    density: Density,
    /// By robot: how many robots on the roads wait for it, directly or not.
    pressure: Vec<u32>,
}

impl Admission {
    pub(super) fn new(roads: &Roads, settings: AdmissionSettings) -> Self {
        let edges = (0..).zip(roads.edges());
        let metres: f32 =
            edges.filter(|(edge, _)| !roads.is_reservoir(*edge)).map(|(_, edge)| edge.length).sum();
        let density = Density::new(settings.density, f64::from(metres / settings.metres_per_robot));
        Self { density, pressure: Vec::new() }
    }

    /// Records that a robot enters the roads.
    pub(super) fn enter(&mut self) {
        self.density.enter();
    }
}

impl Steering {
    /// Counts the robots on the roads, and the robots that wait for each.
    pub(super) fn count_admitted(&mut self, passed: f32) {
        let (mut out, mut waiting) = (0, 0);
        let mut pressure = std::mem::take(&mut self.admission.pressure);
        pressure.clear();
        pressure.resize(self.robots.len(), 0);
        for robot in 0..self.robots.len() as u32 {
            if self.is_on_roads(robot) {
                out += 1;
                waiting += usize::from(
                    self.robot(robot).is_some_and(|state| state.waiting_since.is_finite()),
                );
                if let Some(held) = self.held_ahead(robot) {
                    pressure[held as usize] += 1;
                }
            }
        }
        self.admission.pressure = pressure;
        self.admission.density.adapt(out, waiting, passed);
    }

    /// Whether a robot is under way on roads that others need.
    pub(super) fn is_on_roads(&self, robot: u32) -> bool {
        let Some(state) = self.robot(robot) else { return false };
        let is_under_way = state.is_under_way() && !state.is_fresh;
        is_under_way
            && !self.claims.of(robot).iter().all(|stretch| self.is_in_reservoir(stretch.leg))
    }

    /// Whether a robot may enter the roads. A robot that others on the roads wait for may in any
    /// case, or they would wait for ever: at once where it is on the roads itself, and after a
    /// while in a reservoir.
    pub(super) fn may_enter(&self, robot: u32) -> bool {
        let Some(state) = self.robot(robot) else { return false };
        let is_in_way =
            self.admission.pressure.get(robot as usize).is_some_and(|waiting| *waiting > 0);
        let is_queued =
            self.claims.of(robot).iter().all(|stretch| self.is_in_reservoir(stretch.leg));
        let was_held = self.now - state.waiting_since > HELD_SECS;
        state.permit.is_admitted
            || self.is_on_roads(robot)
            || self.admission.density.is_open()
            || (is_in_way && (!is_queued || was_held))
    }

    fn is_in_reservoir(&self, leg: Option<Leg>) -> bool {
        leg.is_some_and(|leg| self.roads.is_reservoir(leg.edge()))
    }

    /// The key by which robots are extended in ascending order: the planner's, less for each robot
    /// that waits for it.
    pub(super) fn precedence(&self, robot: u32, planned: f64) -> f64 {
        let pressure = self.admission.pressure.get(robot as usize).copied().unwrap_or(0);
        planned - self.settings.admission.secs_per_waiting * f64::from(pressure)
    }

    /// The robot that waits for admission at the end of the chain of blockers of a robot.
    fn held_ahead(&self, robot: u32) -> Option<u32> {
        let mut current = robot;
        for _ in 0..LONGEST_CHAIN {
            let state = self.robot(current)?;
            if state.is_held {
                return Some(current);
            }
            current = state.blocker.filter(|_| state.waiting_since.is_finite())?.robot;
        }
        None
    }
}
