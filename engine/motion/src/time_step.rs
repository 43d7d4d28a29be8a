//! The length of a tick.

use crate::piece::Distance;

/// The length of a tick, in the forms that the stages use.
#[derive(Clone, Copy, Debug)]
pub struct TimeStep {
    /// Seconds per tick.
    pub(super) seconds: f32,
    /// Units of [`Distance`] that a robot drives in a tick at 1 m/s.
    pub(super) units: f32,
}

impl TimeStep {
    /// Makes the time step of that many seconds.
    pub fn new(seconds: f64) -> Self {
        Self { seconds: seconds as f32, units: (seconds * Distance::PER_METRE) as f32 }
    }
}
