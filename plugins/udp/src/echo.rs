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

use std::collections::VecDeque;
use std::fmt;
use std::time::{Duration, Instant};

use crate::line::{AngleUnit, LineFormat, PoseLine};

/// The largest number of stored lines, of 16 bytes each. If more lines are sent within two
/// deadlines, the oldest ones are dropped and counted as *unchecked*.
pub const MAX_LINES: usize = 1 << 24;

/// The rules of an [`EchoCheck`].
#[derive(Clone, Copy, Debug)]
pub struct EchoRules {
    /// The largest accepted difference of x and y in metres, in addition to the rounding of an
    /// `f32`.
    pub tolerance: f64,
    /// The largest accepted difference of theta in `unit`, in addition to the rounding of an `f32`.
    pub theta_tolerance: f64,
    /// The unit of theta in sent lines and answers.
    pub unit: AngleUnit,
    /// The offset that the visualiser adds to x and y, in metres.
    pub offset: [f64; 2],
    /// The time within which a line has to be answered.
    pub deadline: Duration,
}

impl EchoRules {
    /// Creates the rules for sent lines with `format` and answers with `decimals` decimals. The
    /// tolerances are one unit of the last decimal that both have.
    pub fn new(
        format: LineFormat,
        decimals: usize,
        unit: AngleUnit,
        offset: [f64; 2],
        deadline: Duration,
    ) -> Self {
        let [tolerance, theta_tolerance] = [format.decimals, format.theta_decimals]
            .map(|sent| 10_f64.powi(-(sent.min(decimals) as i32)));
        Self { tolerance, theta_tolerance, unit, offset, deadline }
    }

    /// Whether an answer has the pose of a sent line.
    fn matches(&self, sent: &SentLine, answer: &PoseLine) -> bool {
        let is_near = [(sent.x, answer.x, self.offset[0]), (sent.y, answer.y, self.offset[1])]
            .into_iter()
            .all(|(sent, answer, offset)| {
                let off = (f64::from(answer) - offset - f64::from(sent)).abs();
                off <= self.tolerance * 1.001 + rounding(answer.abs().max(sent.abs()))
            });
        let turn = (f64::from(answer.theta) - f64::from(sent.theta)).rem_euclid(self.unit.turn());
        let turn = turn.min(self.unit.turn() - turn);
        is_near && turn <= self.theta_tolerance * 1.001 + rounding(answer.theta.abs())
    }
}

/// Returns the rounding error of an `f32` of this magnitude.
fn rounding(magnitude: f32) -> f64 {
    f64::from(magnitude) * 2.0 * f64::from(f32::EPSILON)
}

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
        self.totals.sent += frame.open_lines();
        self.lines += frame.lines.len();
        let robots = frame.first as usize + frame.lines.len();
        self.errors.resize(self.errors.len().max(robots), RobotErrors::default());
        self.frames.push_back(frame);
        while self.lines > self.max_lines
            && let Some(frame) = self.frames.pop_front()
        {
            self.totals.unchecked += frame.open_lines();
            self.forget(frame);
        }
    }

    /// Counts the lines whose deadline has passed at `now`, and drops those that have passed two
    /// deadlines.
    pub fn pass_time(&mut self, now: Instant) {
        let deadline = self.rules.deadline;
        let Self { frames, totals, errors, .. } = self;
        for frame in frames.iter_mut().filter(|frame| !frame.overdue && frame.age(now) > deadline) {
            frame.overdue = true;
            for (id, line) in (frame.first..).zip(&mut frame.lines) {
                if line.status == Status::Open {
                    line.status = Status::Missing;
                    totals.missing += 1;
                    errors[id as usize].missing += 1;
                }
            }
        }
        while let Some(frame) = self.frames.pop_front_if(|frame| frame.age(now) > 2 * deadline) {
            self.forget(frame);
        }
    }

    /// Judges an answer that was received at `now`.
    pub fn judge(&mut self, answer: &PoseLine, now: Instant) {
        let (mut repeated, mut known, mut overdue) = (false, false, None);
        for (index, frame) in self.frames.iter_mut().enumerate().rev() {
            let in_time = frame.age(now) <= self.rules.deadline;
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
        let ids = (0..self.errors.len()).filter(|id| error(&self.errors[*id]) > 0);
        let first: Vec<_> = ids.clone().take(5).map(|id| id.to_string()).collect();
        match ids.count() {
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
        for (count, name) in rest.iter().filter(|(count, _)| *count > 0) {
            write!(f, ", {count} {name}")?;
        }
        if let Some((sent, answer)) = &self.last_difference {
            let PoseLine { id, x, y, theta } = sent;
            write!(f, "; last difference: robot {id} sent at ({x}, {y}, {theta}), ")?;
            write!(f, "answered at ({}, {}, {})", answer.x, answer.y, answer.theta)?;
        }
        Ok(())
    }
}

/// The status of a stored line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Status {
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
struct SentLine {
    pub x: f32,
    pub y: f32,
    pub theta: f32,
    pub status: Status,
}

/// The sent lines of one frame.
#[derive(Debug)]
pub struct SentFrame {
    at: Instant,
    overdue: bool,
    /// The id of the robot of the first line.
    first: u32,
    /// The lines, indexed by the robot's id minus `first`.
    lines: Vec<SentLine>,
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
    fn line_mut(&mut self, id: u32) -> Option<&mut SentLine> {
        let line = self.lines.get_mut(id.checked_sub(self.first)? as usize)?;
        (line.status != Status::NotSent).then_some(line)
    }

    /// Returns the number of lines that are not answered yet.
    fn open_lines(&self) -> u64 {
        self.lines.iter().filter(|line| line.status == Status::Open).count() as u64
    }

    fn age(&self, now: Instant) -> Duration {
        now.saturating_duration_since(self.at)
    }
}

#[cfg(test)]
mod tests;
