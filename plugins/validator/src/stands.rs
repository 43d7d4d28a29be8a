//! The places at which robots stood recently: the order log may report them some frames later.

use glam::Vec2;

use crate::motion::Row;

/// The number of stands that are kept for each robot.
const KEPT: usize = 4;
/// The speed below which a robot stands, in metres per second.
const STANDING: f32 = 1e-3;
/// The largest move of a standing robot, in metres.
const MOVE_TOLERANCE: f64 = 0.002;

/// A robot's stay at one place, in ticks.
#[derive(Clone, Copy, Debug, Default)]
struct Stand {
    place: Vec2,
    /// The first frame in which it stood there.
    from: u64,
    /// The ticks before that frame that no frame has shown.
    unseen: u64,
    until: u64,
}

#[derive(Clone, Copy, Debug, Default)]
struct Robot {
    /// The latest first.
    stands: [Stand; KEPT],
    count: usize,
    stands_now: bool,
    /// The tick at which the robot appeared.
    since: u64,
    /// The last tick in which it was present.
    seen: u64,
    is_present: bool,
}

/// The place of a robot at a tick, as far as it is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Presence {
    /// The tick is too old, or frames were missed.
    Unknown,
    Moving,
    Stands(Vec2),
}

/// The recent stands of all robots.
#[derive(Debug, Default)]
pub(crate) struct Stands {
    robots: Vec<Robot>,
    /// The number of ticks between two frames that are not seen: the largest of recent frames.
    unseen: u64,
    /// The smallest number of ticks between two frames; 0 before there were two.
    usual: u64,
    /// The tick of the frame after the last gap: earlier stands may not have been seen.
    gap_end: u64,
}

/// The factor by which frames with a gap between them are farther apart than usual.
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

    /// Takes a robot that is present.
    pub fn take(&mut self, robot: usize, tick: u64, row: &Row) {
        let known = &mut self.robots[robot];
        if !known.is_present {
            *known = Robot { since: tick, is_present: true, ..Robot::default() };
        }
        known.seen = tick;
        let stands = row.speed.abs() < STANDING;
        let last = &mut known.stands[0];
        if stands && known.stands_now && row.distance_to(last.place) <= MOVE_TOLERANCE {
            last.until = tick;
        } else if stands {
            // A frame that was missed may have shown it already: also long after the gap.
            let unseen = self.unseen;
            known.stands.rotate_right(1);
            known.stands[0] = Stand { place: row.position, from: tick, unseen, until: tick };
            known.count = (known.count + 1).min(KEPT);
        }
        known.stands_now = stands;
    }

    pub fn take_absent(&mut self, robot: usize) {
        self.robots[robot].is_present = false;
    }

    /// Returns the place of a robot at a tick that has been judged.
    pub fn place(&self, robot: u32, tick: u64) -> Presence {
        let Some(robot) = self.robots.get(robot as usize).filter(|robot| robot.is_present) else {
            return Presence::Moving;
        };
        match robot.stand(tick, tick, self.unseen) {
            _ if tick < self.gap_end => Presence::Unknown,
            Some(stand) => Presence::Stands(stand.place),
            None if robot.knows(tick) => Presence::Moving,
            None => Presence::Unknown,
        }
    }

    /// Whether a robot is known to have moved between two ticks.
    pub fn moved(&self, robot: u32, from: u64, to: u64) -> bool {
        let Some(robot) = self.robots.get(robot as usize).filter(|robot| robot.is_present) else {
            return true;
        };
        if !robot.knows(from) || from < self.gap_end {
            return false;
        }
        robot.stand(from, to, self.unseen).is_none()
    }
}

impl Robot {
    /// Returns the stand that lasted from one tick to another, but for unseen ticks.
    fn stand(&self, from: u64, to: u64, unseen: u64) -> Option<&Stand> {
        self.stands[..self.count].iter().find(|stand| {
            stand.from <= from + unseen.max(stand.unseen) && stand.until + unseen >= to
        })
    }

    /// Whether all stands since a tick are kept.
    fn knows(&self, tick: u64) -> bool {
        let oldest = if self.count < KEPT { self.since } else { self.stands[KEPT - 1].from };
        oldest <= tick && tick <= self.seen
    }
}

#[cfg(test)]
mod tests {
    use regatta_plugin::frame::RobotState;

    use super::*;

    /// A robot that drives until a tick, and then stands.
    fn row(tick: u64, stands_from: u64) -> Row {
        let driven = tick.min(stands_from) as f32;
        let speed = if tick < stands_from { 1.0 } else { 0.0 };
        let (position, state) = (Vec2::new(driven, 0.0), RobotState::Driving);
        Row { position, theta: 0.0, speed, s: driven, edge: 0, state }
    }

    #[test]
    fn a_robot_that_came_in_a_missed_frame_has_not_moved_since() {
        let mut stands = Stands::default();
        let mut before = 0;
        // A frame every 5 ticks, of which three are missed.
        for tick in (0..=200).step_by(5).filter(|tick| !(95..110).contains(tick)) {
            stands.begin_frame(1, tick, tick - before);
            stands.take(0, tick, &row(tick, 98));
            before = tick;
        }
        assert!(!stands.moved(0, 100, 200), "it stands from tick 98 on");
        assert!(stands.moved(0, 80, 200), "it drove at tick 90");
        assert_eq!(stands.place(0, 200), Presence::Stands(Vec2::new(98.0, 0.0)));
    }
}
