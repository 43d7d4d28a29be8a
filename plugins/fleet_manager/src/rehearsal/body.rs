//! A robot of the model.

use glam::Vec2;
use regatta_base::sweep::angle_between;
use regatta_plugin::frame::NO_EDGE;

use crate::roads::{Leg, Roads, RobotClass, SMOOTH};
use crate::steering::Command;

/// Radians per second of a turn on the spot.
const TURN_SPEED: f32 = 1.0;

/// A robot that stands or drives on a leg.
#[derive(Clone, Debug)]
pub(super) struct Body {
    class: RobotClass,
    leg: Leg,
    /// Metres from the start of the leg.
    place: f32,
    /// Metres per second.
    speed: f32,
    /// The next legs.
    legs: Vec<Leg>,
    /// The leg on which its base ends, counted from the one that it is on, and the metres on it.
    limit: (usize, f32),
    /// Seconds that a turn on the spot still takes.
    turning_secs: f32,
    /// Whether it stands on the node where the leg begins, and has no route yet.
    is_on_node: bool,
}

/// The place of a robot as a frame shows it.
#[derive(Default)]
pub(super) struct Pose {
    pub edge: u32,
    pub s: f32,
    pub speed: f32,
    pub position: Vec2,
}

impl Body {
    /// Puts a robot on a leg.
    pub fn on_leg(leg: Leg, place: f32, class: RobotClass) -> Self {
        let limit = (0, place);
        let (speed, legs, turning_secs, is_on_node) = (0.0, Vec::new(), 0.0, false);
        Self { class, leg, place, speed, legs, limit, turning_secs, is_on_node }
    }

    /// Puts a robot on a node, as the manager takes over those that are on no edge: at the end of
    /// an edge that leads there, or else at the start of one that leaves it. `None` if there is no
    /// edge.
    pub fn on_node(node: u32, roads: &Roads, class: RobotClass) -> Option<Self> {
        if let Some(leg) = roads.arrival(node) {
            return Some(Self::on_leg(leg, roads.edge(leg.edge()).length, class));
        }
        let leg = *roads.exits(node).first()?;
        Some(Self { is_on_node: true, ..Self::on_leg(leg, 0.0, class) })
    }

    /// The robot in a frame. A manager needs positions only of robots that are on no edge.
    pub fn pose(&self, roads: &Roads) -> Pose {
        let length = roads.edge(self.leg.edge()).length;
        let s = if self.leg.is_reverse() { length - self.place } else { self.place };
        let edge = if self.is_on_node { NO_EDGE } else { self.leg.edge() };
        Pose { edge, s, speed: self.speed, position: roads.position(roads.start(self.leg)) }
    }

    /// Metres per second; above 0 while it turns on the spot, too.
    pub fn speed(&self) -> f32 {
        if self.turning_secs > 0.0 { TURN_SPEED } else { self.speed }
    }

    /// Takes a command. A release of a leg that isn't ahead is ignored.
    pub fn obey(&mut self, command: &Command, roads: &Roads) {
        match command {
            Command::Route { legs, .. } => {
                self.legs.truncate(self.limit.0);
                // The route of a robot on a node begins with the leg that leaves it.
                self.legs.extend(legs.iter().skip(usize::from(self.is_on_node)));
                self.is_on_node = false;
            }
            Command::Release { leg, metres, .. } => {
                let ahead = std::iter::once(&self.leg).chain(&self.legs).skip(self.limit.0);
                let further = ahead.take_while(|next| *next != leg).count();
                if self.limit.0 + further <= self.legs.len() {
                    let length = roads.edge(leg.edge()).length;
                    self.limit = (self.limit.0 + further, metres.min(length));
                }
            }
            Command::Cancel { .. } => {}
        }
    }

    /// Drives up to the end of the base, for some seconds at most.
    pub fn drive(&mut self, roads: &Roads, secs: f32) {
        let mut left_secs = secs;
        while left_secs > 1e-4 {
            let turn_secs = self.turning_secs.min(left_secs);
            self.turning_secs -= turn_secs;
            left_secs -= turn_secs;
            let length = roads.edge(self.leg.edge()).length;
            let end = if self.limit.0 == 0 { self.limit.1.min(length) } else { length };
            if self.place < end {
                left_secs = self.advance(roads, end, left_secs);
            } else if self.limit.0 > 0 && !self.legs.is_empty() {
                self.enter_next(roads);
            } else {
                self.speed = 0.0;
                return;
            }
        }
    }

    /// Drives up to a place on the leg; returns the seconds that are left.
    fn advance(&mut self, roads: &Roads, end: f32, secs: f32) -> f32 {
        let acceleration = self.class.max_acceleration;
        let limit = roads.speed(&self.class, self.leg);
        let reached = self.speed + acceleration * secs;
        let braking = (2.0 * acceleration * self.way_to_limit(roads)).sqrt();
        self.speed = limit.min(reached).min(braking).max(0.05);
        let way = self.speed * secs;
        if self.place + way < end {
            self.place += way;
            return 0.0;
        }
        let left_secs = secs - (end - self.place) / self.speed;
        self.place = end;
        left_secs
    }

    /// The metres to the end of the base.
    fn way_to_limit(&self, roads: &Roads) -> f32 {
        let (legs, last) = self.limit;
        let on_last = if legs == 0 { last - self.place } else { last };
        let whole = std::iter::once(&self.leg).chain(&self.legs).take(legs);
        let lengths: f32 = whole.map(|leg| roads.edge(leg.edge()).length).sum();
        let driven = if legs == 0 { 0.0 } else { self.place };
        (lengths + on_last - driven).max(0.0)
    }

    fn enter_next(&mut self, roads: &Roads) {
        let next = self.legs.remove(0);
        let angle = angle_between(roads.headings(self.leg)[1], roads.headings(next)[0]);
        if angle > SMOOTH && self.class.turns {
            self.turning_secs = angle / TURN_SPEED;
            self.speed = 0.0;
        }
        (self.leg, self.place) = (next, 0.0);
        self.limit.0 -= 1;
    }
}
