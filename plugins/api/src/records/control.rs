//! Control: pause, resume, step, speed, number of robots, status. Request-response on
//! `regatta/F/control`.

use bytemuck::{Pod, Zeroable};
#[cfg(feature = "shared-memory")]
use iceoryx2::prelude::ZeroCopySend;

use super::frame::RobotState;
use super::{padded, text};

/// A request. `kind` decides which of `count` and `speed` has a meaning.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[cfg_attr(feature = "shared-memory", derive(ZeroCopySend))]
#[repr(C)]
#[cfg_attr(feature = "shared-memory", type_name("regatta_ControlRequest"))]
pub struct ControlRequest {
    /// `Step`: ticks. `Robots`: the requested number. `Seek`: simulated time in nanoseconds.
    pub count: u64,
    /// A [`ControlKind`].
    pub kind: u32,
    /// `Speed`: simulated seconds per wall second; `f32::INFINITY` for as fast as possible.
    pub speed: f32,
}

numbered! {
    /// Kinds of [`ControlRequest`].
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum ControlKind: u32 {
        /// Answer, and do nothing else.
        Status = 0,
        /// Stop ticking.
        Pause = 1,
        /// Tick again.
        Resume = 2,
        /// Pause and advance by `count` ticks; the answer comes when they are done. A pause, a
        /// resume or a seek in between ends the steps, and their request is then refused.
        Step = 3,
        /// Change the requested speed.
        Speed = 4,
        /// Change the number of robots: new ones are spawned as the scenario defines, surplus ones
        /// removed (highest ids first).
        Robots = 5,
        /// Go to a simulated time. Replays can.
        Seek = 6,
    }
}

/// The answer: whether the request was carried out, and the status after it.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[cfg_attr(feature = "shared-memory", derive(ZeroCopySend))]
#[repr(C)]
#[cfg_attr(feature = "shared-memory", type_name("regatta_ControlResponse"))]
pub struct ControlResponse {
    /// The run.
    pub run_id: u64,
    /// Ticks since its start.
    pub tick: u64,
    /// Simulated time, in nanoseconds.
    pub sim_time_nanos: u64,
    /// Ticks that ended after their deadline, since the start.
    pub late_ticks: u64,
    /// Median cost of a tick over the last second or so, in nanoseconds.
    pub tick_cost_p50_nanos: u64,
    /// 99th percentile of the cost of a tick, in nanoseconds.
    pub tick_cost_p99_nanos: u64,
    /// Resident memory of the producer, in bytes; 0 where unknown.
    pub resident_bytes: u64,
    /// Wall time since the start of the run, in nanoseconds.
    pub wall_time_nanos: u64,
    /// Robots by [`RobotState`]: idle, driving, waiting, held, faulted, turning, stalled, broken.
    pub robots_by_state: [u32; RobotState::COUNT],
    /// Robots in the fleet.
    pub robots: u32,
    /// Operating-system id of the producer's process.
    pub pid: u32,
    /// A [`ClockState`](crate::frame::ClockState).
    pub clock: u32,
    /// Requested simulated seconds per wall second; `f32::INFINITY` for as fast as possible.
    pub speed: f32,
    /// Simulated seconds per wall second over the last second or so.
    pub real_time_factor: f32,
    /// 1 if the request was carried out, 0 if it was refused.
    pub accepted: u32,
    /// The reason of a refusal, in UTF-8 padded with zeros.
    pub reason: [u8; 128],
    /// The process that owns the movement of the robots, in UTF-8 padded with zeros: its name and
    /// its number, such as `fleet-manager (process 4711)`. Empty if nobody does.
    pub owner: [u8; 96],
}

impl ControlRequest {
    /// Creates a request without arguments.
    pub fn new(kind: ControlKind) -> Self {
        Self { kind: kind as u32, ..Self::default() }
    }

    /// The kind of the request; `None` if this contract doesn't know it.
    pub fn kind(&self) -> Option<ControlKind> {
        ControlKind::from_number(self.kind)
    }
}

impl Default for ControlResponse {
    /// Returns a response of zeros: refused, without a reason.
    fn default() -> Self {
        Self::zeroed()
    }
}

impl ControlResponse {
    /// Turns this into the answer to a request that was carried out.
    #[must_use]
    pub fn accept(self) -> Self {
        Self { accepted: 1, reason: [0; 128], ..self }
    }

    /// Turns this into the answer to a request that was refused. `reason` is cut to 128 bytes.
    #[must_use]
    pub fn refuse(self, reason: &str) -> Self {
        Self { accepted: 0, reason: padded(reason), ..self }
    }

    /// The reason of a refusal.
    pub fn reason(&self) -> &str {
        text(&self.reason)
    }

    /// The process that owns the movement of the robots: its name and its number.
    pub fn owner(&self) -> Option<&str> {
        Some(text(&self.owner)).filter(|owner| !owner.is_empty())
    }
}
