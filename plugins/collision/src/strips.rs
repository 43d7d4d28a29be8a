//! Robots by where they are: in strips of the plane from west to east.
//!
//! A box around all that counts of a robot is entered in every strip that it reaches into. A strip is some times as
//! high as the mean box, so that on average a box is entered in one and a fifth of them, however small and large ones
//! are mixed and however far apart they lie. Which boxes of a strip overlap, `sweep.rs` finds out.
//!
//! Robots come by id, which says nothing about their places. They are written into strips as they come, with all that
//! the checks need of them; from there on nothing is fetched from far away, and a strip stays in the cache while it is
//! worked through. Strips far apart share their memory, so that the plane has no end.

use std::ops::ControlFlow;
use std::slice::from_ref;

use crate::body::Body;
use crate::bounds::Bounds;
use crate::chunk::Chunk;
use crate::crowd::Crowd;
use crate::footprint::Footprint;
use crate::grid::{Packing, Scale};
use crate::prediction::Piece;
use crate::sweep::{Candidates, Limits, Order};
use crate::way::{Way, pieces_of};

/// Robots that there are about in a strip, if there are as many strips as memory for them.
const STRIP_ROBOTS: usize = 512;
/// Most strips that don't share their memory.
const MAX_STRIPS: usize = 2048;

/// A robot in a strip: half a cache line, because a frame's time goes by in moving these.
#[derive(Clone, Copy, Debug, Default)]
#[repr(align(32))]
pub(crate) struct Mover {
    /// Metres east and north.
    pub place: [f32; 2],
    /// Unit vector along the heading.
    pub heading: [f32; 2],
    /// Metres per second.
    pub speed: f32,
    /// Its type: an index into the footprints.
    pub kind: u32,
    /// Its id.
    pub robot: u32,
    /// Twice the strip's number, and one more if it is the southernmost that the robot reaches into.
    slot: i32,
}

impl Mover {
    pub(crate) fn body(&self, footprints: &[Footprint]) -> Body {
        let Footprint { half_length, half_width } = footprints[self.kind as usize];
        Body { place: self.place, heading: self.heading, half_length, half_width }
    }

    pub(crate) fn strip(&self) -> i32 {
        self.slot >> 1
    }

    /// Whether the strip in which two were found is the first one that both reach into. (In another one, or if they are
    /// in different ones that share their memory, they are found once more.)
    pub(crate) fn is_first_with(&self, other: &Self) -> bool {
        (self.strip() == other.strip()) & ((self.slot | other.slot) & 1 != 0)
    }
}

/// Robots whose boxes reach into a strip, or into one that shares its memory.
#[derive(Debug, Default)]
pub(crate) struct Strip {
    pub movers: Vec<Mover>,
    /// Theirs, if there is a horizon, and the pieces of all.
    pub ways: Vec<Way>,
    pieces: Vec<Piece>,
}

impl Strip {
    fn clear(&mut self) {
        self.movers.clear();
        self.ways.clear();
        self.pieces.clear();
    }

    fn enter(&mut self, mover: &Mover, way: Option<(&Way, &[Piece])>, slot: i32) {
        self.movers.push(*mover);
        if let Some(mover) = self.movers.last_mut() {
            mover.slot = slot;
        }
        if let Some((way, pieces)) = way {
            self.ways.push(Way { first_piece: self.pieces.len() as u32, ..*way });
            self.pieces.extend_from_slice(pieces);
        }
    }

    pub(crate) fn mover(&self, place: u32) -> &Mover {
        &self.movers[place as usize]
    }

    /// If there is a horizon.
    pub(crate) fn way(&self, place: u32) -> &Way {
        &self.ways[place as usize]
    }

    /// Those of a robot, or else the one that it drives straight on.
    pub(crate) fn pieces<'all>(&'all self, place: u32, straight_on: &'all Piece) -> &'all [Piece] {
        let pieces = pieces_of(place as usize, &self.ways, &self.pieces);
        if pieces.is_empty() { from_ref(straight_on) } else { pieces }
    }
}

/// Robots by where they are. Kept from frame to frame for its memory.
#[derive(Debug, Default)]
pub(crate) struct Strips {
    scale: Scale,
    packing: Packing,
    strips: Vec<Strip>,
    chunk: Chunk,
    order: Order,
}

impl Strips {
    /// Takes in a frame's robots. Returns how many were left out though they are there, because their pose or their
    /// type's footprint is none.
    pub(crate) fn take(&mut self, crowd: &Crowd) -> usize {
        let robots = crowd.columns.x.len();
        crowd.sample(&mut self.chunk);
        self.scale = Scale::new(&self.chunk);
        let strips = (robots / STRIP_ROBOTS).next_power_of_two().min(MAX_STRIPS);
        self.strips.resize_with(strips, Strip::default);
        self.strips.iter_mut().for_each(Strip::clear);
        let (mut unplaced, mut all) = (0, Bounds::NOTHING);
        for first in (0..robots).step_by(Chunk::ROBOTS) {
            unplaced += crowd.take(first..(first + Chunk::ROBOTS).min(robots), &mut self.chunk);
            all = all.join(self.chunk.all_bounds());
            self.enter();
        }
        self.packing = Packing::new(self.scale, all, self.strips.len());
        unplaced
    }

    /// Puts a chunk of robots where they belong.
    fn enter(&mut self) {
        let Self { scale, strips, chunk, .. } = self;
        let mask = strips.len() as i32 - 1;
        let [first, last] = chunk.strips(*scale);
        for (number, mover) in chunk.movers().iter().enumerate() {
            let (first, last, way) = (first[number], last[number], chunk.way(number));
            for strip in first..last + 1 {
                let slot = strip << 1 | i32::from(strip == first);
                strips[(strip & mask) as usize].enter(mover, way, slot);
            }
        }
    }

    /// Tells all pairs of boxes that overlap, each once. Breaks off if that is too much for the limits in all, or if
    /// `check` does; the limits for each box just leave pairs out.
    pub(crate) fn sweep(
        &mut self,
        crowd: &Crowd,
        limits: Limits,
        mut check: impl FnMut(&Strip, Candidates) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let (footprints, pad, mut left) = (crowd.roads.footprints(), crowd.pad(), limits);
        for strip in &self.strips {
            self.order.sort(&self.packing, strip, |mover| Bounds::of(&mover.body(footprints), pad));
            self.order.sweep(&mut left, |candidates| check(strip, candidates))?;
        }
        ControlFlow::Continue(())
    }

    /// Each robot's strip, by its place in memory, and its place there. Looks at all robots.
    pub(crate) fn places(&self) -> Vec<Option<(u32, u32)>> {
        let mut places = Vec::new();
        for (number, strip) in (0..).zip(&self.strips) {
            for (place, mover) in (0..).zip(&strip.movers) {
                let robot = mover.robot as usize;
                if robot >= places.len() {
                    places.resize(robot + 1, None);
                }
                places[robot] = Some((number, place));
            }
        }
        places
    }

    pub(crate) fn strip(&self, number: u32) -> &Strip {
        &self.strips[number as usize]
    }
}
