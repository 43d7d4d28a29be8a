//! An estimate of the time that robots lose on each edge.

use crate::roads::{Leg, Roads};

/// What the time that robots lose says about the time that another one will lose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CongestionSettings {
    /// Seconds in which the memory of a delay falls to a third.
    pub memory_secs: f64,
    /// Expected seconds for each second that was lost on an edge, and is remembered.
    pub per_lost_second: f32,
    /// Expected seconds for each robot whose route leads along an edge.
    pub per_robot: f32,
}

impl Default for CongestionSettings {
    fn default() -> Self {
        Self { memory_secs: 60.0, per_lost_second: 0.3, per_robot: 0.3 }
    }
}

/// Delays of edges that decay, and how many robots are on their way to each edge.
#[derive(Clone, Debug)]
pub struct Congestion {
    /// By edge: robot seconds lost, as of `updated`.
    delay: Vec<f32>,
    /// By edge: robots whose route leads along it.
    load: Vec<u32>,
    settings: CongestionSettings,
}

impl Congestion {
    /// Makes the estimate of empty roads.
    pub fn new(roads: &Roads, settings: CongestionSettings) -> Self {
        let edges = roads.edges().len();
        Self { delay: vec![0.0; edges], load: vec![0; edges], settings }
    }

    /// Lets a time pass, in seconds.
    pub fn pass(&mut self, seconds: f64) {
        let decay = (-seconds / self.settings.memory_secs).exp() as f32;
        self.delay.iter_mut().for_each(|delay| *delay *= decay);
    }

    /// Records that a robot lost a time on its way to an edge, in seconds.
    pub fn lose(&mut self, edge: u32, seconds: f32) {
        self.delay[edge as usize] += seconds;
    }

    /// Counts the robots whose routes lead along each edge anew.
    pub fn count<'a>(&mut self, legs: impl Iterator<Item = &'a Leg>) {
        self.load.fill(0);
        legs.for_each(|leg| self.load[leg.edge() as usize] += 1);
    }

    /// Records that a robot gets another route.
    pub fn replace<'a>(&mut self, before: impl Iterator<Item = &'a Leg>, after: &[Leg]) {
        let load = &mut self.load;
        before.for_each(|leg| load[leg.edge() as usize] = load[leg.edge() as usize].saturating_sub(1));
        after.iter().for_each(|leg| load[leg.edge() as usize] += 1);
    }

    /// The expected delay of a robot that takes an edge, in seconds.
    pub fn delay(&self, edge: u32) -> f32 {
        let CongestionSettings { per_lost_second, per_robot, .. } = self.settings;
        per_lost_second * self.delay[edge as usize] + per_robot * self.load[edge as usize] as f32
    }
}
