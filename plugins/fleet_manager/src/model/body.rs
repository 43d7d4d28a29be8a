//! A robot as the engine would move it.

use glam::Vec2;
use regatta_base::sweep::{Footprint, Rectangle, angle_between};
use regatta_plugin::World;
use regatta_plugin::world::EdgeRecord;

use super::{Command, Leg, Roads, Seen, TICK_SECS, seen};

/// Points on each curve.
const POINTS: u32 = 64;
/// Radians that a robot turns on the spot in a tick.
const TURN: f32 = 0.1;

/// The outline of robots everywhere.
pub(super) struct Outlines {
    /// By edge: arc length, position and heading along it.
    lines: Vec<Vec<(f32, Vec2, f32)>>,
    footprint: Footprint,
}

impl Outlines {
    pub(super) fn new(world: &World<'_>) -> Self {
        let first = &world.robot_types()[0];
        Self {
            lines: world.edges().iter().map(|edge| line(world, edge)).collect(),
            footprint: Footprint::rectangle(first.length, first.width),
        }
    }

    /// The outline of a robot on a leg, at a distance from where it is entered.
    pub(super) fn at(&self, leg: Leg, place: f32) -> Rectangle {
        let (centre, heading) = self.pose(leg, place);
        self.footprint.at(centre, Vec2::from_angle(heading))
    }

    fn pose(&self, leg: Leg, place: f32) -> (Vec2, f32) {
        let line = &self.lines[leg.edge() as usize];
        let s = if leg.is_reverse() { line[line.len() - 1].0 - place } else { place };
        let index = line.partition_point(|point| point.0 < s).clamp(1, line.len() - 1);
        let (a, b) = (line[index - 1], line[index]);
        let share = if b.0 > a.0 { ((s - a.0) / (b.0 - a.0)).clamp(0.0, 1.0) } else { 0.0 };
        let turn =
            (b.2 - a.2 + 9.424_778).rem_euclid(core::f32::consts::TAU) - core::f32::consts::PI;
        (a.1 + share * (b.1 - a.1), a.2 + share * turn)
    }
}

fn line(world: &World<'_>, edge: &EdgeRecord) -> Vec<(f32, Vec2, f32)> {
    let mut points: Vec<(f32, Vec2, f32)> = Vec::new();
    for curve in world.curves(edge) {
        let p = curve.control_points.map(Vec2::from);
        for part in 0..=POINTS {
            let t = part as f32 / POINTS as f32;
            let u = 1.0 - t;
            let at = u * u * u * p[0]
                + 3.0 * u * u * t * p[1]
                + 3.0 * u * t * t * p[2]
                + t * t * t * p[3];
            let along = u * u * (p[1] - p[0]) + 2.0 * u * t * (p[2] - p[1]) + t * t * (p[3] - p[2]);
            let step = points.last().map_or(0.0, |last| last.1.distance(at));
            let s = points.last().map_or(0.0, |last| last.0) + step;
            points.push((s, at, edge.orientation().heading(along.y.atan2(along.x))));
        }
    }
    points
}

/// A robot.
#[derive(Debug)]
pub(super) struct Body {
    leg: Leg,
    place: f32,
    speed: f32,
    heading: f32,
    legs: Vec<Leg>,
    /// The leg on which its base ends, counted from the one that it is on, and where on it.
    limit: (usize, f32),
    /// Ticks for which it doesn't move.
    pub(super) stalled: u32,
}

impl Body {
    pub(super) fn new(outlines: &Outlines, leg: Leg, place: f32) -> Self {
        let heading = outlines.pose(leg, place).1;
        Self { leg, place, speed: 0.0, heading, legs: vec![], limit: (0, place), stalled: 0 }
    }

    /// Drives for a tick at a share of the speed of the edge, up to the end of the base. Turns on
    /// the spot take whole ticks; the heading of a robot that doesn't turn jumps.
    pub(super) fn drive(&mut self, outlines: &Outlines, roads: &Roads, share: f32) {
        self.speed = 0.0;
        if self.stalled > 0 {
            self.stalled -= 1;
            return;
        }
        let mut left = TICK_SECS;
        while left > 1e-4 {
            let length = roads.edge(self.leg.edge()).length;
            let is_last = self.limit.0 == 0;
            let end = if is_last { self.limit.1.min(length) } else { length };
            let speed = share * roads.speed(&roads.classes()[0], self.leg);
            if self.place < end {
                let way = (speed * left).min(end - self.place);
                (self.speed, self.place) =
                    (speed, if way < speed * left { end } else { self.place + way });
                left -= way / speed;
                self.heading = outlines.pose(self.leg, self.place).1;
            } else if !is_last && let Some(&next) = self.legs.first() {
                let wanted = roads.headings(next)[0];
                if roads.classes()[0].turns && angle_between(wanted, self.heading) > TURN + 0.01 {
                    let turn =
                        (wanted - self.heading + 9.424_778).rem_euclid(core::f32::consts::TAU);
                    self.heading += (turn - core::f32::consts::PI).signum() * TURN;
                    return;
                }
                self.heading = wanted;
                self.legs.remove(0);
                (self.leg, self.place) = (next, 0.0);
                self.limit.0 -= 1;
            } else {
                self.speed = 0.0;
                return;
            }
        }
    }

    pub(super) fn outline(&self, outlines: &Outlines) -> Rectangle {
        let heading = Vec2::from_angle(self.heading);
        Rectangle { heading, ..outlines.at(self.leg, self.place) }
    }

    pub(super) fn seen(&self, outlines: &Outlines, roads: &Roads) -> Seen {
        let length = roads.edge(self.leg.edge()).length;
        let s = if self.leg.is_reverse() { length - self.place } else { self.place };
        seen(self.leg.edge(), s, self.speed, outlines.at(self.leg, self.place).centre)
    }

    pub(super) fn obey(&mut self, command: &Command, roads: &Roads) {
        match command {
            Command::Route { legs, .. } => {
                self.legs.truncate(self.limit.0);
                self.legs.extend(legs);
            }
            Command::Release { leg, metres, .. } => {
                let ahead =
                    [self.leg].into_iter().chain(self.legs.iter().copied()).skip(self.limit.0);
                let further = ahead.take_while(|next| next != leg).count();
                assert!(
                    self.limit.0 + further <= self.legs.len(),
                    "{leg:?} is not ahead of {self:?}"
                );
                let length = roads.edge(leg.edge()).length;
                assert!(
                    *metres > length || *metres < length - 1e-3,
                    "{metres} m of {length} m count as the whole leg"
                );
                self.limit = (self.limit.0 + further, *metres);
            }
            Command::Cancel { .. } => {}
        }
    }
}
