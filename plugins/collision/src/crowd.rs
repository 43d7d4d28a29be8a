//! The robots of a frame, as the checks need them.

use std::ops::Range;

use regatta_plugin::frame::{Columns, RobotState};
use regatta_plugin::world::{EdgeRecord, RobotTypeRecord};

use crate::body::{Body, CIRCLE};
use crate::bounds::Bounds;
use crate::footprint::{Footprint, UNKNOWN};
use crate::heading::{MAX_HEADING, heading};
use crate::path::Paths;
use crate::prediction::{Drive, MAX_SPEED, Piece, predict};
use crate::settings::{HYSTERESIS, Settings};

/// Farthest from the origin, east or north, that a robot can be, in metres. Beyond, poses in single precision are
/// coarser than a robot's margin.
pub const MAX_DISTANCE: f32 = 1e6;

/// What robots are and where they drive: the world, as the checks need it.
#[derive(Debug)]
pub(crate) struct Roads {
    paths: Paths,
    /// By type; `None` for one that makes no sense.
    footprints: Vec<Option<Footprint>>,
}

impl Roads {
    pub(crate) fn new(edges: &[EdgeRecord], types: &[RobotTypeRecord]) -> Self {
        let mut footprints: Vec<_> = types.iter().map(Footprint::of).collect();
        if footprints.is_empty() {
            footprints.push(Some(UNKNOWN));
        }
        Self { paths: Paths::new(edges), footprints }
    }

    /// By a value of the column `type`. What is no type there counts as the first.
    fn footprint(&self, kind: f32) -> Option<Footprint> {
        // The conversion takes NaN and what is negative for 0.
        let index = kind as usize;
        self.footprints[if index < self.footprints.len() { index } else { 0 }]
    }
}

/// A robot of a frame, in a strip: a cache line, because a frame's time goes by in moving these.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(crate) struct Mover {
    pub body: Body,
    /// Around all that it may come to in any way that counts.
    pub bounds: Bounds,
    /// Its id.
    pub robot: u32,
    /// The strip.
    pub strip: i32,
    /// Where its pieces start in the strip's list, and how many there are.
    pub first_piece: u32,
    pub pieces: u16,
    /// Whether this is the southernmost strip that it reaches into.
    pub is_first: bool,
}

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

    /// Whether a robot's pose is one.
    fn is_sane(x: f32, y: f32, theta: f32) -> bool {
        (x.abs() <= MAX_DISTANCE) & (y.abs() <= MAX_DISTANCE) & (theta.abs() <= MAX_HEADING)
    }

    /// Takes these robots all at once, which is several times as fast; `false` if one of them isn't there, or is to be
    /// left out, or is not of the only type.
    fn take_all(&self, robots: Range<usize>, chunk: &mut Chunk) -> bool {
        let [Some(footprint)] = self.roads.footprints[..] else { return false };
        let Columns { x, y, theta, speed, state, .. } = self.columns;
        let [x, y, theta, speed] = [x, y, theta, speed].map(|column| &column[robots.clone()]);
        let there = state[robots.clone()].iter().fold(true, |all, state| all & (*state <= RobotState::Faulted as u8));
        let poses = x.iter().zip(y).zip(theta);
        if !there || !poses.fold(true, |all, ((x, y), theta)| all & Self::is_sane(*x, *y, *theta)) {
            return false;
        }
        chunk.len = robots.len();
        chunk.x[..robots.len()].copy_from_slice(x);
        chunk.y[..robots.len()].copy_from_slice(y);
        chunk.theta[..robots.len()].copy_from_slice(theta);
        chunk.speed.iter_mut().zip(speed).for_each(|(here, speed)| *here = sane(*speed));
        chunk.robot.iter_mut().zip(robots).for_each(|(here, robot)| *here = robot as u32);
        let (half_length, half_width) = halves(footprint);
        chunk.half_length.fill(half_length);
        chunk.half_width.fill(half_width);
        true
    }

    /// Takes robots one by one. Returns how many were left out.
    fn pick(&self, robots: impl Iterator<Item = usize>, chunk: &mut Chunk) -> usize {
        chunk.len = 0;
        let columns = &self.columns;
        let mut unplaced = 0;
        for robot in robots.filter(|&robot| columns.state[robot] <= RobotState::Faulted as u8) {
            let (x, y, theta, number) = (columns.x[robot], columns.y[robot], columns.theta[robot], chunk.len);
            let footprint = self.roads.footprint(self.types.get(robot).copied().unwrap_or(0.0));
            let Some(footprint) = footprint.filter(|_| Self::is_sane(x, y, theta)) else {
                unplaced += 1;
                continue;
            };
            (chunk.half_length[number], chunk.half_width[number]) = halves(footprint);
            (chunk.robot[number], chunk.x[number], chunk.y[number]) = (robot as u32, x, y);
            (chunk.theta[number], chunk.speed[number]) = (theta, sane(columns.speed[robot]));
            chunk.len += 1;
        }
        unplaced
    }

    /// Works out the rest of a chunk.
    fn finish(&self, chunk: &mut Chunk) {
        chunk.turn();
        chunk.bound(0.5 * (self.settings.margin() + HYSTERESIS as f32));
        chunk.pack();
        chunk.pieces.clear();
        if self.settings.horizon() > 0.0 {
            self.predict(chunk);
        }
    }

    /// Adds a chunk's robots' pieces, and to their bounds where they will be.
    fn predict(&self, chunk: &mut Chunk) {
        for number in 0..chunk.len {
            let robot = chunk.robot[number] as usize;
            let is_held = self.columns.state[robot] == RobotState::Held as u8;
            let speed = if is_held { 0.0 } else { chunk.speed[number] };
            let chords = self.roads.paths.of(self.columns.edge[robot]);
            let (body, first) = (chunk.movers[number].body, chunk.pieces.len());
            predict(
                &body,
                Drive { speed, s: self.columns.s[robot], chords },
                self.settings.horizon(),
                &mut chunk.pieces,
            );
            let mover = &mut chunk.movers[number];
            mover.bounds = swept(&body, &chunk.pieces[first..], mover.bounds);
            (mover.first_piece, mover.pieces) = (first as u32, (chunk.pieces.len() - first) as u16);
        }
    }
}

/// What a robot is taken to do at a published speed.
fn sane(speed: f32) -> f32 {
    if speed.is_nan() { 0.0 } else { speed.clamp(-MAX_SPEED, MAX_SPEED) }
}

/// Half of the length, or the radius, and half of the width, or [`CIRCLE`].
fn halves(footprint: Footprint) -> (f32, f32) {
    match footprint {
        Footprint::Rectangle(half_length, half_width) => (half_length, half_width),
        Footprint::Circle(radius) => (radius, CIRCLE),
    }
}

/// Bounds that take in where the robot will be.
fn swept(body: &Body, pieces: &[Piece], bounds: Bounds) -> Bounds {
    let end = |piece: &Piece, from: f32| {
        let time = piece.until - from;
        [piece.place[0] + piece.velocity[0] * time, piece.place[1] + piece.velocity[1] * time]
    };
    // One that only drives straight on keeps its heading. One that doesn't may turn any side to the outside.
    let (way, half) = match pieces {
        [only] => (around(only.place, end(only, 0.0)), body.half_extent(body.heading)),
        _ => {
            let joints = pieces.iter().fold(Bounds::NOTHING, |all, piece| all.join(around(piece.place, piece.place)));
            let from = pieces.len().checked_sub(2).map_or(0.0, |before| pieces[before].until);
            let end = pieces.last().map_or(body.place, |last| end(last, from));
            (joints.join(around(end, end)), [body.radius(); 2])
        }
    };
    let pad = HYSTERESIS as f32 + slack(way.west()) + slack(way.east()) + slack(way.south()) + slack(way.north());
    let ([west, south], [east, north]) = ([way.west(), way.south()], [way.east(), way.north()]);
    let (x, y) = (half[0] + pad, half[1] + pad);
    bounds.join(Bounds::new([west - x, south - y], [east + x, north + y]))
}

fn around(a: [f32; 2], b: [f32; 2]) -> Bounds {
    Bounds::new([a[0].min(b[0]), a[1].min(b[1])], [a[0].max(b[0]), a[1].max(b[1])])
}

/// As much as rounding may hide at that distance from the origin, in metres.
fn slack(distance: f32) -> f32 {
    1e-5 + distance.abs() * 1e-6
}

/// Some robots of a frame, by columns: so that the compiler works on several at once.
#[derive(Debug)]
pub(crate) struct Chunk {
    len: usize,
    robot: Column<u32>,
    x: Column<f32>,
    y: Column<f32>,
    theta: Column<f32>,
    speed: Column<f32>,
    half_length: Column<f32>,
    half_width: Column<f32>,
    cos: Column<f32>,
    sin: Column<f32>,
    west: Column<f32>,
    south: Column<f32>,
    east: Column<f32>,
    north: Column<f32>,
    movers: Column<Mover>,
    /// Those of all of them through the horizon, if there is one.
    pieces: Vec<Piece>,
}

type Column<T> = [T; Chunk::ROBOTS];

/// Before there is anybody.
const NOBODY: Mover = Mover {
    body: Body { place: [0.0; 2], heading: [0.0; 2], half_length: 0.0, half_width: 0.0, velocity: [0.0; 2] },
    bounds: Bounds::NOTHING,
    robot: 0,
    strip: 0,
    first_piece: 0,
    pieces: 0,
    is_first: false,
};

impl Default for Chunk {
    fn default() -> Self {
        let column = [0.0; Self::ROBOTS];
        Self {
            len: 0,
            robot: [0; Self::ROBOTS],
            x: column,
            y: column,
            theta: column,
            speed: column,
            half_length: column,
            half_width: column,
            cos: column,
            sin: column,
            west: column,
            south: column,
            east: column,
            north: column,
            movers: [NOBODY; Self::ROBOTS],
            pieces: Vec::new(),
        }
    }
}

impl Chunk {
    /// Most robots: as many as stay in the first-level cache.
    pub(crate) const ROBOTS: usize = 256;

    /// Works out headings. (Those beyond the last robot are left over, and worked out as well: so their number is
    /// known to the compiler.)
    fn turn(&mut self) {
        for ((theta, cos), sin) in self.theta.iter().zip(&mut self.cos).zip(&mut self.sin) {
            [*cos, *sin] = heading(*theta);
        }
    }

    /// Works out bounds of what robots cover now, and some metres more.
    fn bound(&mut self, pad: f32) {
        for number in 0..Self::ROBOTS {
            let (length, width) = (self.half_length[number], self.half_width[number]);
            let (cos, sin) = (self.cos[number].abs(), self.sin[number].abs());
            let is_circle = width == CIRCLE;
            let reach_x = if is_circle { length } else { length * cos + width * sin };
            let reach_y = if is_circle { length } else { length * sin + width * cos };
            let (x, y) = (self.x[number], self.y[number]);
            let (pad_x, pad_y) = (reach_x + (pad + slack(x)), reach_y + (pad + slack(y)));
            (self.west[number], self.east[number]) = (x - pad_x, x + pad_x);
            (self.south[number], self.north[number]) = (y - pad_y, y + pad_y);
        }
    }

    /// Puts robots together from their columns: each value straight to its place, as a robot that is first put together
    /// elsewhere and then copied would wait for that.
    fn pack(&mut self) {
        for number in 0..Self::ROBOTS {
            let mover = &mut self.movers[number];
            let (cos, sin, speed) = (self.cos[number], self.sin[number], self.speed[number]);
            mover.body.place = [self.x[number], self.y[number]];
            mover.body.heading = [cos, sin];
            mover.body.half_length = self.half_length[number];
            mover.body.half_width = self.half_width[number];
            mover.body.velocity = [cos * speed, sin * speed];
            mover.bounds =
                Bounds::new([self.west[number], self.south[number]], [self.east[number], self.north[number]]);
            mover.robot = self.robot[number];
            (mover.first_piece, mover.pieces) = (0, 0);
        }
    }

    /// Around all robots.
    pub(crate) fn bounds(&self) -> Bounds {
        self.movers().iter().fold(Bounds::NOTHING, |all, mover| all.join(mover.bounds))
    }

    /// The robots; their pieces are in [`pieces_of`](Self::pieces_of).
    pub(crate) fn movers(&self) -> &[Mover] {
        &self.movers[..self.len]
    }

    pub(crate) fn pieces_of(&self, mover: &Mover) -> &[Piece] {
        let first = mover.first_piece as usize;
        &self.pieces[first..first + usize::from(mover.pieces)]
    }
}
