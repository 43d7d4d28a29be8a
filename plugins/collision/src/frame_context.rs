//! The input of the checks: a frame with the world and the settings.

use std::ops::Range;

use glam::Vec2;
use regatta_plugin::World;
use regatta_plugin::frame::{Columns, RobotState};
use regatta_plugin::world::Levels;

use crate::body::Footprint;
use crate::chunk::Chunk;
use crate::criteria::{HYSTERESIS, Settings};
use crate::heading::MAX_HEADING;
use crate::leg_table::LegTable;
use crate::prediction::{Intent, Limits, MAX_SPEED, Motion};
use crate::routes::Routes;
use crate::strip_index::PackedRobot;

/// The largest distance from the origin, east or north, of a valid pose, in metres. Beyond it,
/// poses in single precision are coarser than a robot's margin.
pub const MAX_DISTANCE: f32 = 1e6;

/// The edges that robots drive on, and the footprints and limits of their types.
#[derive(Debug)]
pub(crate) struct WorldModel {
    legs: LegTable,
    levels: Levels,
    /// Footprints by robot type; at least one.
    footprints: Vec<Footprint>,
    /// Limits by robot type.
    limits: Vec<Limits>,
}

impl WorldModel {
    pub(crate) fn new(world: &World<'_>) -> Self {
        let robot_types = world.robot_types();
        let mut footprints: Vec<_> = robot_types.iter().map(Footprint::of).collect();
        if footprints.is_empty() {
            footprints.push(Footprint::UNKNOWN);
        }
        let limits = robot_types
            .iter()
            .map(|robot_type| Limits::new(robot_type.max_speed, robot_type.max_acceleration))
            .collect();
        Self { legs: LegTable::new(world), levels: Levels::new(world), footprints, limits }
    }

    pub(crate) fn legs(&self) -> &LegTable {
        &self.legs
    }

    /// Returns the limits of a robot type: none if there is no such type.
    pub(crate) fn limits(&self, robot_type: u32) -> Limits {
        self.limits.get(robot_type as usize).copied().unwrap_or(Limits::NONE)
    }

    /// Returns the footprints by robot type; at least one.
    pub(crate) fn footprints(&self) -> &[Footprint] {
        &self.footprints
    }

    /// Returns the robot type of a value of the column `type`; the first type if the value isn't a
    /// valid index.
    pub(crate) fn robot_type(&self, value: f32) -> u32 {
        // The conversion maps NaN and negative values to 0.
        let robot_type = value as u32;
        if (robot_type as usize) < self.footprints.len() { robot_type } else { 0 }
    }
}

/// A frame with everything that the checks need to interpret it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FrameContext<'frame> {
    pub columns: Columns<'frame>,
    /// The column `type`; robots beyond its end are of the first type.
    pub robot_types: &'frame [f32],
    pub world: &'frame WorldModel,
    pub settings: Settings,
    pub routes: &'frame Routes,
}

impl FrameContext<'_> {
    /// Fills a chunk with a range of robots. Returns the number of robots that are present but left
    /// out, because their pose or their type's footprint is invalid.
    pub(crate) fn fill(&self, robots: Range<usize>, chunk: &mut Chunk) -> usize {
        let invalid_robots =
            if self.fill_all(robots.clone(), chunk) { 0 } else { self.fill_valid(robots, chunk) };
        self.finish(chunk);
        invalid_robots
    }

    /// Fills a chunk with a pseudo-random sample of the robots, the same in each call.
    pub(crate) fn sample(&self, chunk: &mut Chunk) {
        let robots = self.columns.x.len();
        let numbers = 0..Chunk::ROBOTS.min(robots);
        self.fill_valid(
            numbers.map(|number| number.wrapping_mul(0x9E37_79B9_7F4A_7C15) % robots),
            chunk,
        );
        self.finish(chunk);
    }

    /// Returns the padding around each footprint, in metres: half of the largest distance of two
    /// robots that have a level.
    pub(crate) fn padding(&self) -> f32 {
        0.5 * (self.settings.margin() + HYSTERESIS as f32)
    }

    /// Whether a pose can be checked.
    fn is_valid_pose(x: f32, y: f32, theta: f32) -> bool {
        (x.abs() <= MAX_DISTANCE) & (y.abs() <= MAX_DISTANCE) & (theta.abs() <= MAX_HEADING)
    }

    /// Fills a chunk with a whole range of robots at once, which is several times as fast as one by
    /// one. Returns `false` if one of them is absent or invalid.
    fn fill_all(&self, robots: Range<usize>, chunk: &mut Chunk) -> bool {
        let Columns { x, y, theta, speed, state, .. } = self.columns;
        let [x, y, theta, speed] = [x, y, theta, speed].map(|column| &column[robots.clone()]);
        let present =
            state[robots.clone()].iter().fold(true, |all, state| all & is_present(*state));
        let poses = x.iter().zip(y).zip(theta);
        let valid =
            poses.fold(present, |all, ((x, y), theta)| all & Self::is_valid_pose(*x, *y, *theta));
        if !valid || !self.fill_types(robots.clone(), chunk) {
            return false;
        }
        chunk.len = robots.len();
        chunk.x[..robots.len()].copy_from_slice(x);
        chunk.y[..robots.len()].copy_from_slice(y);
        chunk.theta[..robots.len()].copy_from_slice(theta);
        for (here, speed) in chunk.speed.iter_mut().zip(speed) {
            *here = assumed_speed(*speed);
        }
        for (here, robot) in chunk.id.iter_mut().zip(robots) {
            *here = robot as u32;
        }
        true
    }

    /// Fills in the robot types. Returns `false` if one is invalid.
    fn fill_types(&self, robots: Range<usize>, chunk: &mut Chunk) -> bool {
        let footprints = self.world.footprints();
        if let [only] = footprints {
            chunk.robot_type.fill(0);
            return only.is_valid();
        }
        let Some(types) = self.robot_types.get(robots) else { return false };
        let entries = chunk.robot_type.iter_mut().zip(types);
        entries.fold(true, |all, (robot_type, value)| {
            *robot_type = self.world.robot_type(*value);
            all & footprints[*robot_type as usize].is_valid()
        })
    }

    /// Fills a chunk with the valid ones of these robots, one by one. Returns the number of invalid
    /// robots.
    fn fill_valid(&self, robots: impl Iterator<Item = usize>, chunk: &mut Chunk) -> usize {
        chunk.len = 0;
        let columns = &self.columns;
        let mut invalid_robots = 0;
        for robot in robots.filter(|&robot| is_present(columns.state[robot])) {
            let (x, y, theta, number) =
                (columns.x[robot], columns.y[robot], columns.theta[robot], chunk.len);
            let robot_type =
                self.world.robot_type(self.robot_types.get(robot).copied().unwrap_or(0.0));
            if !self.world.footprints()[robot_type as usize].is_valid()
                || !Self::is_valid_pose(x, y, theta)
            {
                invalid_robots += 1;
                continue;
            }
            chunk.robot_type[number] = robot_type;
            (chunk.id[number], chunk.x[number], chunk.y[number]) = (robot as u32, x, y);
            (chunk.theta[number], chunk.speed[number]) =
                (theta, assumed_speed(columns.speed[robot]));
            chunk.len += 1;
        }
        invalid_robots
    }

    /// Computes headings, bounds and trajectories of a filled chunk.
    fn finish(&self, chunk: &mut Chunk) {
        chunk.finish(self.world.footprints(), self.padding());
        let horizon = self.settings.horizon();
        if horizon > 0.0 {
            chunk.predict(self.world.legs(), horizon, |number, chunk| self.motion(number, chunk));
        }
    }

    /// Whether two robots aren't on different levels.
    pub(crate) fn may_meet(&self, a: &PackedRobot, b: &PackedRobot) -> bool {
        let levels = &self.world.levels;
        if !levels.are_several() {
            return true;
        }
        let Columns { edge, s, .. } = self.columns;
        let [a, b] = [a, b].map(|robot| robot.id as usize);
        let [a, b] = [a, b].map(|row| levels.of_robot(edge[row], s[row]));
        a.may_meet(b)
    }

    /// Returns the velocity of a robot, east and north, in metres per second.
    pub(crate) fn velocity(&self, robot: &PackedRobot) -> Vec2 {
        let legs = self.world.legs();
        if legs.are_tangential() {
            // The columns are far from the robots of a strip in memory.
            return robot.heading * robot.speed;
        }
        let (row, Columns { edge, s, .. }) = (robot.id as usize, self.columns);
        legs.direction(edge[row], s[row], robot.heading) * robot.speed
    }

    /// Returns the motion of a chunk's robot.
    fn motion(&self, number: usize, chunk: &Chunk) -> Motion<'_> {
        let (robot, Columns { s, edge, state, .. }) = (chunk.id[number], self.columns);
        let row = robot as usize;
        Motion {
            speed: chunk.speed[number],
            s: s[row],
            edge: edge[row],
            intent: match RobotState::from_number(state[row]) {
                RobotState::Driving => Intent::Drive,
                RobotState::Held | RobotState::Stalled | RobotState::Broken => Intent::Hold,
                // A robot that turns stands. Its direction isn't determined before it has the new
                // heading.
                _ => Intent::Keep,
            },
            limits: self.world.limits(chunk.robot_type[number]),
            route: self.routes.ahead(robot, edge[row]),
        }
    }
}

/// Whether a row in this state has a robot.
fn is_present(state: u8) -> bool {
    usize::from(state) < RobotState::COUNT
}

/// Returns the speed that a robot is assumed to have, in metres per second, given its published
/// speed.
fn assumed_speed(speed: f32) -> f32 {
    if speed.is_nan() { 0.0 } else { speed.clamp(-MAX_SPEED, MAX_SPEED) }
}
