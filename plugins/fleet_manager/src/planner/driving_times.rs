//! The driving times on empty roads that a planner knows.

use crate::roads::Roads;

/// The largest number of times that are known: 64 MB. Times to further goals are estimated.
const MOST_NUMBERS: usize = 16_000_000;
/// The number of times after which no further goal is prepared until the next call of
/// [`DrivingTimes::begin`].
const NUMBERS_AT_ONCE: usize = 60_000;

/// Driving times to some goals, which are prepared on demand. They depend on the calls alone, and
/// not on what others prepared of the same roads.
#[derive(Debug, Default)]
pub struct DrivingTimes {
    /// By node: whether the times to it are known; empty if none are.
    is_known: Vec<bool>,
    /// The number of nodes to which they are known.
    known: usize,
    /// The number of times prepared since the last [`begin`](Self::begin).
    spent: usize,
    /// Whether robots drive in reverse gear only where no other way leads to their goal.
    prefers_forward: bool,
}

impl DrivingTimes {
    /// Makes the times of robots that drive in reverse gear only where no other way leads to their
    /// goal.
    pub fn of_forward_gear() -> Self {
        Self { prefers_forward: true, ..Self::default() }
    }

    /// Begins another cycle, in which some more driving times may be computed.
    pub fn begin(&mut self) {
        self.spent = 0;
    }

    /// Computes the driving times to a goal, unless they are known, or it would take too much time
    /// or memory now.
    pub fn prepare(&mut self, roads: &Roads, goal: u32) {
        let nodes = roads.nodes() as usize;
        if self.knows(goal) || self.spent > NUMBERS_AT_ONCE {
            return;
        }
        if (self.known + 1) * nodes <= MOST_NUMBERS {
            self.is_known.resize(nodes, false);
            self.is_known[goal as usize] = true;
            self.known += 1;
            self.spent += nodes;
        }
    }

    /// Returns the driving time between two nodes, in seconds; `None` if the goal can't be reached.
    /// Unless it was [prepared](Self::prepare), it is an estimate from the distance.
    pub fn between(&self, roads: &Roads, node: u32, goal: u32) -> Option<f64> {
        if !self.knows(goal) {
            let offset = roads.position(node) - roads.position(goal);
            // Streets are longer than the distance, and robots slower than 1 m/s on part of them.
            return Some(1.5 * f64::from(offset.x.hypot(offset.y)));
        }
        let forward = match self.prefers_forward {
            true => roads.forward_millis_to(goal)[node as usize],
            false => u32::MAX,
        };
        let millis = match forward {
            u32::MAX => roads.millis_to(goal)[node as usize],
            millis => millis,
        };
        (millis != u32::MAX).then(|| f64::from(millis) / 1000.0)
    }

    /// The driving times from all nodes to a goal, as [`Roads::millis_to`] returns them; `None`
    /// unless it was [prepared](Self::prepare).
    pub fn millis_to<'a>(&self, roads: &'a Roads, goal: u32) -> Option<&'a [u32]> {
        self.knows(goal).then(|| roads.millis_to(goal))
    }

    /// Whether the driving times to a goal were [prepared](Self::prepare).
    pub fn knows(&self, goal: u32) -> bool {
        self.is_known.get(goal as usize).is_some_and(|is_known| *is_known)
    }
}
