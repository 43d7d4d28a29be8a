//! The path of a robot: the legs that it drives within the horizon, along its route or along every
//! way.

use super::{Intent, MAX_SPEED, Motion};
use crate::edge_table::Chord;
use crate::leg_table::{Leg, LegInfo, LegTable};

/// The largest number of ways that are predicted for one robot. Beyond it, a robot drives straight
/// on at a fork.
const MAX_WAYS: usize = 8;
/// The largest number of legs at a fork that counts. At a larger one, a robot drives straight on.
const MAX_FORK: usize = 4;
/// The largest number of legs of a path.
const MAX_LEGS: usize = 64;
/// The factor by which a robot may exceed its braking curve: speeds change tick by tick.
const SPEED_TOLERANCE: f32 = 1.05;

/// The continuation after the last leg of a path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum RouteEnd {
    /// The robot stops there.
    Stop,
    /// It is not known.
    Open,
}

/// A leg of a path.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PathLeg {
    pub leg: Leg,
    /// Metres that are driven.
    pub length: f32,
    /// Highest speed, in metres per second; not above 0 if it is unknown.
    pub speed: f32,
}

impl PathLeg {
    /// Returns 1, or -1 in reverse gear.
    pub(super) fn sign(&self) -> f32 {
        if self.leg.is_reverse() { -1.0 } else { 1.0 }
    }
}

/// A robot at the start of its path.
#[derive(Clone, Copy, Debug)]
pub(super) struct Start<'table> {
    pub motion: Motion<'table>,
    /// 1, or -1 in reverse gear.
    pub sign: f32,
    /// The leg that the robot is on.
    on: Option<LegInfo<'table>>,
}

impl<'table> Start<'table> {
    pub(super) fn new(motion: &Motion<'table>, table: &'table LegTable) -> Self {
        let known = motion.route.and_then(|route| route.reverse);
        let reverse = motion.speed < 0.0 || motion.speed == 0.0 && known == Some(true);
        let on = table.get(Leg::new(motion.edge, reverse)).filter(|_| motion.s.is_finite());
        // A robot beyond an end of its leg counts as at that end: a faulty producer may put it
        // anywhere.
        let s = on.map_or(motion.s, |on| motion.s.min(on.length).max(0.0));
        Self { motion: Motion { s, ..*motion }, sign: if reverse { -1.0 } else { 1.0 }, on }
    }

    pub(super) fn chords(&self) -> &'table [Chord] {
        self.on.map_or(&[], |on| on.chords)
    }

    /// Returns the highest speed of the leg that the robot is on; not above 0 if it is unknown.
    pub(super) fn leg_speed(&self) -> f32 {
        match self.on {
            // A robot without a limit has the speed of its leg already.
            Some(on) if self.motion.limits.max_acceleration.is_finite() => on.speed,
            _ => 0.0,
        }
    }

    /// Returns the metres to the end of the leg that the robot is on, or of its base there; `None`
    /// without a leg.
    pub(super) fn rest(&self) -> Option<f32> {
        let on = self.on?;
        let rest = if self.sign > 0.0 { on.length - self.motion.s } else { self.motion.s };
        let ends_here =
            self.motion.route.filter(|route| route.legs.is_empty() && route.end == RouteEnd::Stop);
        // The base may end before the leg does.
        Some(ends_here.map_or(rest, |route| rest - (on.length - route.limit).max(0.0)).max(0.0))
    }

    /// Returns the largest change of speed, in metres per second squared; infinity if it changes at
    /// once.
    pub(super) fn acceleration(&self) -> f32 {
        if self.motion.intent == Intent::Keep {
            f32::INFINITY
        } else {
            self.motion.limits.max_acceleration
        }
    }

    /// Returns the speed that the robot accelerates or brakes to on a leg, given the leg's speed.
    pub(super) fn cruise(&self, leg_speed: f32) -> f32 {
        let now = self.motion.speed.abs();
        match self.motion.intent {
            Intent::Hold => 0.0,
            Intent::Keep => now,
            Intent::Drive if leg_speed > 0.0 => {
                leg_speed.min(self.motion.limits.max_speed).min(MAX_SPEED)
            }
            Intent::Drive => now,
        }
    }

    /// Returns the present speed, given the speed that the robot accelerates or brakes to.
    pub(super) fn speed(&self, cruise: f32) -> f32 {
        if self.acceleration().is_finite() { self.motion.speed.abs() } else { cruise }
    }

    /// Returns the highest speed that the robot may have on the leg that it is on.
    pub(super) fn top_speed(&self) -> f32 {
        let cruise = self.cruise(self.leg_speed());
        // A robot without a limit that stands doesn't want to drive.
        self.speed(cruise).max(cruise)
    }

    /// Returns the metres within which everything may matter to the robot: the way until the
    /// horizon, and the way that it takes to brake.
    pub(super) fn longest_way(&self, horizon: f32) -> f32 {
        self.top_speed() * horizon + self.braking_distance(self.top_speed())
    }

    fn braking_distance(&self, speed: f32) -> f32 {
        0.5 * speed * speed / self.acceleration()
    }

    /// Whether the robot can still become slow enough for a leg after that many metres.
    fn can_enter(&self, metres: f32, leg_speed: f32) -> bool {
        let cruise = self.cruise(leg_speed);
        let square = cruise * cruise + 2.0 * self.acceleration() * metres.max(0.0);
        let speed = self.motion.speed;
        self.motion.intent != Intent::Drive
            || speed * speed <= square * (SPEED_TOLERANCE * SPEED_TOLERANCE)
    }
}

/// Finds the paths of a robot.
pub(super) struct PathFinder<'a, 'table> {
    start: &'a Start<'table>,
    table: &'table LegTable,
    path: &'a mut Vec<PathLeg>,
    ways_left: usize,
}

impl<'a, 'table> PathFinder<'a, 'table> {
    /// Creates a finder. `path` is scratch memory.
    pub(super) fn new(
        start: &'a Start<'table>,
        table: &'table LegTable,
        path: &'a mut Vec<PathLeg>,
    ) -> Self {
        path.clear();
        Self { start, table, path, ways_left: MAX_WAYS }
    }

    /// Calls `each` for every path: the legs after the one that the robot is on, of which `rest`
    /// metres are left.
    pub(super) fn find(
        &mut self,
        rest: f32,
        horizon: f32,
        mut each: impl FnMut(&[PathLeg], RouteEnd),
    ) {
        let mut way = Way { seconds: horizon, top: self.start.top_speed(), metres: 0.0 };
        way.drive(rest);
        let Some(route) = self.start.motion.route else { return self.branch(way, &mut each) };
        for leg in route.legs {
            let Some(next) = path_leg(self.table, *leg) else {
                return each(self.path, RouteEnd::Open);
            };
            // Beyond the horizon, legs count only as far as the robot brakes for them within it.
            let is_far = way.metres >= way.top * horizon + self.start.braking_distance(way.top);
            if is_far || self.path.len() >= MAX_LEGS {
                return each(self.path, RouteEnd::Open);
            }
            way.top = way.top.max(self.start.cruise(next.speed));
            way.drive(next.length);
            self.path.push(next);
        }
        match route.end {
            RouteEnd::Stop => {
                if let Some(last) = self.path.last_mut() {
                    last.length = last.length.min(route.limit).max(0.0);
                }
                each(self.path, RouteEnd::Stop);
            }
            RouteEnd::Open => self.branch(way, &mut each),
        }
    }

    /// Continues along every way until the horizon.
    fn branch(&mut self, way: Way, each: &mut dyn FnMut(&[PathLeg], RouteEnd)) {
        let (start, table) = (self.start, self.table);
        let first = Leg::new(start.motion.edge, start.sign < 0.0);
        let from = self.path.last().map_or(first, |last| last.leg);
        let exits = table.successors(from).take(MAX_FORK + 1);
        let all = exits.clone().count();
        let is_end =
            way.seconds <= 0.0 || self.path.len() >= MAX_LEGS || all == 0 || all > MAX_FORK;
        let legs = exits.filter_map(|leg| path_leg(table, leg));
        let any = legs.clone().any(|leg| start.can_enter(way.metres, leg.speed));
        let mut found = false;
        for next in legs.filter(|leg| !is_end && (!any || start.can_enter(way.metres, leg.speed))) {
            if self.ways_left == 0 {
                break;
            }
            found = true;
            let mut way = Way { top: way.top.max(start.cruise(next.speed)), ..way };
            way.drive(next.length);
            self.path.push(next);
            self.branch(way, each);
            self.path.pop();
        }
        if !found {
            self.ways_left = self.ways_left.saturating_sub(1);
            each(self.path, RouteEnd::Open);
        }
    }
}

fn path_leg(table: &LegTable, leg: Leg) -> Option<PathLeg> {
    table.get(leg).map(|info| PathLeg { leg, length: info.length, speed: info.speed })
}

/// The distance that a robot may have driven.
#[derive(Clone, Copy)]
struct Way {
    /// At least the time that is left until the horizon, in seconds.
    seconds: f32,
    /// The highest speed so far, in metres per second.
    top: f32,
    /// Metres from where the robot is now.
    metres: f32,
}

impl Way {
    fn drive(&mut self, metres: f32) {
        self.seconds -= metres.max(0.0) / self.top;
        self.metres += metres;
    }
}
