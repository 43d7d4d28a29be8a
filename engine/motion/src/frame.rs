//! The columns of a frame that poses are written to, and the events of a tick.

use bytemuck::{Pod, Zeroable};

use super::rows::split_fields;

/// The value of the `edge` column for a robot that is on no edge.
pub const NO_EDGE: u32 = u32::MAX;

/// Values of four bytes in one cache line.
pub(crate) const WORDS_PER_LINE: usize = 16;

/// A cache line, of which columns are made.
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[repr(C, align(64))]
pub(crate) struct Line([f32; WORDS_PER_LINE]);

/// The columns of a frame under construction. Each 4-byte column is a whole number of cache lines
/// long and starts on one, and so does `state`; rows that hold no robot are padding.
#[derive(Debug)]
pub struct PoseColumns<'frame> {
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
    /// Index of the edge, or [`NO_EDGE`].
    pub edge: &'frame mut [u32],
    /// A [`RobotState`] each.
    pub state: &'frame mut [u8],
}

impl PoseColumns<'_> {
    /// Splits the frame into its first `count` rows (all, if there are fewer) and the others.
    pub fn split_at(self, count: usize) -> (Self, Self) {
        let words = count.min(self.x.len());
        split_fields! {
            x: self.x.split_at_mut(words),
            y: self.y.split_at_mut(words),
            theta: self.theta.split_at_mut(words),
            speed: self.speed.split_at_mut(words),
            s: self.s.split_at_mut(words),
            edge: self.edge.split_at_mut(words),
            state: self.state.split_at_mut(count.min(self.state.len())),
        }
    }
}

/// The state of a robot: a value of the `state` column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum RobotState {
    /// The robot has nothing left to drive.
    Idle = 0,
    /// The robot drives its released base.
    Driving = 1,
    /// The robot stands at the end of its released base, and its route goes on.
    Waiting = 2,
    /// The robot is held: it is stopped, or brakes to a stop.
    Held = 3,
    /// The robot can't continue.
    Faulted = 4,
    /// The robot stands at a node and turns on the spot, to the heading of its next edge.
    Turning = 5,
    /// The robot has stopped for a while of its own, or brakes to a stop.
    Stalled = 6,
    /// The robot is broken: it stands, or brakes to a stop.
    Broken = 7,
    /// The row holds no robot. Its pose is meaningless.
    Absent = 255,
}

impl RobotState {
    /// Whether a robot in the state with that number may not drive, whatever its route.
    pub(crate) fn is_stopped(number: u8) -> bool {
        [Self::Held, Self::Stalled, Self::Broken].iter().any(|state| *state as u8 == number)
    }
}

/// Something that happens to a robot in a tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    /// It reached the node with this id.
    ReachedNode(u32),
    /// It reached the end of its route.
    RouteDone,
    /// It reached the end of its released base, or comes to a closed edge, and waits.
    WaitingForRelease,
    /// It was held, and has come to a stop.
    Held,
    /// It can't continue: no edge leaves its node.
    Faulted,
}

/// A receiver of events.
pub trait EventSink {
    /// Whether the events have a reader. Without one they needn't be pushed: in a large fleet they
    /// cost time.
    fn wanted(&self) -> bool;

    /// Takes an event of a robot.
    fn push(&mut self, robot: u32, event: Event);
}
