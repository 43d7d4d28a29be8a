//! Compares a visualiser's answers with the poses that were sent.
//!
//! An answer contains a robot and a pose, but not the line that it answers. Therefore the recently
//! sent lines are stored by frame, and an answer is assigned to the newest unanswered line of its
//! robot that has the answer's pose. Lines with equal poses (of a robot that stands still) can't be
//! distinguished, which doesn't affect any count.
//!
//! A line without an answer is *missing* after the deadline. If it is answered within another
//! deadline, it is *late* instead. An answer with a pose that was not sent recently is *differing*,
//! and is assigned to the oldest unanswered line of its robot. An answer to a line that is already
//! answered is *repeated*. An answer for a robot of which no line was sent recently is *unknown*.

mod rules;
mod sent;

use std::collections::VecDeque;
use std::fmt;
use std::time::Instant;

use crate::line::PoseLine;
pub use rules::EchoRules;
pub use sent::SentFrame;
use sent::Status;

/// The largest number of stored lines, of 16 bytes each. If more lines are sent within two
/// deadlines, the oldest ones are dropped and counted as *unchecked*.
pub const MAX_LINES: usize = 1 << 24;

/// The counts of a check. All but `repeated` and `unknown` are numbers of sent lines.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct EchoTotals {
    /// All sent lines.
    pub sent: u64,
    /// Lines answered in time.
    pub answered: u64,
    /// Lines not answered before the deadline, nor later so far.
    pub missing: u64,
    /// Lines answered after the deadline.
    pub late: u64,
    /// Lines answered with another pose.
    pub differing: u64,
    /// Lines dropped before the deadline, because too many were sent.
    pub unchecked: u64,
    /// Answers to lines that were already answered.
    pub repeated: u64,
    /// Answers for robots of which no line was sent recently.
    pub unknown: u64,
}

impl EchoTotals {
    /// Returns the number of unanswered lines whose deadline hasn't passed.
    pub fn open(&self) -> u64 {
        self.sent - self.answered - self.missing - self.late - self.differing - self.unchecked
    }
}

/// The numbers of one robot's lines that were not answered correctly.
#[derive(Clone, Copy, Debug, Default)]
struct RobotErrors {
    missing: u32,
    late: u32,
    differing: u32,
}

/// The comparison of answers with sent lines.
#[derive(Debug)]
pub struct EchoCheck {
    rules: EchoRules,
    max_lines: usize,
    /// The stored frames, oldest first.
    frames: VecDeque<SentFrame>,
    lines: usize,
    /// A dropped frame, whose memory is reused.
    spare: Option<SentFrame>,
    totals: EchoTotals,
    /// The errors, indexed by robot.
    errors: Vec<RobotErrors>,
    last_difference: Option<(PoseLine, PoseLine)>,
}

impl EchoCheck {
    /// Creates a check that stores at most [`MAX_LINES`] lines.
    pub fn new(rules: EchoRules) -> Self {
        Self {
            rules,
            max_lines: MAX_LINES,
            frames: VecDeque::new(),
            lines: 0,
            spare: None,
            totals: EchoTotals::default(),
            errors: Vec::new(),
            last_difference: None,
        }
    }

    /// Returns an empty frame, to be filled with the lines of robots from `first` on that are sent
    /// at `at`.
    pub fn frame(&mut self, first: u32, at: Instant) -> SentFrame {
        let mut lines = self.spare.take().map(|frame| frame.lines).unwrap_or_default();
        lines.clear();
        SentFrame { at, overdue: false, first, lines }
    }

    /// Stores the lines of a frame. This has to happen before they are sent.
    pub fn note(&mut self, frame: SentFrame) {
        self.totals.sent += frame.open_ids().count() as u64;
        self.lines += frame.lines.len();
        let robots = frame.first as usize + frame.lines.len();
        self.errors.resize(self.errors.len().max(robots), RobotErrors::default());
        self.frames.push_back(frame);
        while self.lines > self.max_lines
            && let Some(frame) = self.frames.pop_front()
        {
            self.totals.unchecked += frame.open_ids().count() as u64;
            self.forget(frame);
        }
    }

    /// Counts the lines whose deadline has passed at `now`, and drops those that have passed two
    /// deadlines.
    pub fn pass_time(&mut self, now: Instant) {
        let deadline = self.rules.deadline;
        let age = |frame: &SentFrame| now.saturating_duration_since(frame.at);
        let Self { frames, totals, errors, .. } = self;
        for frame in frames.iter_mut().filter(|frame| !frame.overdue && age(frame) > deadline) {
            frame.overdue = true;
            for (id, line) in (frame.first..)
                .zip(&mut frame.lines)
                .filter(|(_, line)| line.status == Status::Open)
            {
                line.status = Status::Missing;
                totals.missing += 1;
                errors[id as usize].missing += 1;
            }
        }
        while let Some(frame) = self.frames.pop_front_if(|frame| age(frame) > 2 * deadline) {
            self.forget(frame);
        }
    }

    /// Judges an answer that was received at `now`.
    pub fn judge(&mut self, answer: &PoseLine, now: Instant) {
        let (mut repeated, mut known, mut overdue) = (false, false, None);
        for (index, frame) in self.frames.iter_mut().enumerate().rev() {
            let in_time = now.saturating_duration_since(frame.at) <= self.rules.deadline;
            let Some(line) = frame.line_mut(answer.id) else { continue };
            known = true;
            if !self.rules.matches(line, answer) {
                continue;
            }
            match line.status {
                Status::Open if in_time => {
                    line.status = Status::Answered;
                    self.totals.answered += 1;
                    return;
                }
                Status::Open | Status::Missing => overdue = overdue.or(Some(index)),
                Status::Answered => repeated = true,
                Status::NotSent => {}
            }
        }
        match overdue {
            Some(index) => self.count_late(index, answer.id),
            None if repeated => self.totals.repeated += 1,
            None if known => self.count_differing(answer),
            None => self.totals.unknown += 1,
        }
    }

    /// Returns the counts so far.
    pub fn totals(&self) -> EchoTotals {
        self.totals
    }

    fn forget(&mut self, frame: SentFrame) {
        self.lines -= frame.lines.len();
        self.spare = Some(frame);
    }

    fn count_late(&mut self, index: usize, id: u32) {
        let Some(line) = self.frames.get_mut(index).and_then(|frame| frame.line_mut(id)) else {
            return;
        };
        let errors = &mut self.errors[id as usize];
        if line.status == Status::Missing {
            self.totals.missing -= 1;
            errors.missing -= 1;
        }
        line.status = Status::Answered;
        self.totals.late += 1;
        errors.late += 1;
    }

    fn count_differing(&mut self, answer: &PoseLine) {
        let lines = self.frames.iter_mut().filter_map(|frame| frame.line_mut(answer.id));
        let Some(line) = lines.into_iter().find(|line| line.status == Status::Open) else {
            self.totals.unknown += 1;
            return;
        };
        line.status = Status::Answered;
        let sent = PoseLine { id: answer.id, x: line.x, y: line.y, theta: line.theta };
        self.totals.differing += 1;
        self.errors[answer.id as usize].differing += 1;
        self.last_difference = Some((sent, *answer));
    }

    /// Lists the first robots with an error: `robot 7`, `2 robots: 3, 4` or `30 robots: 0, 1, 2, 3,
    /// 4, …`.
    fn robots_with(&self, error: impl Fn(&RobotErrors) -> u32) -> String {
        let ids = || {
            (0..)
                .zip(&self.errors)
                .filter(|(_, robot)| error(robot) > 0)
                .map(|(id, _): (u32, _)| id)
        };
        let first: Vec<_> = ids().take(5).map(|id| id.to_string()).collect();
        match ids().count() {
            0 => "0 robots".to_owned(),
            count if count > first.len() => format!("{count} robots: {}, …", first.join(", ")),
            1 => format!("robot {}", first[0]),
            count => format!("{count} robots: {}", first.join(", ")),
        }
    }
}

/// Formats the results as one line of text.
impl fmt::Display for EchoCheck {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let EchoTotals { sent, answered, missing, late, differing, unchecked, repeated, unknown } =
            self.totals;
        write!(f, "{answered} of {sent} lines answered, ")?;
        write!(f, "{missing} missing ({}), ", self.robots_with(|robot| robot.missing))?;
        write!(f, "{late} late ({}), ", self.robots_with(|robot| robot.late))?;
        write!(f, "{differing} differing ({})", self.robots_with(|robot| robot.differing))?;
        let rest = [
            (self.totals.open(), "open"),
            (repeated, "repeated"),
            (unknown, "unknown"),
            (unchecked, "unchecked"),
        ];
        rest.iter()
            .filter(|(count, _)| *count > 0)
            .try_for_each(|(count, name)| write!(f, ", {count} {name}"))?;
        match &self.last_difference {
            Some((sent, answer)) => write!(
                f,
                "; last difference: robot {} sent at ({}, {}, {}), answered at ({}, {}, {})",
                sent.id, sent.x, sent.y, sent.theta, answer.x, answer.y, answer.theta
            ),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests;
