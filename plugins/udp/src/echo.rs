//! Holds a visualiser's answers against the poses that were sent.
//!
//! An answer names a robot and a pose, but not the line that it answers. So the poses sent lately are remembered,
//! frame by frame, and an answer goes to the newest line of its robot that has this pose and is still unanswered.
//! Lines with equal poses (a robot that stands) can't be told apart, which changes no count.
//!
//! A line without an answer is *missing* when the deadline has passed; if its answer comes within another deadline
//! after all, it is *late* instead. An answer with a pose that was not sent lately is *differing*, and uses up the
//! oldest unanswered line of its robot. Answers to lines that have one are *repeated*; answers for robots of which
//! nothing was sent lately are *unknown*.

mod rules;

use std::collections::VecDeque;
use std::fmt;
use std::time::Instant;

use crate::line::PoseLine;
pub use rules::EchoRules;

/// Most lines that are remembered; 16 bytes each. When more than that are sent within two deadlines, the oldest are
/// given up *unchecked*.
pub const MOST_LINES: usize = 1 << 24;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Fate {
    NotSent,
    Open,
    /// Answered in time, late, or with another pose.
    Settled,
    Missing,
}

/// What was sent of one robot.
#[derive(Clone, Copy, Debug)]
struct Sent {
    x: f32,
    y: f32,
    theta: f32,
    fate: Fate,
}

/// The lines of one frame, under construction or remembered.
#[derive(Debug)]
pub struct SentFrame {
    at: Instant,
    overdue: bool,
    first: u32,
    rows: Vec<Sent>,
}

impl SentFrame {
    /// Adds a line. Ids ascend.
    pub fn push(&mut self, line: &PoseLine) {
        let Some(place) = line.id.checked_sub(self.first).map(|place| place as usize) else { return };
        let nothing = Sent { x: 0.0, y: 0.0, theta: 0.0, fate: Fate::NotSent };
        self.rows.resize(place.max(self.rows.len()), nothing);
        self.rows.push(Sent { x: line.x, y: line.y, theta: line.theta, fate: Fate::Open });
    }

    fn row_mut(&mut self, id: u32) -> Option<&mut Sent> {
        let row = self.rows.get_mut(id.checked_sub(self.first)? as usize)?;
        (row.fate != Fate::NotSent).then_some(row)
    }

    /// The ids of the lines whose fate is open.
    fn open_ids(&self) -> impl Iterator<Item = u32> {
        (self.first..).zip(&self.rows).filter(|(_, row)| row.fate == Fate::Open).map(|(id, _)| id)
    }
}

/// How many lines met which fate. All but `repeated` and `unknown` count lines that were sent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct EchoTotals {
    /// All lines.
    pub sent: u64,
    /// Answered in time.
    pub answered: u64,
    /// Not answered in time, nor later so far.
    pub missing: u64,
    /// Answered after the deadline.
    pub late: u64,
    /// Answered with another pose.
    pub differing: u64,
    /// Given up before the deadline, because too many were sent.
    pub unchecked: u64,
    /// Answers to lines that had one.
    pub repeated: u64,
    /// Answers for robots of which nothing was sent lately.
    pub unknown: u64,
}

impl EchoTotals {
    /// Lines that still have time.
    pub fn open(&self) -> u64 {
        self.sent - self.answered - self.missing - self.late - self.differing - self.unchecked
    }
}

/// The lines of one robot that were not answered as they should.
#[derive(Clone, Copy, Debug, Default)]
struct Trouble {
    missing: u32,
    late: u32,
    differing: u32,
}

/// The check.
#[derive(Debug)]
pub struct EchoCheck {
    rules: EchoRules,
    most_lines: usize,
    /// Oldest first.
    frames: VecDeque<SentFrame>,
    lines: usize,
    /// A frame that is remembered no more, for its memory.
    spare: Option<SentFrame>,
    totals: EchoTotals,
    /// By robot.
    troubles: Vec<Trouble>,
    last_difference: Option<(PoseLine, PoseLine)>,
}

impl EchoCheck {
    /// A check that remembers [`MOST_LINES`] at most.
    pub fn new(rules: EchoRules) -> Self {
        Self {
            rules,
            most_lines: MOST_LINES,
            frames: VecDeque::new(),
            lines: 0,
            spare: None,
            totals: EchoTotals::default(),
            troubles: Vec::new(),
            last_difference: None,
        }
    }

    /// A frame to note lines in, from robot `first` on, before they are sent at `at`.
    pub fn frame(&mut self, first: u32, at: Instant) -> SentFrame {
        let mut rows = self.spare.take().map(|frame| frame.rows).unwrap_or_default();
        rows.clear();
        SentFrame { at, overdue: false, first, rows }
    }

    /// Takes note of a frame's lines.
    pub fn note(&mut self, frame: SentFrame) {
        self.totals.sent += frame.open_ids().count() as u64;
        self.lines += frame.rows.len();
        let robots = frame.first as usize + frame.rows.len();
        self.troubles.resize(self.troubles.len().max(robots), Trouble::default());
        self.frames.push_back(frame);
        while self.lines > self.most_lines
            && let Some(frame) = self.frames.pop_front()
        {
            self.totals.unchecked += frame.open_ids().count() as u64;
            self.forget(frame);
        }
    }

    /// Judges what the passing of time has settled.
    pub fn pass_time(&mut self, now: Instant) {
        let deadline = self.rules.deadline;
        let age = |frame: &SentFrame| now.saturating_duration_since(frame.at);
        let Self { frames, totals, troubles, .. } = self;
        for frame in frames.iter_mut().filter(|frame| !frame.overdue && age(frame) > deadline) {
            frame.overdue = true;
            for (id, row) in (frame.first..).zip(&mut frame.rows).filter(|(_, row)| row.fate == Fate::Open) {
                row.fate = Fate::Missing;
                totals.missing += 1;
                troubles[id as usize].missing += 1;
            }
        }
        while let Some(frame) = self.frames.pop_front_if(|frame| age(frame) > 2 * deadline) {
            self.forget(frame);
        }
    }

    /// Judges an answer that came at `now`.
    pub fn judge(&mut self, answer: &PoseLine, now: Instant) {
        let (mut repeated, mut known, mut overdue) = (false, false, None);
        for (index, frame) in self.frames.iter_mut().enumerate().rev() {
            let in_time = now.saturating_duration_since(frame.at) <= self.rules.deadline;
            let Some(row) = frame.row_mut(answer.id) else { continue };
            known = true;
            if !self.rules.matches(row, answer) {
                continue;
            }
            match row.fate {
                Fate::Open if in_time => {
                    row.fate = Fate::Settled;
                    self.totals.answered += 1;
                    return;
                }
                Fate::Open | Fate::Missing => overdue = overdue.or(Some(index)),
                Fate::Settled => repeated = true,
                Fate::NotSent => {}
            }
        }
        match overdue {
            Some(index) => self.settle_late(index, answer.id),
            None if repeated => self.totals.repeated += 1,
            None if known => self.settle_differing(answer),
            None => self.totals.unknown += 1,
        }
    }

    /// What came of the lines so far.
    pub fn totals(&self) -> EchoTotals {
        self.totals
    }

    fn forget(&mut self, frame: SentFrame) {
        self.lines -= frame.rows.len();
        self.spare = Some(frame);
    }

    fn settle_late(&mut self, index: usize, id: u32) {
        let Some(row) = self.frames.get_mut(index).and_then(|frame| frame.row_mut(id)) else { return };
        let trouble = &mut self.troubles[id as usize];
        if row.fate == Fate::Missing {
            self.totals.missing -= 1;
            trouble.missing -= 1;
        }
        row.fate = Fate::Settled;
        self.totals.late += 1;
        trouble.late += 1;
    }

    fn settle_differing(&mut self, answer: &PoseLine) {
        let rows = self.frames.iter_mut().filter_map(|frame| frame.row_mut(answer.id));
        let Some(row) = rows.into_iter().find(|row| row.fate == Fate::Open) else {
            self.totals.unknown += 1;
            return;
        };
        row.fate = Fate::Settled;
        let sent = PoseLine { id: answer.id, x: row.x, y: row.y, theta: row.theta };
        self.totals.differing += 1;
        self.troubles[answer.id as usize].differing += 1;
        self.last_difference = Some((sent, *answer));
    }

    fn robots_with(&self, trouble: impl Fn(&Trouble) -> u32) -> String {
        let ids = || (0..).zip(&self.troubles).filter(|(_, robot)| trouble(robot) > 0).map(|(id, _): (u32, _)| id);
        let first: Vec<_> = ids().take(5).map(|id| id.to_string()).collect();
        match ids().count() {
            0 => "0 robots".to_owned(),
            count if count > first.len() => format!("{count} robots: {}, …", first.join(", ")),
            1 => format!("robot {}", first[0]),
            count => format!("{count} robots: {}", first.join(", ")),
        }
    }
}

/// One line for a person.
impl fmt::Display for EchoCheck {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let EchoTotals { sent, answered, missing, late, differing, unchecked, repeated, unknown } = self.totals;
        write!(f, "{answered} of {sent} lines answered, ")?;
        write!(f, "{missing} missing ({}), ", self.robots_with(|robot| robot.missing))?;
        write!(f, "{late} late ({}), ", self.robots_with(|robot| robot.late))?;
        write!(f, "{differing} differing ({})", self.robots_with(|robot| robot.differing))?;
        let rest =
            [(self.totals.open(), "open"), (repeated, "repeated"), (unknown, "unknown"), (unchecked, "unchecked")];
        rest.iter().filter(|(count, _)| *count > 0).try_for_each(|(count, what)| write!(f, ", {count} {what}"))?;
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
