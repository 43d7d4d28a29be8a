//! The length of a tick.

use crate::graph::arc_length::Distance;

/// The length of a tick, in the forms that the stages use.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TimeStep {
    /// Seconds per tick.
    pub(super) seconds: f32,
    /// Units of [`Distance`] that a robot drives in a tick at 1 m/s.
    pub(super) units: f32,
}

impl TimeStep {
    pub(crate) fn new(seconds: f64) -> Self {
        Self { seconds: seconds as f32, units: (seconds * Distance::PER_METRE) as f32 }
    }
}
