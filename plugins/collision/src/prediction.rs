//! Predicted trajectories: each robot continues along its route, or along every way that it may
//! take.
//!
//! A trajectory is a sequence of segments, each driven straight at a constant velocity while the
//! heading turns evenly. Accelerations and curves are cut into segments so short that the robot is
//! never more than a few centimetres off.

mod path;
mod speed_profile;
mod tracer;

use glam::Vec2;

use crate::body::Body;
use crate::heading::heading;
use crate::leg_table::{Leg, LegTable};
pub(crate) use path::RouteEnd;
use path::{PathFinder, PathLeg, Start};
use speed_profile::SpeedProfile;
use tracer::Tracer;

/// The highest speed that is predicted, in metres per second: the highest that an edge may allow.
/// Higher speeds count as this one.
pub const MAX_SPEED: f32 = 50.0;

/// A segment of a trajectory.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Segment {
    /// End of the segment, in seconds from now.
    pub until: f32,
    /// Position at which it starts, in metres.
    pub position: Vec2,
    /// Velocity, in metres per second.
    pub velocity: Vec2,
    /// Unit vector along the heading at its start.
    pub heading: Vec2,
    /// Change of the heading, in radians per second.
    pub turn_rate: f32,
}

impl Segment {
    /// Returns the position at which it ends, given its start in seconds from now.
    pub(crate) fn end(&self, start: f32) -> Vec2 {
        self.position + self.velocity * (self.until - start)
    }

    /// Returns the heading, as a unit vector, so many seconds after its start.
    #[inline]
    pub(crate) fn heading_after(&self, seconds: f32) -> Vec2 {
        if self.turn_rate == 0.0 {
            self.heading
        } else {
            heading(self.turn_rate * seconds).rotate(self.heading)
        }
    }
}

/// The intention of a robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Intent {
    /// To drive its route, as fast as its legs and its type allow.
    Drive,
    /// To brake to a stop, on its route.
    Hold,
    /// To keep its speed.
    Keep,
}

/// The limits of a robot type.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Limits {
    /// Metres per second; infinity for no limit.
    pub max_speed: f32,
    /// Metres per second squared; infinity if the speed changes at once.
    pub max_acceleration: f32,
}

impl Limits {
    pub(crate) const NONE: Self =
        Self { max_speed: f32::INFINITY, max_acceleration: f32::INFINITY };

    /// Creates limits from the values of a world. A value that isn't a positive number means no
    /// limit.
    pub(crate) fn new(max_speed: f32, max_acceleration: f32) -> Self {
        let [max_speed, max_acceleration] = [max_speed, max_acceleration]
            .map(|limit| if limit > 0.0 { limit } else { f32::INFINITY });
        Self { max_speed, max_acceleration }
    }
}

/// The legs after the one that a robot is on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RouteAhead<'routes> {
    /// Whether the robot is in reverse gear, if that is known.
    pub reverse: Option<bool>,
    /// The legs that it drives next, without stopping in between.
    pub legs: &'routes [Leg],
    /// The continuation after them.
    pub end: RouteEnd,
    /// If the robot stops at their end: the metres that it drives of the last leg (without any, of
    /// the one that it is on); infinity for all of it.
    pub limit: f32,
}

/// The motion of a robot.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Motion<'routes> {
    /// Speed along the edge, in metres per second, at most [`MAX_SPEED`]; negative in reverse gear.
    pub speed: f32,
    /// Distance along the edge, in metres.
    pub s: f32,
    /// Index of the edge.
    pub edge: u32,
    pub intent: Intent,
    pub limits: Limits,
    /// The robot's route; without one, it may take any way.
    pub route: Option<RouteAhead<'routes>>,
}

/// A predictor of trajectories, with the memory that it needs.
#[derive(Debug, Default)]
pub(crate) struct Predictor {
    path: Vec<PathLeg>,
    profile: SpeedProfile,
}

impl Predictor {
    /// Predicts a robot from now to the horizon, in seconds. Appends each trajectory, of at least
    /// one segment, to `segments` and calls `finish`: once for a robot whose route is known, else
    /// for each way that it may take.
    ///
    /// An edge only determines the motion from the present pose: a pose beside the edge stays
    /// beside it, and a heading that differs from the edge's keeps its angle to it.
    pub(crate) fn predict(
        &mut self,
        (body, motion): (&Body, &Motion),
        (table, horizon): (&LegTable, f32),
        segments: &mut Vec<Segment>,
        mut finish: impl FnMut(&mut Vec<Segment>),
    ) {
        let (start, profile) = (Start::new(motion, table), &mut self.profile);
        if start.top_speed() == 0.0 {
            Tracer::new(body, start.sign, horizon, segments).stand();
            return finish(segments);
        }
        let Some(rest) = start.rest().filter(|rest| *rest < start.longest_way(horizon)) else {
            let mut tracer = Tracer::new(body, start.sign, horizon, segments);
            profile.drive_on(&start, &mut tracer);
            tracer.stand();
            return finish(segments);
        };
        let mut finder = PathFinder::new(&start, table, &mut self.path);
        finder.find(rest, horizon, |path, end| {
            let mut tracer = Tracer::new(body, start.sign, horizon, &mut *segments);
            profile.drive(&start, rest, (path, end), table, &mut tracer);
            tracer.stand();
            finish(segments);
        });
    }
}

#[cfg(test)]
mod tests;
