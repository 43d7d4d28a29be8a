//! The reader's view of a frame.

use core::time::Duration;

use super::{Columns, FrameHeader, Line, RobotState, stride_lines};

/// A reader's view of a frame, borrowed from shared memory: it can be read but not kept.
#[derive(Clone, Copy, Debug)]
pub struct Frame<'sample> {
    header: &'sample FrameHeader,
    columns: Columns<'sample>,
    missed: u64,
}

impl<'sample> Frame<'sample> {
    /// Creates a frame from a header and its lines, wherever they come from (a recording, for
    /// example). Returns `None` if the lines don't match the header.
    pub fn new(header: &'sample FrameHeader, lines: &'sample [Line]) -> Option<Self> {
        let robots = header.robots as usize;
        if header.stride_lines as usize != stride_lines(robots) {
            return None;
        }
        Some(Self { header, columns: Columns::split(lines, robots)?, missed: 0 })
    }

    /// The same frame, received after `missed` others that the reader didn't get.
    #[must_use]
    pub fn after_missing(self, missed: u64) -> Self {
        Self { missed, ..self }
    }

    /// The header.
    pub fn header(&self) -> &'sample FrameHeader {
        self.header
    }

    /// All columns.
    pub fn columns(&self) -> Columns<'sample> {
        self.columns
    }

    /// The id of the run: it differs between any two starts of a producer.
    pub fn run_id(&self) -> u64 {
        self.header.run_id
    }

    /// Ticks since the start of the run.
    pub fn tick(&self) -> u64 {
        self.header.tick
    }

    /// The number of frames that were published between the one that this reader got before and
    /// this one: exact, by [`FrameHeader::sequence`]. A plugin that runs at a rate of its own skips
    /// frames on purpose; those count too.
    pub fn missed(&self) -> u64 {
        self.missed
    }

    /// Simulated time since the start of the run.
    pub fn sim_time(&self) -> Duration {
        Duration::from_nanos(self.header.sim_time_nanos)
    }

    /// The number of jumps of the producer's clock so far: see [`FrameHeader::jumps`].
    pub fn jumps(&self) -> u64 {
        self.header.jumps
    }

    /// The number of rows: robot ids are `0..len()`. Some may be [`RobotState::Absent`].
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

    /// Index into the world's edges, or [`NO_EDGE`](super::NO_EDGE).
    pub fn edge(&self) -> &'sample [u32] {
        self.columns.edge
    }

    /// A [`RobotState`] each, as its number.
    pub fn state(&self) -> &'sample [u8] {
        self.columns.state
    }

    /// The state of a robot; [`RobotState::Absent`] for an id that no robot has.
    pub fn state_of(&self, robot: usize) -> RobotState {
        self.columns
            .state
            .get(robot)
            .map_or(RobotState::Absent, |&state| RobotState::from_number(state))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::records::frame::frame_lines;

    #[test]
    fn a_frame_that_contradicts_its_header_is_none() {
        let lines = vec![Line::default(); frame_lines(20)];
        let header = FrameHeader { robots: 20, stride_lines: 2, ..FrameHeader::default() };
        let frame = Frame::new(&header, &lines).expect("it fits");
        assert_eq!(
            (frame.len(), frame.state_of(19), frame.state_of(20)),
            (20, RobotState::Idle, RobotState::Absent)
        );
        assert!(Frame::new(&FrameHeader { robots: 40, ..header }, &lines).is_none());
        assert!(
            Frame::new(&FrameHeader { robots: u32::MAX, stride_lines: 1 << 28, ..header }, &lines)
                .is_none()
        );
        assert!(Frame::new(&FrameHeader { stride_lines: 1, ..header }, &lines).is_none());
    }
}
