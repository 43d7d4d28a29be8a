//! A frame as a reader sees it.

use core::time::Duration;

use crate::frame::{Columns, FrameHeader, Line, RobotState, stride_lines};

/// A frame as a reader sees it: borrowed from shared memory, so it can be looked at but not kept.
#[derive(Clone, Copy, Debug)]
pub struct Frame<'sample> {
    header: &'sample FrameHeader,
    columns: Columns<'sample>,
}

impl<'sample> Frame<'sample> {
    /// A frame of a header and its lines, wherever they come from (a recording, say).
    /// `None` if the lines don't fit what the header says.
    pub fn new(header: &'sample FrameHeader, lines: &'sample [Line]) -> Option<Self> {
        let robots = header.robots as usize;
        if header.stride_lines as usize != stride_lines(robots) {
            return None;
        }
        Some(Self { header, columns: Columns::split(lines, robots)? })
    }

    /// All that the frame says about itself.
    pub fn header(&self) -> &'sample FrameHeader {
        self.header
    }

    /// All columns.
    pub fn columns(&self) -> Columns<'sample> {
        self.columns
    }

    /// The run: differs between any two starts of a producer.
    pub fn run_id(&self) -> u64 {
        self.header.run_id
    }

    /// Ticks since the start of the run.
    pub fn tick(&self) -> u64 {
        self.header.tick
    }

    /// Simulated time since the start of the run.
    pub fn sim_time(&self) -> Duration {
        Duration::from_nanos(self.header.sim_time_nanos)
    }

    /// Rows: robot ids are `0..len()`. Some may be [`RobotState::Absent`].
    pub fn len(&self) -> usize {
        self.header.robots as usize
    }

    /// Whether there are no rows.
    pub fn is_empty(&self) -> bool {
        self.header.robots == 0
    }

    /// Metres east.
    pub fn x(&self) -> &'sample [f32] {
        self.columns.x
    }

    /// Metres north.
    pub fn y(&self) -> &'sample [f32] {
        self.columns.y
    }

    /// Heading in radians, in (-π, π], counter-clockwise from east.
    pub fn theta(&self) -> &'sample [f32] {
        self.columns.theta
    }

    /// Metres per second along the edge; negative in reverse gear.
    pub fn speed(&self) -> &'sample [f32] {
        self.columns.speed
    }

    /// Metres along the edge from its origin node.
    pub fn s(&self) -> &'sample [f32] {
        self.columns.s
    }

    /// Index into the world's edges, or [`NO_EDGE`](crate::frame::NO_EDGE).
    pub fn edge(&self) -> &'sample [u32] {
        self.columns.edge
    }

    /// A [`RobotState`] each, as its number.
    pub fn state(&self) -> &'sample [u8] {
        self.columns.state
    }

    /// What a robot is doing; [`RobotState::Absent`] for an id that no robot has.
    pub fn state_of(&self, robot: usize) -> RobotState {
        self.columns.state.get(robot).map_or(RobotState::Absent, |&state| RobotState::from_number(state))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::frame_lines;

    #[test]
    fn a_frame_that_contradicts_its_header_is_none() {
        let lines = vec![Line::default(); frame_lines(20)];
        let header = FrameHeader { robots: 20, stride_lines: 2, ..FrameHeader::default() };
        let frame = Frame::new(&header, &lines).expect("it fits");
        assert_eq!((frame.len(), frame.state_of(19), frame.state_of(20)), (20, RobotState::Idle, RobotState::Absent));
        assert!(Frame::new(&FrameHeader { robots: 40, ..header }, &lines).is_none());
        assert!(Frame::new(&FrameHeader { robots: u32::MAX, stride_lines: 1 << 28, ..header }, &lines).is_none());
        assert!(Frame::new(&FrameHeader { stride_lines: 1, ..header }, &lines).is_none());
    }
}
