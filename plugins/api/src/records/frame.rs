//! A frame: the poses of all robots at one tick, as columns in one block of 64-byte lines.

use bytemuck::{Pod, Zeroable};
#[cfg(feature = "shared-memory")]
use iceoryx2::prelude::ZeroCopySend;

use super::sequence::Sequenced;
pub use view::Frame;

mod view;

/// The version of everything in this crate that crosses a process boundary. Two processes
/// communicate only if their versions are equal.
pub const CONTRACT_VERSION: u32 = 19;

/// The value of the `edge` column for a robot that is on no edge.
pub const NO_EDGE: u32 = u32::MAX;

/// One cache line of a frame: sixteen 4-byte values.
///
/// Frames are slices of lines, rather than of `f32` with a raised alignment, because iceoryx2 pads
/// every element of a slice to the alignment.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[cfg_attr(feature = "shared-memory", derive(ZeroCopySend))]
#[repr(C)]
#[repr(align(64))]
#[cfg_attr(feature = "shared-memory", type_name("regatta_Line"))]
pub struct Line(pub [f32; 16]);

/// Values of four bytes in one [`Line`].
pub const WORDS_PER_LINE: usize = 16;
/// Bytes in one [`Line`].
pub const BYTES_PER_LINE: usize = 64;

/// The iceoryx2 user header of `regatta/F/frames`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[cfg_attr(feature = "shared-memory", derive(ZeroCopySend))]
#[repr(C)]
#[cfg_attr(feature = "shared-memory", type_name("regatta_FrameHeader"))]
pub struct FrameHeader {
    /// Differs between any two starts of a producer.
    pub run_id: u64,
    /// Ticks since the start of the run; the first frame, before any step, is tick 0. A frame is
    /// published again, with the same tick and [`repeated`](Self::repeated), when the clock or the
    /// number of robots has changed between two ticks.
    pub tick: u64,
    /// Counts the frames of the run, from 1. The publisher fills it in. A gap between two frames
    /// that a reader got is the number of frames that it lost.
    pub sequence: u64,
    /// Simulated time since the start of the run, in nanoseconds: a function of `tick` alone.
    pub sim_time_nanos: u64,
    /// Time of the producer's clock when the frame was sent, in nanoseconds since the Unix epoch.
    pub wall_time_nanos: u64,
    /// Ticks that ended after their deadline, since the start of the run.
    pub late_ticks: u64,
    /// Changes whenever the producer publishes another world; equals
    /// [`WorldHeader::revision`](crate::world::WorldHeader::revision).
    pub world_revision: u64,
    /// Duration of the previous tick's work, in nanoseconds.
    pub tick_cost_nanos: u64,
    /// Simulated time per tick, in nanoseconds.
    pub tick_period_nanos: u64,
    /// Requested simulated seconds per wall second; `f32::INFINITY` for as fast as possible.
    pub speed: f32,
    /// Rows in use: robot ids are `0..robots`. Some may be [`RobotState::Absent`].
    pub robots: u32,
    /// Length of one 4-byte column in [`Line`]s.
    pub stride_lines: u32,
    /// A [`ClockState`].
    pub clock: u32,
    /// Nonzero if the producer waits until readers have reported that they have finished this tick.
    pub lockstep: u32,
    /// Nonzero if an earlier frame of the run has the same tick.
    pub repeated: u32,
    /// Counts the jumps of the producer's clock in its run: a replay that is sent to another time
    /// jumps. Between two frames with different counts no simulated time has passed, even if their
    /// times differ.
    pub jumps: u64,
}

/// The state of the producer's clock.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum ClockState {
    /// Ticks follow the wall clock, times the requested speed.
    Running = 0,
    /// No ticks until a resume or a step.
    Paused = 1,
    /// The last frame of the run.
    Stopped = 2,
    /// The warm-up of a run: ticks come as fast as possible, and the run begins at its end. Readers
    /// that show or record the run leave these frames out.
    WarmingUp = 3,
}

/// The state of a robot: a value of the `state` column.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(u8)]
pub enum RobotState {
    /// The robot has nothing left to drive.
    Idle = 0,
    /// The robot drives its released base.
    Driving = 1,
    /// The robot stands at the end of its released base, at a node or within an edge, and has a
    /// horizon: it waits for a release.
    Waiting = 2,
    /// The robot was commanded to hold; it is stopped, or braking to a stop.
    Held = 3,
    /// The robot can't continue; an event gave the reason.
    Faulted = 4,
    /// The robot stands at a node and turns on the spot, to the heading of its next edge.
    Turning = 5,
    /// The robot has stopped for a while of its own, or brakes to a stop; it keeps its route and
    /// goes on afterwards.
    Stalled = 6,
    /// The robot is broken: it stands, or brakes to a stop, and keeps its route until it is
    /// repaired.
    Broken = 7,
    /// The row holds no robot. Its pose is meaningless.
    Absent = 255,
}

/// The columns of a frame under construction. Each 4-byte column is `stride_lines * 16` values
/// long, `state` is padded likewise to whole lines; rows from `robots` on are padding.
#[derive(Debug)]
pub struct ColumnsMut<'frame> {
    /// Metres east.
    pub x: &'frame mut [f32],
    /// Metres north.
    pub y: &'frame mut [f32],
    /// Heading in radians, in (-π, π], counter-clockwise from east.
    pub theta: &'frame mut [f32],
    /// Metres per second along the edge; negative in reverse gear.
    pub speed: &'frame mut [f32],
    /// Metres along the edge from its origin node.
    pub s: &'frame mut [f32],
    /// Index into the world's edges, or [`NO_EDGE`].
    pub edge: &'frame mut [u32],
    /// A [`RobotState`] each.
    pub state: &'frame mut [u8],
}

/// The columns of a frame, cut to the robots in use.
#[derive(Clone, Copy, Debug)]
pub struct Columns<'frame> {
    /// Metres east.
    pub x: &'frame [f32],
    /// Metres north.
    pub y: &'frame [f32],
    /// Heading in radians, in (-π, π], counter-clockwise from east.
    pub theta: &'frame [f32],
    /// Metres per second along the edge; negative in reverse gear.
    pub speed: &'frame [f32],
    /// Metres along the edge from its origin node.
    pub s: &'frame [f32],
    /// Index into the world's edges, or [`NO_EDGE`].
    pub edge: &'frame [u32],
    /// A [`RobotState`] each.
    pub state: &'frame [u8],
}

/// Returns the length of one 4-byte column for `robots` robots, in lines.
pub const fn stride_lines(robots: usize) -> usize {
    robots.div_ceil(WORDS_PER_LINE)
}

/// Returns the length of a whole frame for `robots` robots, in lines: six 4-byte columns and one of
/// bytes.
pub const fn frame_lines(robots: usize) -> usize {
    6 * stride_lines(robots) + stride_lines(robots).div_ceil(4)
}

impl<'frame> ColumnsMut<'frame> {
    /// Splits the lines of a frame for `robots` robots into its columns.
    ///
    /// # Panics
    /// If `lines` is not [`frame_lines(robots)`](frame_lines) long.
    pub fn split(lines: &'frame mut [Line], robots: usize) -> Self {
        assert_eq!(lines.len(), frame_lines(robots), "a frame of {robots} robots");
        let stride = stride_lines(robots);
        let (x, rest) = lines.split_at_mut(stride);
        let (y, rest) = rest.split_at_mut(stride);
        let (theta, rest) = rest.split_at_mut(stride);
        let (speed, rest) = rest.split_at_mut(stride);
        let (s, rest) = rest.split_at_mut(stride);
        let (edge, state) = rest.split_at_mut(stride);
        Self {
            x: bytemuck::cast_slice_mut(x),
            y: bytemuck::cast_slice_mut(y),
            theta: bytemuck::cast_slice_mut(theta),
            speed: bytemuck::cast_slice_mut(speed),
            s: bytemuck::cast_slice_mut(s),
            edge: bytemuck::cast_slice_mut(edge),
            state: bytemuck::cast_slice_mut(state),
        }
    }
}

impl<'frame> Columns<'frame> {
    /// Splits the lines of a frame into its columns, each `robots` long.
    /// Returns `None` if there are fewer lines than that many robots need.
    pub fn split(lines: &'frame [Line], robots: usize) -> Option<Self> {
        if lines.len() < frame_lines(robots) {
            return None;
        }
        let stride = stride_lines(robots);
        Some(Self {
            x: &bytemuck::cast_slice(lines)[..robots],
            y: &bytemuck::cast_slice(&lines[stride..])[..robots],
            theta: &bytemuck::cast_slice(&lines[2 * stride..])[..robots],
            speed: &bytemuck::cast_slice(&lines[3 * stride..])[..robots],
            s: &bytemuck::cast_slice(&lines[4 * stride..])[..robots],
            edge: &bytemuck::cast_slice(&lines[5 * stride..])[..robots],
            state: &bytemuck::cast_slice(&lines[6 * stride..])[..robots],
        })
    }
}

super::sequence::sequenced!(FrameHeader: sequence);

impl FrameHeader {
    /// Whether the frame belongs to the warm-up of a run.
    pub const fn is_warm_up(&self) -> bool {
        self.clock == ClockState::WarmingUp as u32
    }
}

impl RobotState {
    /// The name, for people.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Idle => "idle",
            Self::Driving => "driving",
            Self::Waiting => "waiting",
            Self::Held => "held",
            Self::Faulted => "faulted",
            Self::Turning => "turning",
            Self::Stalled => "stalled",
            Self::Broken => "broken",
            Self::Absent => "absent",
        }
    }

    /// The number of states that a robot can be in, [`RobotState::Absent`] excluded. Their numbers
    /// are below it.
    pub const COUNT: usize = 8;

    /// Whether the robot may not drive along its route: it is held, stalled or broken, and stands
    /// or brakes to a stop.
    pub const fn is_stopped(self) -> bool {
        matches!(self, Self::Held | Self::Stalled | Self::Broken)
    }

    /// Returns the state with a number. An unknown number counts as [`RobotState::Absent`].
    pub const fn from_number(number: u8) -> Self {
        match number {
            0 => Self::Idle,
            1 => Self::Driving,
            2 => Self::Waiting,
            3 => Self::Held,
            4 => Self::Faulted,
            5 => Self::Turning,
            6 => Self::Stalled,
            7 => Self::Broken,
            _ => Self::Absent,
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(if cfg!(miri) { 2 } else { 256 }))]

        #[test]
        fn columns_are_read_where_they_were_written(robots in 0_usize..3_000) {
            let mut lines = vec![Line::default(); frame_lines(robots)];
            let written = ColumnsMut::split(&mut lines, robots);
            let padded = stride_lines(robots) * WORDS_PER_LINE;
            for (number, column) in (1..).zip([written.x, written.y, written.theta, written.speed, written.s]) {
                prop_assert_eq!(column.len(), padded);
                column.fill(number as f32);
            }
            written.edge.fill(6);
            prop_assert_eq!(written.state.len() % BYTES_PER_LINE, 0);
            written.state.fill(7);
            let read = Columns::split(&lines, robots).expect("enough lines");
            for (number, column) in (1..).zip([read.x, read.y, read.theta, read.speed, read.s]) {
                prop_assert_eq!(column, vec![number as f32; robots]);
            }
            prop_assert_eq!(read.edge, vec![6; robots]);
            prop_assert_eq!(read.state, vec![7; robots]);
            prop_assert!(robots == 0 || Columns::split(&lines[1..], robots).is_none(), "a line is missing");
        }
    }

    #[test]
    fn every_column_starts_on_a_cache_line() {
        let mut lines = vec![Line::default(); frame_lines(100)];
        let columns = ColumnsMut::split(&mut lines, 100);
        let starts = [
            columns.x.as_ptr() as usize,
            columns.edge.as_ptr() as usize,
            columns.state.as_ptr() as usize,
        ];
        assert!(starts.iter().all(|start| start.is_multiple_of(BYTES_PER_LINE)));
    }

    #[test]
    fn states_have_their_numbers() {
        use RobotState::{Absent, Broken, Driving, Faulted, Held, Idle, Stalled, Turning, Waiting};
        for state in [Idle, Driving, Waiting, Held, Faulted, Turning, Stalled, Broken, Absent] {
            assert_eq!(RobotState::from_number(state as u8), state);
        }
        assert_eq!([RobotState::COUNT as u8, 77].map(RobotState::from_number), [Absent; 2]);
    }
}
