//! Landmarks that follow the delays.
//!
//! Landmarks of empty roads are weak bounds where robots lose most of their time to each other. So
//! they are recomputed all the time, a few trees of fastest ways in each cycle, for the delays at
//! the start of the computation. Until it is complete, no smaller delays are expected: so landmarks
//! stay lower bounds, and searches find the fastest ways.

use super::congestion::Congestion;
use crate::planner::Landmarks;
use crate::planner::landmarks::Survey;
use crate::roads::Roads;

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

    /// Computes so many more trees of the next landmarks, on some threads. When they are complete,
    /// they are used, and delays don't fall below those that they count on.
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
