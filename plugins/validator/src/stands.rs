//! The places at which robots stood recently: the order log may report them some frames later.

use std::collections::VecDeque;

use glam::Vec2;

use crate::motion::Row;

/// The number of stands that are kept for each robot.
const KEPT: usize = 4;
/// The number of frames whose ticks are kept: a second or more, at any speed of the clock.
const KEPT_FRAMES: usize = 8192;
/// The speed below which a robot stands, in metres per second.
const STANDING: f32 = 1e-3;
/// The largest move of a standing robot, in metres.
const MOVE_TOLERANCE: f64 = 0.002;

/// A robot's stay at one place, in ticks. No frame shows it elsewhere from `earliest` to `latest`.
#[derive(Clone, Copy, Debug, Default)]
struct Stand {
    place: Vec2,
    /// The tick after the last frame that shows it elsewhere.
    earliest: u64,
    /// The first frame that shows it there.
    from: u64,
    /// The tick before the first frame that shows it elsewhere again.
    latest: u64,
}

#[derive(Clone, Copy, Debug, Default)]
struct Robot {
    /// The latest first.
    stands: [Stand; KEPT],
    count: usize,
    stands_now: bool,
    /// The tick at which the robot appeared.
    since: u64,
    /// The tick of the first frame without it.
    gone: u64,
}

/// The place of a robot at a tick, as far as it is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Presence {
    /// The tick is too old, or its frame was missed.
    Unknown,
    Moving,
    Stands(Vec2),
}

/// The recent stands of all robots.
#[derive(Debug, Default)]
pub(crate) struct Stands {
    robots: Vec<Robot>,
    /// The ticks of the last frames, in ascending order.
    frames: VecDeque<u64>,
    /// The tick of this frame, and the tick after the frame before.
    now: u64,
    after_last: u64,
}

impl Stands {
    /// Begins the frame of a tick.
    pub fn begin_frame(&mut self, robots: usize, tick: u64) {
        self.robots.resize(robots, Robot::default());
        self.after_last = self.frames.back().map_or(0, |last| last + 1);
        self.now = tick;
        if self.frames.len() == KEPT_FRAMES {
            self.frames.pop_front();
        }
        self.frames.push_back(tick);
    }

    /// Takes a robot that is present.
    pub fn take(&mut self, robot: usize, row: &Row) {
        let (tick, earliest) = (self.now, self.after_last);
        let known = &mut self.robots[robot];
        if known.is_gone(tick) {
            *known = Robot { since: tick, gone: u64::MAX, ..Robot::default() };
        }
        let stands = row.speed.abs() < STANDING;
        let last = &mut known.stands[0];
        let stays = stands && known.stands_now && row.distance_to(last.place) <= MOVE_TOLERANCE;
        if known.stands_now && !stays {
            last.latest = tick - 1;
        }
        if stands && !stays {
            known.stands.rotate_right(1);
            known.stands[0] = Stand { place: row.position, earliest, from: tick, latest: u64::MAX };
            known.count = (known.count + 1).min(KEPT);
        }
        known.stands_now = stands;
    }

    pub fn take_absent(&mut self, robot: usize) {
        let known = &mut self.robots[robot];
        known.gone = known.gone.min(self.now);
    }

    /// Returns the place of a robot at a tick that has been judged.
    pub fn place(&self, robot: u32, tick: u64) -> Presence {
        if self.frames.binary_search(&tick).is_err() {
            return Presence::Unknown;
        }
        let Some(robot) = self.robots.get(robot as usize).filter(|robot| !robot.is_gone(tick))
        else {
            return Presence::Moving;
        };
        match robot.stand(tick, tick) {
            Some(stand) => Presence::Stands(stand.place),
            None if robot.knows(tick) => Presence::Moving,
            None => Presence::Unknown,
        }
    }

    /// Whether a robot is known to have moved between two ticks.
    pub fn moved(&self, robot: u32, from: u64, to: u64) -> bool {
        let Some(robot) = self.robots.get(robot as usize).filter(|robot| !robot.is_gone(to)) else {
            return true;
        };
        robot.knows(from) && robot.stand(from, to).is_none()
    }
}

impl Robot {
    /// Returns a stand that may have lasted from one tick to another.
    fn stand(&self, from: u64, to: u64) -> Option<&Stand> {
        let mut stands = self.stands[..self.count].iter();
        stands.find(|stand| stand.earliest <= from && to <= stand.latest)
    }

    /// Whether all stands since a tick are kept.
    fn knows(&self, tick: u64) -> bool {
        let oldest = if self.count < KEPT { self.since } else { self.stands[KEPT - 1].from };
        oldest <= tick
    }

    fn is_gone(&self, tick: u64) -> bool {
        self.gone <= tick
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
        // A frame every 5 ticks, of which three are missed.
        for tick in (0..=200).step_by(5).filter(|tick| !(95..110).contains(tick)) {
            stands.begin_frame(1, tick);
            stands.take(0, &row(tick, 98));
        }
        assert!(!stands.moved(0, 100, 200), "it stands from tick 98 on");
        assert!(stands.moved(0, 80, 200), "it drove at tick 90");
        assert_eq!(stands.place(0, 200), Presence::Stands(Vec2::new(98.0, 0.0)));
    }

    #[test]
    fn a_robot_that_left_in_a_missed_frame_may_have_stood_until_then() {
        let mut stands = Stands::default();
        for tick in (0..=200).filter(|tick| !(97..100).contains(tick)) {
            stands.begin_frame(1, tick);
            let driven = tick.saturating_sub(98) as f32;
            let speed = if tick > 98 { 1.0 } else { 0.0 };
            stands.take(0, &Row { position: Vec2::new(driven, 0.0), speed, ..row(tick, 0) });
        }
        // Frames that came since don't make the missed ones known.
        assert_eq!(stands.place(0, 98), Presence::Unknown);
        assert!(!stands.moved(0, 50, 99), "no frame shows that it moved");
        assert!(stands.moved(0, 50, 100), "frame 100 does");
        assert_eq!(stands.place(0, 96), Presence::Stands(Vec2::ZERO));
        assert_eq!(stands.place(0, 100), Presence::Moving);
    }

    #[test]
    fn a_robot_that_was_removed_stood_until_then() {
        let mut stands = Stands::default();
        for tick in 0..20 {
            stands.begin_frame(1, tick);
            if tick < 10 { stands.take(0, &row(tick, 0)) } else { stands.take_absent(0) }
        }
        assert_eq!(stands.place(0, 9), Presence::Stands(Vec2::ZERO));
        assert!(!stands.moved(0, 2, 9) && stands.moved(0, 2, 10));
        assert_eq!(stands.place(0, 10), Presence::Moving, "there is no such robot");
        stands.begin_frame(1, 20);
        stands.take(0, &row(20, 0));
        assert_eq!(stands.place(0, 9), Presence::Unknown, "another robot has its number");
    }
}
