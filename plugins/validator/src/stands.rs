//! Where robots stood in the last while, because the task log may tell it some frames later.

use crate::row::Row;

/// The number of stands that are kept for each robot.
const KEPT: usize = 4;
/// The speed below which a robot stands, in metres per second.
const STANDING: f32 = 1e-3;
/// Metres that a standing robot may move.
const MOVE_TOLERANCE: f64 = 0.002;

/// A robot's stay at one place, in ticks.
#[derive(Clone, Copy, Debug, Default)]
struct Stand {
    place: [f32; 2],
    from: u64,
    until: u64,
}

#[derive(Clone, Copy, Debug, Default)]
struct Robot {
    /// The latest first.
    stands: [Stand; KEPT],
    count: usize,
    stands_now: bool,
    /// The tick from which on the robot was watched.
    since: u64,
    /// The last tick in which it was there.
    seen: u64,
    is_there: bool,
}

/// What is known of a robot at a tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Presence {
    /// It is too long ago, or frames were missed.
    Unknown,
    Moving,
    Stands([f32; 2]),
}

/// Where all robots stood.
#[derive(Debug, Default)]
pub(crate) struct Stands {
    robots: Vec<Robot>,
    /// The largest number of ticks between two frames of late, less one: what happens between them
    /// is not seen.
    unseen: u64,
    /// The smallest number of ticks between two frames; 0 before there were two.
    usual: u64,
    /// The tick of the frame after the last gap: what happened before may not have been seen.
    gap_end: u64,
}

/// Frames this many times as far apart as usual have a gap between them.
const GAP: u64 = 4;

impl Stands {
    /// Begins the frame of a tick, `ticks` after the one before; 0 for the first.
    pub fn begin_frame(&mut self, robots: usize, tick: u64, ticks: u64) {
        self.robots.resize(robots, Robot::default());
        if ticks > 0 {
            self.usual = if self.usual == 0 { ticks } else { self.usual.min(ticks) };
            self.gap_end = if ticks > GAP * self.usual { tick } else { self.gap_end };
        }
        self.unseen = ticks.saturating_sub(1).max(self.unseen.saturating_sub(1));
    }

    /// Takes a robot that is there.
    pub fn take(&mut self, robot: usize, tick: u64, row: &Row) {
        let known = &mut self.robots[robot];
        if !known.is_there {
            *known = Robot { since: tick, is_there: true, ..Robot::default() };
        }
        known.seen = tick;
        let stands = row.speed.abs() < STANDING;
        let last = &mut known.stands[0];
        if stands && known.stands_now && row.distance_to(last.place) <= MOVE_TOLERANCE {
            last.until = tick;
        } else if stands {
            known.stands.rotate_right(1);
            known.stands[0] = Stand { place: [row.x, row.y], from: tick, until: tick };
            known.count = (known.count + 1).min(KEPT);
        }
        known.stands_now = stands;
    }

    pub fn take_absent(&mut self, robot: usize) {
        self.robots[robot].is_there = false;
    }

    /// Where a robot stood at a tick that has been judged.
    pub fn place(&self, robot: u32, tick: u64) -> Presence {
        let Some(robot) = self.robots.get(robot as usize).filter(|robot| robot.is_there) else {
            return Presence::Moving;
        };
        match robot.stand(tick, self.unseen) {
            _ if tick < self.gap_end => Presence::Unknown,
            Some(stand) => Presence::Stands(stand.place),
            None if robot.knows(tick) => Presence::Moving,
            None => Presence::Unknown,
        }
    }

    /// Whether a robot didn't stand still from one tick to another, as far as that is known.
    pub fn moved(&self, robot: u32, from: u64, to: u64) -> bool {
        let Some(robot) = self.robots.get(robot as usize).filter(|robot| robot.is_there) else {
            return true;
        };
        if !robot.knows(from) || from < self.gap_end {
            return false;
        }
        let holds =
            |stand: &Stand| stand.from <= from + self.unseen && stand.until + self.unseen >= to;
        !robot.stands[..robot.count].iter().any(holds)
    }
}

impl Robot {
    fn stand(&self, tick: u64, unseen: u64) -> Option<&Stand> {
        let holds = |stand: &&Stand| stand.from <= tick + unseen && stand.until + unseen >= tick;
        self.stands[..self.count].iter().find(holds)
    }

    /// Whether all stands since a tick are kept.
    fn knows(&self, tick: u64) -> bool {
        let oldest = if self.count < KEPT { self.since } else { self.stands[KEPT - 1].from };
        oldest <= tick && tick <= self.seen
    }
}
