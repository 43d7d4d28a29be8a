//! The stored lines of a frame.

use std::time::Instant;

use crate::line::PoseLine;

/// The status of a stored line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Status {
    /// The frame has no line of this robot.
    NotSent,
    /// The line is not answered yet.
    Open,
    /// The line was answered: in time, late, or with another pose.
    Answered,
    /// The line was not answered before the deadline.
    Missing,
}

/// A sent line of one robot.
#[derive(Clone, Copy, Debug)]
pub(super) struct SentLine {
    pub x: f32,
    pub y: f32,
    pub theta: f32,
    pub status: Status,
}

/// The sent lines of one frame.
#[derive(Debug)]
pub struct SentFrame {
    pub(super) at: Instant,
    pub(super) overdue: bool,
    /// The id of the robot of the first line.
    pub(super) first: u32,
    /// The lines, indexed by the robot's id minus `first`.
    pub(super) lines: Vec<SentLine>,
}

impl SentFrame {
    /// Adds a line. Lines have to be added in ascending order of their ids.
    pub fn push(&mut self, line: &PoseLine) {
        let Some(index) = line.id.checked_sub(self.first).map(|index| index as usize) else {
            return;
        };
        let not_sent = SentLine { x: 0.0, y: 0.0, theta: 0.0, status: Status::NotSent };
        self.lines.resize(index.max(self.lines.len()), not_sent);
        self.lines.push(SentLine { x: line.x, y: line.y, theta: line.theta, status: Status::Open });
    }

    /// Returns the line of a robot, if one was sent.
    pub(super) fn line_mut(&mut self, id: u32) -> Option<&mut SentLine> {
        let line = self.lines.get_mut(id.checked_sub(self.first)? as usize)?;
        (line.status != Status::NotSent).then_some(line)
    }

    /// Returns the ids of the robots whose lines are not answered yet.
    pub(super) fn open_ids(&self) -> impl Iterator<Item = u32> {
        (self.first..)
            .zip(&self.lines)
            .filter(|(_, line)| line.status == Status::Open)
            .map(|(id, _)| id)
    }
}
