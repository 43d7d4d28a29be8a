//! An estimate of the time that robots lose on each edge, and landmarks that follow it.
//!
//! Landmarks of empty roads are weak bounds where robots lose most of their time to each other. So
//! they are recomputed all the time, a few trees of fastest ways in each cycle, for the delays at
//! the start of the computation. Until it is complete, no smaller delays are expected: so landmarks
//! stay lower bounds, and searches find the fastest ways.

use crate::planner::Landmarks;
use crate::planner::landmarks::Survey;
use crate::roads::{Leg, Roads};

/// The settings that derive the expected delay of a robot from the time that others have lost.
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
    /// By edge: robot seconds lost, as of now.
    lost: Vec<f32>,
    /// By edge: robots whose route leads along it.
    load: Vec<u32>,
    /// By edge: the least delay that is expected, in seconds.
    floor: Vec<f32>,
    /// By edge: the expected delay, in seconds.
    expected: Vec<f32>,
    /// The edges on which time was lost, each once: on many roads they are few.
    with_losses: Vec<u32>,
    /// By edge: whether it is one of them.
    has_losses: Vec<bool>,
    /// Whether the expected delays of all edges are to be computed.
    is_stale: bool,
    settings: CongestionSettings,
}

impl Congestion {
    /// Makes the estimate of empty roads.
    pub fn new(roads: &Roads, settings: CongestionSettings) -> Self {
        let edges = roads.edges().len();
        let zeros = vec![0.0; edges];
        let (lost, floor) = (zeros.clone(), zeros.clone());
        Self {
            lost,
            load: vec![0; edges],
            floor,
            expected: zeros,
            with_losses: Vec::new(),
            has_losses: vec![false; edges],
            is_stale: false,
            settings,
        }
    }

    /// Lets a time pass, in seconds.
    pub fn pass(&mut self, seconds: f64) {
        let decay = (-seconds / self.settings.memory_secs).exp() as f32;
        for edge in &self.with_losses {
            self.lost[*edge as usize] *= decay;
        }
    }

    /// Records that a robot lost a time on its way to an edge, in seconds. It counts from
    /// [`settle`](Self::settle) on.
    pub fn lose(&mut self, edge: u32, seconds: f32) {
        self.lost[edge as usize] += seconds;
        if !std::mem::replace(&mut self.has_losses[edge as usize], true) {
            self.with_losses.push(edge);
        }
    }

    /// Recounts the robots whose routes lead along each edge, from [`settle`](Self::settle) on.
    pub fn count<'a>(&mut self, legs: impl Iterator<Item = &'a Leg>) {
        self.is_stale = true;
        self.load.fill(0);
        for leg in legs {
            self.load[leg.edge() as usize] += 1;
        }
    }

    /// Computes the expected delays.
    pub fn settle(&mut self) {
        if !std::mem::take(&mut self.is_stale) {
            for number in 0..self.with_losses.len() {
                self.expect(self.with_losses[number] as usize);
            }
            return;
        }
        let CongestionSettings { per_lost_second, per_robot, .. } = self.settings;
        let observed = self.lost.iter().zip(&self.load).zip(&self.floor);
        for (expected, ((lost, load), floor)) in self.expected.iter_mut().zip(observed) {
            *expected = (per_lost_second * lost + per_robot * *load as f32).max(*floor);
        }
    }

    /// Records that a robot gets another route.
    pub fn replace<'a>(&mut self, before: impl Iterator<Item = &'a Leg>, after: &[Leg]) {
        for leg in before {
            let edge = leg.edge() as usize;
            self.load[edge] = self.load[edge].saturating_sub(1);
            self.expect(edge);
        }
        for leg in after {
            let edge = leg.edge() as usize;
            self.load[edge] += 1;
            self.expect(edge);
        }
    }

    fn expect(&mut self, edge: usize) {
        self.expected[edge] = self.observed(edge).max(self.floor[edge]);
    }

    /// The expected delay of a robot that takes an edge, in seconds.
    pub fn delay(&self, edge: u32) -> f32 {
        self.expected[edge as usize]
    }

    /// The delays by edge as they are now, whatever the least ones are, in seconds.
    pub fn delays(&self) -> Vec<f32> {
        (0..self.lost.len()).map(|edge| self.observed(edge)).collect()
    }

    /// Sets the least delays by edge, in seconds: from [`settle`](Self::settle) on, no less is
    /// expected.
    pub fn set_floor(&mut self, floor: Vec<f32>) {
        self.floor = floor;
        self.is_stale = true;
    }

    fn observed(&self, edge: usize) -> f32 {
        let CongestionSettings { per_lost_second, per_robot, .. } = self.settings;
        per_lost_second * self.lost[edge] + per_robot * self.load[edge] as f32
    }
}

/// Landmarks in use, and the next ones.
#[derive(Debug)]
pub struct Guide {
    landmarks: Landmarks,
    next: Survey,
    /// By edge: the delays that the next ones count on, in seconds.
    delays: Vec<f32>,
}

impl Guide {
    /// Makes the landmarks of empty roads.
    pub fn new(roads: &Roads) -> Self {
        let delays = vec![0.0; roads.edges().len()];
        let landmarks = Landmarks::new(roads, &delays);
        Self { landmarks, next: Survey::new(roads, &delays), delays }
    }

    /// The landmarks in use.
    pub fn landmarks(&self) -> &Landmarks {
        &self.landmarks
    }

    /// Computes this number of further trees of the next landmarks, on some threads. Complete
    /// landmarks are used, and delays don't fall below the assumed ones.
    pub fn go_on(
        &mut self,
        roads: &Roads,
        congestion: &mut Congestion,
        trees: usize,
        threads: usize,
    ) {
        if self.next.go_on(trees, threads) {
            self.landmarks = self.next.landmarks();
            congestion.set_floor(std::mem::replace(&mut self.delays, congestion.delays()));
            self.next.begin(roads, &self.delays);
        }
    }
}
