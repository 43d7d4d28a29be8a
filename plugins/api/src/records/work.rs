//! The work of a fleet so far: figures of its transport orders and robots, on `regatta/F/work`. The
//! fleet manager publishes them about once in a simulated second, so that all readers, late ones
//! too, show the figures that the manager reports at the end of the run, and its current rate.

use bytemuck::{Pod, Zeroable};
#[cfg(feature = "shared-memory")]
use iceoryx2::prelude::ZeroCopySend;

use super::sequence::Sequenced;

/// The iceoryx2 user header of `regatta/F/work`. The payload is one [`WorkFigures`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[cfg_attr(feature = "shared-memory", derive(ZeroCopySend))]
#[repr(C)]
#[cfg_attr(feature = "shared-memory", type_name("regatta_WorkHeader"))]
pub struct WorkHeader {
    /// The run that the figures belong to.
    pub run_id: u64,
    /// The tick of the last frame that they include.
    pub tick: u64,
    /// Counts the samples of the run, from 1. The publisher fills it in.
    pub sequence: u64,
}

/// The figures of a run so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[cfg_attr(feature = "shared-memory", derive(ZeroCopySend))]
#[repr(C)]
#[cfg_attr(feature = "shared-memory", type_name("regatta_WorkFigures"))]
pub struct WorkFigures {
    /// Simulated seconds that the figures cover: since the manager began to take orders.
    pub secs: f64,
    /// Finished orders.
    pub finished: u64,
    /// Orders that aren't over.
    pub open: u64,
    /// Orders that the manager has given up.
    pub failed: u64,
    /// Finished orders an hour of the last ten minutes, or of the time since the manager began or
    /// the warm-up of the run ended if that is shorter; NaN in its first minute.
    pub orders_per_hour: f32,
    /// The shortest time from when robots could have an order to its end that half of the orders
    /// don't exceed, in seconds; NaN if no order is finished.
    pub service_p50_secs: f32,
    /// The 99th percentile of these times, in seconds; NaN if no order is finished.
    pub service_p99_secs: f32,
    /// The part of the robots' time that they waited for room to drive on, from 0 to 1.
    pub waiting: f32,
    /// Robots with an order now.
    pub busy: u32,
    /// Robots now.
    pub robots: u32,
}

super::sequence::sequenced!(WorkHeader: sequence);

impl WorkFigures {
    /// Finished orders an hour, as [`orders_per_hour`](Self::orders_per_hour); `None` in the first
    /// minute.
    pub fn rate(&self) -> Option<f32> {
        Some(self.orders_per_hour).filter(|rate| rate.is_finite())
    }

    /// The 50th and the 99th percentile of service times, in seconds; `None` if no order is
    /// finished.
    pub fn service_secs(&self) -> Option<[f32; 2]> {
        let secs = [self.service_p50_secs, self.service_p99_secs];
        secs.iter().all(|secs| secs.is_finite()).then_some(secs)
    }
}
