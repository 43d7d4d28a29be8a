//! All robots of a frame, as the checks need them.

use regatta_plugin::frame::{Columns, RobotState};
use regatta_plugin::world::{EdgeRecord, RobotTypeRecord};

use crate::body::{Body, Outline};
use crate::footprint::{Footprint, UNKNOWN};
use crate::heading::{MAX_HEADING, cos_sin};
use crate::meeting::Way;
use crate::path::Paths;
use crate::prediction::{Drive, MAX_SPEED, Piece, predict};
use crate::settings::{HYSTERESIS, Settings};
use crate::strips::Bounds;

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

/// All robots of a frame. Kept from frame to frame for its memory.
#[derive(Debug, Default)]
pub(crate) struct Crowd {
    bodies: Vec<Body>,
    /// What a robot may come to in any way that counts.
    boxes: Vec<Bounds>,
    pieces: Vec<Piece>,
    /// Where each robot's pieces end.
    ends: Vec<u32>,
    cosines: Vec<f32>,
    sines: Vec<f32>,
    /// Robots of the frame that can't be checked.
    unplaced: usize,
}

impl Crowd {
    /// Takes in a frame. `types` is the column `type`; robots beyond its end are of the first type.
    pub(crate) fn take(&mut self, columns: Columns, types: &[f32], roads: &Roads, settings: Settings) {
        cos_sin(columns.theta, &mut self.cosines, &mut self.sines);
        self.bodies.clear();
        self.boxes.clear();
        self.pieces.clear();
        self.ends.clear();
        self.unplaced = 0;
        for robot in 0..columns.x.len() {
            let body = self.body(robot, columns, types, roads);
            self.bodies.push(body);
            let bounds = self.bounds(body, settings);
            self.boxes.push(bounds);
            if settings.horizon() > 0.0 {
                self.predict(robot, columns, roads, settings);
            }
        }
    }

    fn body(&mut self, robot: usize, columns: Columns, types: &[f32], roads: &Roads) -> Body {
        if columns.state[robot] > RobotState::Faulted as u8 {
            return Body::NOBODY;
        }
        let place = [columns.x[robot], columns.y[robot]];
        let is_sane = place[0].abs().max(place[1].abs()) <= MAX_DISTANCE && columns.theta[robot].abs() <= MAX_HEADING;
        // `max` takes the number, if only one of them is one.
        let is_sane = is_sane && !place[0].is_nan() && !place[1].is_nan();
        let kind = types.get(robot).copied().unwrap_or(0.0);
        let Some(footprint) = roads.footprint(kind).filter(|_| is_sane) else {
            self.unplaced += 1;
            return Body::NOBODY;
        };
        let heading = [self.cosines[robot], self.sines[robot]];
        Body::new(place, heading, footprint, speed(columns.speed[robot]))
    }

    /// What counts now: two that are within the margin and the hysteresis have boxes that overlap.
    fn bounds(&self, body: Body, settings: Settings) -> Bounds {
        let pad = 0.5 * (settings.margin() + HYSTERESIS as f32);
        padded(body.place, body.place, body.half_extent(body.heading), pad)
    }

    /// Adds what counts later.
    fn predict(&mut self, robot: usize, columns: Columns, roads: &Roads, settings: Settings) {
        let body = self.bodies[robot];
        if body.is_there() {
            let held = columns.state[robot] == RobotState::Held as u8;
            let speed = if held { 0.0 } else { speed(columns.speed[robot]) };
            let drive = Drive { speed, s: columns.s[robot], chords: roads.paths.of(columns.edge[robot]) };
            let first = self.pieces.len();
            predict(&body, drive, settings.horizon(), &mut self.pieces);
            let bounds = &mut self.boxes[robot];
            let mut from = 0.0;
            for piece in &self.pieces[first..] {
                let [x, y] = piece.place;
                let time = piece.until - from;
                let end = [x + piece.velocity[0] * time, y + piece.velocity[1] * time];
                let swept = padded([x, y], end, body.half_extent(piece.heading), HYSTERESIS as f32);
                *bounds = join(*bounds, swept);
                from = piece.until;
            }
        }
        self.ends.push(self.pieces.len() as u32);
    }

    /// Where the checks look for overlaps, by robot.
    pub(crate) fn boxes(&self) -> &[Bounds] {
        &self.boxes
    }

    /// A robot now; [`Body::NOBODY`] for one that isn't there.
    pub(crate) fn body_of(&self, robot: u32) -> &Body {
        self.bodies.get(robot as usize).unwrap_or(&Body::NOBODY)
    }

    /// A robot's way through the horizon; without pieces if there is no horizon.
    pub(crate) fn way(&self, robot: u32, outline: Outline) -> Way<'_> {
        let index = robot as usize;
        let first = index.checked_sub(1).and_then(|before| self.ends.get(before)).copied().unwrap_or(0);
        let end = self.ends.get(index).copied().unwrap_or(first);
        Way { outline, pieces: &self.pieces[first as usize..end as usize] }
    }

    /// Robots that were left out, though they are there: their pose, or their type's footprint, is none.
    pub(crate) fn unplaced(&self) -> usize {
        self.unplaced
    }
}

/// What a robot is taken to do at a published speed.
fn speed(published: f32) -> f32 {
    if published.is_nan() { 0.0 } else { published.clamp(-MAX_SPEED, MAX_SPEED) }
}

/// The box around all that a robot covers on a straight way, and as much more as rounding may hide.
fn padded(from: [f32; 2], to: [f32; 2], half: [f32; 2], pad: f32) -> Bounds {
    let low = |axis: usize| from[axis].min(to[axis]) - half[axis];
    let high = |axis: usize| from[axis].max(to[axis]) + half[axis];
    let pad = |edge: f32| pad + 1e-5 + edge.abs() * 1e-6;
    [low(0) - pad(low(0)), low(1) - pad(low(1)), high(0) + pad(high(0)), high(1) + pad(high(1))]
}

fn join(a: Bounds, b: Bounds) -> Bounds {
    [a[0].min(b[0]), a[1].min(b[1]), a[2].max(b[2]), a[3].max(b[3])]
}
