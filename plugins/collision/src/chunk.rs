//! Some robots of a frame, by columns: so that the compiler works on several at once.

use crate::body::Body;
use crate::bounds::Bounds;
use crate::footprint::Footprint;
use crate::grid::Scale;
use crate::heading::heading;
use crate::prediction::Piece;
use crate::strips::Mover;
use crate::way::{Way, pieces_of};

/// Some robots of a frame.
#[derive(Debug)]
pub(crate) struct Chunk {
    pub len: usize,
    pub robot: Column<u32>,
    pub kind: Column<u32>,
    pub x: Column<f32>,
    pub y: Column<f32>,
    pub theta: Column<f32>,
    pub speed: Column<f32>,
    half_length: Column<f32>,
    half_width: Column<f32>,
    cos: Column<f32>,
    sin: Column<f32>,
    west: Column<f32>,
    south: Column<f32>,
    east: Column<f32>,
    north: Column<f32>,
    movers: Column<Mover>,
    /// Theirs, if there is a horizon, and the pieces of all.
    ways: Vec<Way>,
    pieces: Vec<Piece>,
}

pub(crate) type Column<T> = [T; Chunk::ROBOTS];

impl Default for Chunk {
    fn default() -> Self {
        let column = [0.0; Self::ROBOTS];
        Self {
            len: 0,
            robot: [0; Self::ROBOTS],
            kind: [0; Self::ROBOTS],
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
            movers: [Mover::default(); Self::ROBOTS],
            ways: Vec::new(),
            pieces: Vec::new(),
        }
    }
}

impl Chunk {
    /// Most robots: as many as stay in the first-level cache.
    pub(crate) const ROBOTS: usize = 256;

    /// Works out headings, and bounds of what robots cover now and `pad` metres more. Those beyond the last robot are
    /// left over, and worked out as well: so their number is known to the compiler.
    pub(crate) fn finish(&mut self, footprints: &[Footprint], pad: f32) {
        self.set_sizes(footprints);
        for ((theta, cos), sin) in self.theta.iter().zip(&mut self.cos).zip(&mut self.sin) {
            [*cos, *sin] = heading(*theta);
        }
        for number in 0..Self::ROBOTS {
            let bounds = Bounds::of(&self.body(number), pad);
            (self.west[number], self.east[number]) = (bounds.west(), bounds.east());
            (self.south[number], self.north[number]) = (bounds.south(), bounds.north());
        }
        self.pack();
        self.pieces.clear();
        self.ways.clear();
    }

    /// Fills in footprints by types.
    fn set_sizes(&mut self, footprints: &[Footprint]) {
        if let [only] = footprints {
            self.half_length.fill(only.half_length);
            self.half_width.fill(only.half_width);
            return;
        }
        for number in 0..Self::ROBOTS {
            // What is left over may be of types that are no more.
            let footprint = footprints.get(self.kind[number] as usize).unwrap_or(&Footprint::UNKNOWN);
            (self.half_length[number], self.half_width[number]) = (footprint.half_length, footprint.half_width);
        }
    }

    /// Puts robots together from their columns: each value straight to its place, as a robot that is first put together
    /// elsewhere and then copied would wait for that.
    fn pack(&mut self) {
        for number in 0..Self::ROBOTS {
            let mover = &mut self.movers[number];
            mover.place = [self.x[number], self.y[number]];
            mover.heading = [self.cos[number], self.sin[number]];
            mover.speed = self.speed[number];
            (mover.robot, mover.kind) = (self.robot[number], self.kind[number]);
        }
    }

    /// Adds the next robot's way, of pieces that `predict` adds.
    pub(crate) fn add_way(&mut self, predict: impl FnOnce(&Body, &mut Vec<Piece>)) {
        let (number, first) = (self.ways.len(), self.pieces.len());
        let body = self.body(number);
        predict(&body, &mut self.pieces);
        let way = Way::new(&body, &self.pieces, first, self.bounds(number));
        (self.west[number], self.east[number]) = (way.bounds.west(), way.bounds.east());
        (self.south[number], self.north[number]) = (way.bounds.south(), way.bounds.north());
        self.ways.push(way);
        if self.pieces.len() == first + 1 {
            // The way says it all.
            self.pieces.truncate(first);
        }
    }

    fn body(&self, number: usize) -> Body {
        Body {
            place: [self.x[number], self.y[number]],
            heading: [self.cos[number], self.sin[number]],
            half_length: self.half_length[number],
            half_width: self.half_width[number],
        }
    }

    /// The robots.
    pub(crate) fn movers(&self) -> &[Mover] {
        &self.movers[..self.len]
    }

    /// A robot's way with its pieces, if there is a horizon.
    pub(crate) fn way(&self, number: usize) -> Option<(&Way, &[Piece])> {
        let way = self.ways.get(number)?;
        Some((way, pieces_of(number, &self.ways, &self.pieces)))
    }

    /// Around all that counts of a robot.
    pub(crate) fn bounds(&self, number: usize) -> Bounds {
        Bounds::new([self.west[number], self.south[number]], [self.east[number], self.north[number]])
    }

    /// Around all that counts of all.
    pub(crate) fn all_bounds(&self) -> Bounds {
        let least = |column: &Column<f32>| extreme(&column[..self.len], f32::MAX, |a, b| if a < b { a } else { b });
        let most = |column: &Column<f32>| extreme(&column[..self.len], -f32::MAX, |a, b| if a > b { a } else { b });
        Bounds::new([least(&self.west), least(&self.south)], [most(&self.east), most(&self.north)])
    }

    /// The strips of southern and of northern sides; of what is left over, some numbers.
    pub(crate) fn strips(&self, scale: Scale) -> [Column<i32>; 2] {
        [self.south.map(|y| scale.strip(y)), self.north.map(|y| scale.strip(y))]
    }
}

/// The least or the most of these, four at once.
fn extreme(values: &[f32], start: f32, pick: impl Fn(f32, f32) -> f32) -> f32 {
    let (fours, rest) = values.as_chunks::<4>();
    let mut found = [start; 4];
    for four in fours {
        found = [0, 1, 2, 3].map(|lane| pick(four[lane], found[lane]));
    }
    found.iter().chain(rest).fold(start, |one, other| pick(*other, one))
}
