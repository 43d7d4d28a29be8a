//! Speeds that vary: each robot drives each leg a little more slowly than it might.

use regatta_base::graph::EdgeIndex;
use regatta_base::random::mix;

/// By how much speeds vary.
#[derive(Clone, Copy, Debug, Default)]
pub struct SpeedVariation {
    /// The largest part of its speed by which a robot is slower; 0 for no variation.
    pub most: f32,
    /// The seed of who is slow where.
    pub seed: u64,
}

impl SpeedVariation {
    /// Returns the speed of a robot on an edge that it could drive at `speed`.
    pub fn apply(self, speed: f32, robot: u32, edge: EdgeIndex) -> f32 {
        if self.most == 0.0 {
            return speed;
        }
        let random = mix(self.seed ^ mix(u64::from(robot) << 32 | u64::from(edge.0)));
        speed * (1.0 - self.most * ((random >> 40) as f32 / (1u32 << 24) as f32))
    }
}
