//! Traffic: the figures of each edge, published by a plugin on `regatta/F/traffic`.

use bytemuck::{Pod, Zeroable};
#[cfg(feature = "shared-memory")]
use iceoryx2::prelude::ZeroCopySend;

use super::sequence::Sequenced;

/// The number of periods of [`TrafficHeader`]: the last minute, the last ten minutes, and the run.
pub const TRAFFIC_PERIODS: usize = 3;

/// The iceoryx2 user header of `regatta/F/traffic`. Its payload is an [`EdgeTraffic`] for each edge
/// of the world and each period: first all edges for the first period, then all for the next.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[cfg_attr(feature = "shared-memory", derive(ZeroCopySend))]
#[repr(C)]
#[cfg_attr(feature = "shared-memory", type_name("regatta_TrafficHeader"))]
pub struct TrafficHeader {
    /// The run of the frames that the figures were computed from.
    pub run_id: u64,
    /// The tick of the newest of these frames.
    pub tick: u64,
    /// Its simulated time, in nanoseconds.
    pub sim_time_nanos: u64,
    /// The revision of the world whose edges these are.
    pub world_revision: u64,
    /// Counts the samples of the run, from 1. The publisher fills it in.
    pub sequence: u64,
    /// The length of each period so far, in simulated seconds: the last minute and the last ten
    /// minutes grow to their lengths first, and end up to a sixth and up to a tenth longer.
    pub period_secs: [f32; TRAFFIC_PERIODS],
    /// The number of edges.
    pub edges: u32,
    /// 1 if a collision checker publishes contacts; if not, contact times are 0.
    pub has_contacts: u32,
    /// 1 if routes are known; if not, `released` and `planned` are 0. Readers don't ask for routes
    /// in lockstep, and replays know none.
    pub has_routes: u32,
}

/// The figures of an edge in a period. Times are simulated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[cfg_attr(feature = "shared-memory", derive(ZeroCopySend))]
#[repr(C)]
#[cfg_attr(feature = "shared-memory", type_name("regatta_EdgeTraffic"))]
pub struct EdgeTraffic {
    /// The mean number of robots on the edge.
    pub occupancy: f32,
    /// The number of robots that entered the edge, per hour.
    pub entered_per_hour: f32,
    /// The mean speed of the robots on the edge over the edge's speed limit, standing ones
    /// included; 0 if there were none.
    pub relative_speed: f32,
    /// The time that robots have stood there and waited to drive on, added up over robots, in
    /// seconds.
    pub waiting_secs: f32,
    /// The time that robots there have touched others, added up over robots, in seconds.
    pub contact_secs: f32,
    /// The mean number of robots whose released route leads over the edge, the ones that are on it
    /// included.
    pub released: f32,
    /// The mean number of other robots whose planned route (horizon) leads over it.
    pub planned: f32,
}

super::sequence::sequenced!(TrafficHeader: sequence);

/// The traffic on all edges, borrowed from shared memory.
#[derive(Clone, Copy, Debug)]
pub struct Traffic<'sample> {
    /// The frame that the figures belong to, and the periods.
    pub header: &'sample TrafficHeader,
    /// For each period: a figure for each edge of the world.
    pub periods: [&'sample [EdgeTraffic]; TRAFFIC_PERIODS],
    /// The number of samples that were published between the one that this reader returned before
    /// and this one.
    pub missed: u64,
}
