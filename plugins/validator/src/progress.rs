//! Rules of progress: robots with orders drive, and come to their stops.
//!
//! Robots that are held, broken or stalled, or that handle a stop, don't have to drive.

use glam::Vec2;
use regatta_plugin::frame::RobotState;

use crate::findings::{Finding, Findings, Kind};
use crate::motion::Row;
use crate::orders::Now;
use crate::world_model::WorldModel;

/// The distance in metres up to which a robot stands.
const STANDING: f32 = 0.01;
/// The largest number of edges that are kept of a robot's way since its last stop.
const MOST_EDGES: usize = 64;
/// The largest number of robots that a finding names.
const MOST_ROBOTS: usize = 100;
/// The part of the time of a standstill after which one that lasts at the end of a run counts:
/// nobody sees whether it would have ended.
const PART_AT_END: f64 = 0.4;

/// The times after which robots without progress are a finding, in seconds.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Limits {
    /// No robot with an order drives.
    pub standstill_secs: f64,
    /// One robot stands, or no robot comes to a stop.
    pub stuck_secs: f64,
}

/// The progress of a robot with an order.
#[derive(Clone, Debug)]
struct Robot {
    place: Vec2,
    /// The time in seconds since which it stands; that of its last sample if it moves.
    stands_since: f64,
    /// The edges of its way since it came to a stop, each once.
    edges: Vec<u32>,
    edge: u32,
    /// Whether it has come back to one of them.
    has_returned: bool,
    is_reported: bool,
    /// The last sample in which it had to drive.
    sample: u64,
}

/// The progress of all robots.
#[derive(Debug, Default)]
pub(crate) struct Progress {
    robots: Vec<Option<Robot>>,
    sample: u64,
    /// The number of robots that have to drive, and whether one of them moved in this sample.
    driving: u32,
    has_moved: bool,
    /// The time in seconds since which they all stand.
    stands_since: f64,
    is_standstill_reported: bool,
    /// The time in seconds at which a robot came to a stop of its order, or there was no order.
    arrived_at: f64,
    has_arrived: bool,
    is_livelock_reported: bool,
}

impl Progress {
    /// Begins a sample of a run.
    pub fn begin(&mut self, robots: usize) {
        self.robots.resize(robots, None);
        // Nothing is known of the time before the first sample.
        self.has_arrived |= self.sample == 0;
        self.sample += 1;
        (self.driving, self.has_moved) = (0, false);
    }

    /// Takes a robot with an order. `is_at_stop` means that it handles a stop.
    pub fn take(&mut self, robot: u32, row: &Row, is_at_stop: bool, now: Now) {
        let Some(known) = self.robots.get_mut(robot as usize) else { return };
        let waits = matches!(row.state, RobotState::Held | RobotState::Broken)
            || matches!(row.state, RobotState::Stalled | RobotState::Absent);
        if is_at_stop || waits {
            *known = None;
            self.has_moved |= is_at_stop;
            return;
        }
        self.driving += 1;
        // Robots that have just got an order begin to drive.
        let known = known.get_or_insert_with(|| {
            self.has_moved = true;
            Robot::new(row, now.seconds)
        });
        known.sample = self.sample;
        self.has_moved |= known.take(row, now.seconds);
    }

    /// Takes note that a robot came to a stop, handled it, or got an order.
    pub fn take_progress(&mut self, robot: u32) {
        self.has_arrived = true;
        if let Some(Some(known)) = self.robots.get_mut(robot as usize) {
            known.edges.clear();
            known.has_returned = false;
        }
    }

    /// Ends a sample, and finds what has stood for too long.
    pub fn judge(&mut self, now: Now, limits: Limits, world: &WorldModel, findings: &mut Findings) {
        for robot in &mut self.robots {
            robot.take_if(|robot| robot.sample != self.sample);
        }
        if self.is_standstill_reported {
            findings.set_duration(Kind::Standstill, now.seconds - self.stands_since);
        }
        if self.driving == 0 || self.has_moved {
            (self.stands_since, self.is_standstill_reported) = (now.seconds, false);
        }
        if self.driving == 0 || self.has_arrived {
            (self.arrived_at, self.is_livelock_reported) = (now.seconds, false);
        }
        if self.is_livelock_reported {
            findings.set_duration(Kind::Livelock, now.seconds - self.arrived_at);
        }
        self.has_arrived = false;
        self.judge_standstill(now, limits.standstill_secs, world, findings);
        self.judge_livelock(now, limits.stuck_secs, world, findings);
        self.judge_stuck(now, limits.stuck_secs, world, findings);
    }

    /// Finds a standstill that lasts at the end of the run.
    pub fn finish(
        &mut self,
        now: Now,
        limits: Limits,
        world: &WorldModel,
        findings: &mut Findings,
    ) {
        self.judge_standstill(now, PART_AT_END * limits.standstill_secs, world, findings);
    }

    fn judge_standstill(
        &mut self,
        now: Now,
        limit: f64,
        world: &WorldModel,
        findings: &mut Findings,
    ) {
        let secs = now.seconds - self.stands_since;
        if secs <= limit || std::mem::replace(&mut self.is_standstill_reported, true) {
            return;
        }
        findings.add(Kind::Standstill, || self.finding(now, (secs, limit), world, |_| true));
    }

    fn judge_livelock(
        &mut self,
        now: Now,
        limit: f64,
        world: &WorldModel,
        findings: &mut Findings,
    ) {
        let secs = now.seconds - self.arrived_at;
        let has_returned = self.robots.iter().flatten().any(|robot| robot.has_returned);
        if secs <= limit
            || !has_returned
            || self.is_standstill_reported
            || std::mem::replace(&mut self.is_livelock_reported, true)
        {
            return;
        }
        findings.add(Kind::Livelock, || {
            self.finding(now, (secs, limit), world, |robot| robot.has_returned)
        });
    }

    /// Finds robots that stand while others drive.
    fn judge_stuck(&mut self, now: Now, limit: f64, world: &WorldModel, findings: &mut Findings) {
        for (id, robot) in (0..).zip(&mut self.robots) {
            let Some(robot) = robot else { continue };
            let secs = now.seconds - robot.stands_since;
            if robot.is_reported {
                findings.set_duration_of(Kind::Stuck, id, secs);
            }
            // A standstill of all robots is found once.
            if self.is_standstill_reported
                || secs <= limit
                || std::mem::replace(&mut robot.is_reported, true)
            {
                continue;
            }
            findings.add(Kind::Stuck, || Finding {
                robots: vec![id],
                edge: world.edge_id(robot.edge),
                place: Some(robot.place.into()),
                value: Some(secs),
                limit: Some(limit),
                ..Finding::at(now.tick, now.seconds)
            });
        }
    }

    /// Makes the finding of some robots that have stood, or driven in vain, for some seconds.
    fn finding(
        &self,
        now: Now,
        (secs, limit): (f64, f64),
        world: &WorldModel,
        is_of: impl Fn(&Robot) -> bool,
    ) -> Finding {
        let robots = (0..).zip(&self.robots).filter_map(|(id, robot)| Some((id, robot.as_ref()?)));
        let found: Vec<(u32, &Robot)> =
            robots.filter(|(_, robot)| is_of(robot)).take(MOST_ROBOTS).collect();
        let first = found.first().map(|(_, robot)| robot);
        Finding {
            robots: found.iter().map(|(id, _)| *id).collect(),
            edge: first.and_then(|robot| world.edge_id(robot.edge)),
            place: first.map(|robot| robot.place.into()),
            value: Some(secs),
            limit: Some(limit),
            ..Finding::at(now.tick, now.seconds)
        }
    }
}

impl Robot {
    fn new(row: &Row, now_secs: f64) -> Self {
        Self {
            place: row.position,
            stands_since: now_secs,
            edges: Vec::new(),
            edge: row.edge,
            has_returned: false,
            is_reported: false,
            sample: 0,
        }
    }

    /// Takes a sample; returns whether the robot has moved since the last one.
    fn take(&mut self, row: &Row, now_secs: f64) -> bool {
        if row.edge != self.edge {
            self.edge = row.edge;
            if self.edges.contains(&row.edge) {
                self.has_returned = true;
            } else if self.edges.len() < MOST_EDGES {
                self.edges.push(row.edge);
            }
        }
        let has_moved = row.distance_to(self.place) > f64::from(STANDING);
        if has_moved {
            (self.place, self.stands_since, self.is_reported) = (row.position, now_secs, false);
        }
        has_moved
    }
}
