//! Lower bounds of driving times, from the driving times to and from some landmarks.
//!
//! By the triangle inequality, the driving time from a node to a goal is at least the difference of
//! their driving times to a landmark, or from one. A. Goldberg, C. Harrelson: Computing the
//! Shortest Path: A* Search Meets Graph Theory, SODA 2005. Landmarks are chosen as they propose for
//! graphs in the plane: one near the rim in each direction.

mod survey;

pub(super) use self::survey::Survey;
use crate::roads::Roads;

/// The number of landmarks: the times of a node then fill a cache line.
const LANDMARKS: usize = 16;

/// Driving times in forward gear between all nodes and some landmarks.
#[derive(Clone, Debug, PartialEq)]
pub struct Landmarks {
    /// By node: the times to each landmark, and from each, in units; the largest number is also that
    /// of longer ways, and of ways that don't exist.
    times: Vec<[[u16; LANDMARKS]; 2]>,
    /// Seconds; a power of two.
    unit: f32,
}

impl Landmarks {
    /// Computes all driving times at once, on all cores. `delay` is, by edge, the least time that it
    /// takes beyond that on empty roads, in seconds.
    pub fn new(roads: &Roads, delay: &[f32]) -> Self {
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let mut survey = Survey::new(roads, delay);
        survey.go_on(usize::MAX, cores);
        survey.landmarks()
    }

    /// Returns a lower bound of the time between two nodes in forward gear, in seconds, for robots
    /// of any class. Along a leg it falls by no more than the leg's time.
    pub fn least_secs(&self, node: u32, goal: u32) -> f32 {
        let ([to, from], [goal_to, goal_from]) =
            (&self.times[node as usize], &self.times[goal as usize]);
        let mut least = 0;
        for landmark in 0..LANDMARKS {
            let towards = to[landmark].saturating_sub(goal_to[landmark]);
            let away = goal_from[landmark].saturating_sub(from[landmark]);
            least = least.max(towards).max(away);
        }
        f32::from(least) * self.unit
    }
}
