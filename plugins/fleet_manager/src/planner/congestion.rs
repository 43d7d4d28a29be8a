//! An estimate of the time that robots lose on each edge.

use crate::roads::Roads;

/// Seconds in which the memory of a delay falls to a third.
const MEMORY_SECS: f64 = 60.0;

/// Delays of edges that decay, and how many robots are on their way to each edge.
#[derive(Clone, Debug, Default)]
pub struct Congestion {
    /// By edge: robot seconds lost, as of `updated`.
    delay: Vec<f32>,
    /// By edge: robots whose route leads along it.
    load: Vec<u32>,
    decay: f32,
}

impl Congestion {
    /// Makes the estimate of empty roads.
    pub fn new(roads: &Roads) -> Self {
        let edges = roads.edges().len();
        Self { delay: vec![0.0; edges], load: vec![0; edges], decay: 1.0 }
    }

    /// Lets a time pass, in seconds.
    pub fn pass(&mut self, seconds: f64) {
        self.decay = (-seconds / MEMORY_SECS).exp() as f32;
        let decay = self.decay;
        self.delay.iter_mut().for_each(|delay| *delay *= decay);
    }

    /// Records that a robot lost a time on its way to an edge, in seconds.
    pub fn lose(&mut self, edge: u32, seconds: f32) {
        self.delay[edge as usize] += seconds;
    }

    /// Records that a robot's route leads along an edge.
    pub fn enter(&mut self, edge: u32) {
        self.load[edge as usize] += 1;
    }

    /// Records that a robot's route doesn't lead along an edge any more.
    pub fn leave(&mut self, edge: u32) {
        self.load[edge as usize] = self.load[edge as usize].saturating_sub(1);
    }

    /// The expected delay of a robot that takes an edge, in seconds.
    pub fn delay(&self, edge: u32) -> f32 {
        const PER_LOST_SECOND: f32 = 0.3;
        const PER_ROBOT: f32 = 0.3;
        PER_LOST_SECOND * self.delay[edge as usize] + PER_ROBOT * self.load[edge as usize] as f32
    }
}
