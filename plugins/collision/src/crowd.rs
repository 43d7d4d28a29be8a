//! The robots of a frame, as the checks need them.

use std::ops::Range;

use regatta_plugin::frame::{Columns, RobotState};

use crate::chunk::Chunk;
use crate::heading::MAX_HEADING;
use crate::prediction::{Drive, MAX_SPEED, predict};
use crate::roads::Roads;
use crate::settings::{HYSTERESIS, Settings};

/// Farthest from the origin, east or north, that a robot can be, in metres. Beyond, poses in single precision are
/// coarser than a robot's margin.
pub const MAX_DISTANCE: f32 = 1e6;

/// A frame, and what it takes to make sense of it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Crowd<'frame> {
    pub columns: Columns<'frame>,
    /// The column `type`; robots beyond its end are of the first type.
    pub types: &'frame [f32],
    pub roads: &'frame Roads,
    pub settings: Settings,
}

impl Crowd<'_> {
    /// Fills a chunk with these robots. Returns how many were left out though they are there, because their pose or
    /// their type's footprint is none.
    pub(crate) fn take(&self, robots: Range<usize>, chunk: &mut Chunk) -> usize {
        let unplaced = if self.take_all(robots.clone(), chunk) { 0 } else { self.pick(robots, chunk) };
        self.finish(chunk);
        unplaced
    }

    /// Fills a chunk with some robots, as if picked at random, but always the same.
    pub(crate) fn sample(&self, chunk: &mut Chunk) {
        let robots = self.columns.x.len();
        let picked = 0..Chunk::ROBOTS.min(robots);
        self.pick(picked.map(|number| number.wrapping_mul(0x9E37_79B9_7F4A_7C15) % robots), chunk);
        self.finish(chunk);
    }

    /// Metres around each footprint in which others are looked for: half of how far apart two may be that have a level.
    pub(crate) fn pad(&self) -> f32 {
        0.5 * (self.settings.margin() + HYSTERESIS as f32)
    }

    /// Whether a robot's pose is one.
    fn is_sane(x: f32, y: f32, theta: f32) -> bool {
        (x.abs() <= MAX_DISTANCE) & (y.abs() <= MAX_DISTANCE) & (theta.abs() <= MAX_HEADING)
    }

    /// Takes these robots all at once, which is several times as fast; `false` if one of them isn't there, or is to be
    /// left out.
    fn take_all(&self, robots: Range<usize>, chunk: &mut Chunk) -> bool {
        let Columns { x, y, theta, speed, state, .. } = self.columns;
        let [x, y, theta, speed] = [x, y, theta, speed].map(|column| &column[robots.clone()]);
        let there = state[robots.clone()].iter().fold(true, |all, state| all & (*state <= RobotState::Faulted as u8));
        let poses = x.iter().zip(y).zip(theta);
        let fit = poses.fold(there, |all, ((x, y), theta)| all & Self::is_sane(*x, *y, *theta));
        if !fit || !self.take_kinds(robots.clone(), chunk) {
            return false;
        }
        chunk.len = robots.len();
        chunk.x[..robots.len()].copy_from_slice(x);
        chunk.y[..robots.len()].copy_from_slice(y);
        chunk.theta[..robots.len()].copy_from_slice(theta);
        chunk.speed.iter_mut().zip(speed).for_each(|(here, speed)| *here = sane(*speed));
        chunk.robot.iter_mut().zip(robots).for_each(|(here, robot)| *here = robot as u32);
        true
    }

    /// Takes their types; `false` if one makes no sense.
    fn take_kinds(&self, robots: Range<usize>, chunk: &mut Chunk) -> bool {
        let footprints = self.roads.footprints();
        if let [only] = footprints {
            chunk.kind.fill(0);
            return only.is_sane();
        }
        let Some(types) = self.types.get(robots) else { return false };
        let kinds = chunk.kind.iter_mut().zip(types);
        kinds.fold(true, |all, (kind, value)| {
            *kind = self.roads.kind(*value);
            all & footprints[*kind as usize].is_sane()
        })
    }

    /// Takes robots one by one. Returns how many were left out.
    fn pick(&self, robots: impl Iterator<Item = usize>, chunk: &mut Chunk) -> usize {
        chunk.len = 0;
        let columns = &self.columns;
        let mut unplaced = 0;
        for robot in robots.filter(|&robot| columns.state[robot] <= RobotState::Faulted as u8) {
            let (x, y, theta, number) = (columns.x[robot], columns.y[robot], columns.theta[robot], chunk.len);
            let kind = self.roads.kind(self.types.get(robot).copied().unwrap_or(0.0));
            if !self.roads.footprints()[kind as usize].is_sane() || !Self::is_sane(x, y, theta) {
                unplaced += 1;
                continue;
            }
            chunk.kind[number] = kind;
            (chunk.robot[number], chunk.x[number], chunk.y[number]) = (robot as u32, x, y);
            (chunk.theta[number], chunk.speed[number]) = (theta, sane(columns.speed[robot]));
            chunk.len += 1;
        }
        unplaced
    }

    /// Works out the rest of a chunk.
    fn finish(&self, chunk: &mut Chunk) {
        chunk.finish(self.roads.footprints(), self.pad());
        let horizon = self.settings.horizon();
        let ways = if horizon > 0.0 { chunk.len } else { 0 };
        for number in 0..ways {
            let robot = chunk.robot[number] as usize;
            let is_held = self.columns.state[robot] == RobotState::Held as u8;
            let speed = if is_held { 0.0 } else { chunk.speed[number] };
            let drive = Drive { speed, s: self.columns.s[robot], chords: self.roads.chords(self.columns.edge[robot]) };
            chunk.add_way(|body, pieces| predict(body, drive, horizon, pieces));
        }
    }
}

/// What a robot is taken to do at a published speed.
fn sane(speed: f32) -> f32 {
    if speed.is_nan() { 0.0 } else { speed.clamp(-MAX_SPEED, MAX_SPEED) }
}
