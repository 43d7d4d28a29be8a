//! Which robots' bounds overlap: sort and sweep, in strips.
//!
//! The plane is cut into strips from west to east. A box is entered in every strip that it reaches into, and the boxes
//! of a strip are sorted by their western sides: from there, those that it overlaps from west to east come right
//! behind it. A strip is four times as high as the mean box, so that on average a box is entered in one and a quarter of
//! them, however small and large ones are mixed and however far apart they lie.
//!
//! Robots come by id, which says nothing about their places. They are written into strips as they come, with all that
//! the checks need of them; from there on nothing is fetched from far away, and a strip stays in the cache while it is
//! worked through. Strips far apart share their memory, so that the plane has no end.

use std::ops::ControlFlow;

use crate::bounds::Bounds;
use crate::crowd::{Chunk, Crowd, Mover};
use crate::prediction::Piece;
use crate::radix;

/// A strip's height, in those of the mean box.
const STRIP_HEIGHT: f32 = 6.0;
/// Least height of a strip, in metres. So the farthest strip has a number of at most 20 bits.
const MIN_STRIP_HEIGHT: f32 = 2.0;
/// A column's width, which is how exactly boxes are sorted, in those of the mean box.
const COLUMN_WIDTH: f32 = 0.25;
/// Least width of a column, in metres. So the farthest column has a number of at most 23 bits.
const MIN_COLUMN_WIDTH: f32 = 0.25;
/// Robots that there are about in a strip, if there are as many strips as memory for them.
const STRIP_ROBOTS: usize = 512;
/// Most strips that don't share their memory.
const MAX_STRIPS: usize = 2048;
/// Candidates that are collected before they are checked, if there are as many: so that the checks run on without a
/// break.
const BATCH: usize = 512;

/// What a sweep may cost.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Limits {
    /// Boxes that are looked at for each box, at most.
    pub looks_each: usize,
    /// Overlaps that are told for each box, at most.
    pub checks_each: usize,
    /// Looks in all.
    pub looks: usize,
    /// Overlaps in all.
    pub checks: usize,
}

/// From metres to strips and columns. Monotonous, whatever rounding does, which is all that is needed of it.
#[derive(Clone, Copy, Debug, Default)]
struct Scale {
    columns_per_metre: f32,
    strips_per_metre: f32,
}

impl Scale {
    /// For boxes like these.
    fn new(samples: &Chunk) -> Self {
        let (mut width, mut height) = (0.0, 0.0);
        for Mover { bounds, .. } in samples.movers() {
            (width, height) = (width + bounds.east() - bounds.west(), height + bounds.north() - bounds.south());
        }
        let mean = |sum: f32| sum / samples.movers().len().max(1) as f32;
        Self {
            columns_per_metre: 1.0 / (COLUMN_WIDTH * mean(width)).max(MIN_COLUMN_WIDTH),
            strips_per_metre: 1.0 / (STRIP_HEIGHT * mean(height)).max(MIN_STRIP_HEIGHT),
        }
    }

    fn column(&self, x: f32) -> i32 {
        round(x * self.columns_per_metre)
    }

    fn strip(&self, y: f32) -> i32 {
        round(y * self.strips_per_metre)
    }
}

/// The nearest whole number, of up to 22 bits: adding 1.5 · 2²³ moves it to the lowest bits. Unlike a conversion, that
/// is two instructions.
fn round(value: f32) -> i32 {
    const MAGIC: f32 = 12_582_912.0;
    (value + MAGIC).to_bits().wrapping_sub(MAGIC.to_bits()) as i32
}

/// Robots by where they are. Kept from frame to frame for its memory.
#[derive(Debug, Default)]
pub(crate) struct Strips {
    scale: Scale,
    packing: Packing,
    strips: Vec<Strip>,
    chunk: Chunk,
    order: Order,
    candidates: Vec<[u32; 2]>,
}

/// Robots whose boxes reach into a strip, or into one that shares its memory, with their pieces.
#[derive(Debug, Default)]
pub(crate) struct Strip {
    movers: Vec<Mover>,
    pieces: Vec<Piece>,
}

impl Strip {
    fn clear(&mut self) {
        self.movers.clear();
        self.pieces.clear();
    }

    fn enter(&mut self, mover: &Mover, pieces: &[Piece], number: i32, is_first: bool) {
        self.movers.push(*mover);
        if let Some(mover) = self.movers.last_mut() {
            (mover.strip, mover.is_first, mover.first_piece) = (number, is_first, self.pieces.len() as u32);
        }
        if !pieces.is_empty() {
            self.pieces.extend_from_slice(pieces);
        }
    }

    pub(crate) fn mover(&self, place: u32) -> &Mover {
        &self.movers[place as usize]
    }

    pub(crate) fn pieces_of(&self, mover: &Mover) -> &[Piece] {
        let first = mover.first_piece as usize;
        &self.pieces[first..first + usize::from(mover.pieces)]
    }
}

/// Robots whose boxes overlap, by their places in a strip.
pub(crate) type Candidates<'list> = &'list [[u32; 2]];

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
            all = all.join(self.chunk.bounds());
            self.enter();
        }
        self.packing = Packing::new(self.scale, all, self.strips.len());
        unplaced
    }

    /// Puts a chunk of robots where they belong.
    fn enter(&mut self) {
        let Self { scale, strips, chunk, .. } = self;
        let mask = strips.len() as i32 - 1;
        for mover in chunk.movers() {
            let pieces = chunk.pieces_of(mover);
            let (first, last) = (scale.strip(mover.bounds.south()), scale.strip(mover.bounds.north()));
            for number in first..=last {
                strips[(number & mask) as usize].enter(mover, pieces, number, number == first);
            }
        }
    }

    /// Tells all pairs of boxes that overlap, each once. Breaks off if that is too much for the limits in all, or if
    /// `check` does; the limits for each box just leave pairs out.
    pub(crate) fn sweep(
        &mut self,
        limits: Limits,
        mut check: impl FnMut(&Strip, Candidates) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let mut left = limits;
        for strip in &self.strips {
            self.order.sort(&self.packing, strip);
            self.order.sweep(&mut left, &mut self.candidates, |candidates| check(strip, candidates))?;
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

/// A strip's boxes in order.
#[derive(Debug, Default)]
struct Order {
    keys: Vec<u64>,
    scratch: Vec<u64>,
    entries: Vec<Entry>,
}

/// A box in a strip.
#[derive(Clone, Copy, Debug)]
struct Entry {
    bounds: Bounds,
    /// Strip and column of the box's western side, and of its eastern side.
    start: u32,
    end: u32,
    /// Of its robot in the strip.
    place: u32,
    /// Whether this is the southernmost strip that it reaches into.
    is_first: bool,
}

impl Order {
    /// Takes the boxes of a strip.
    fn sort(&mut self, packing: &Packing, strip: &Strip) {
        let start = |mover: &Mover| packing.pack(mover.strip, mover.bounds.west());
        self.keys.clear();
        self.keys.extend((0_u64..).zip(&strip.movers).map(|(place, mover)| u64::from(start(mover)) << 32 | place));
        radix::sort(&mut self.keys, &mut self.scratch, 32..32 + packing.bits, |key| *key);
        self.entries.clear();
        self.entries.extend(self.keys.iter().map(|key| {
            let (start, place) = ((key >> 32) as u32, *key as u32);
            let mover = strip.mover(place);
            let end = packing.pack(mover.strip, mover.bounds.east());
            Entry { bounds: mover.bounds, start, end, place, is_first: mover.is_first }
        }));
    }

    fn sweep(
        &self,
        left: &mut Limits,
        candidates: &mut Vec<[u32; 2]>,
        mut check: impl FnMut(Candidates) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let mut filled = 0;
        for (index, entry) in self.entries.iter().enumerate() {
            let behind = &self.entries[index + 1..];
            let reached = behind.iter().position(|other| other.start > entry.end).unwrap_or(behind.len());
            let looks = reached.min(left.looks_each);
            if filled + looks > candidates.len() {
                check(&candidates[..filled])?;
                filled = 0;
                candidates.resize(looks.max(BATCH), [0; 2]);
            }
            let (before, reach) = (filled, entry.bounds.reach());
            for other in &behind[..looks] {
                // Written in any case, kept only if they overlap: a guess whether they do would often be wrong.
                candidates[filled] = [entry.place, other.place];
                // And this must be the first strip that both are in.
                filled += usize::from(other.bounds.overlaps(reach) & (entry.is_first | other.is_first));
            }
            filled = filled.min(before.saturating_add(left.checks_each));
            if looks > left.looks || filled - before > left.checks {
                return ControlFlow::Break(());
            }
            (left.looks, left.checks) = (left.looks - looks, left.checks - (filled - before));
        }
        check(&candidates[..filled])
    }
}

/// How a strip and a column are packed into a number to sort by, among those in the same memory.
#[derive(Clone, Copy, Debug, Default)]
struct Packing {
    scale: Scale,
    first_column: i32,
    first_strip: i32,
    /// Logarithm of the number of strips that don't share their memory.
    apart: u32,
    /// By how many bits columns are less exact than the scale's, for want of room.
    coarser: u32,
    column_bits: u32,
    bits: u32,
}

impl Packing {
    /// For boxes within these bounds.
    fn new(scale: Scale, all: Bounds, strips: usize) -> Self {
        let apart = strips.ilog2();
        let bits =
            |first: i32, last: i32, shift: u32| radix::bits_below(((last.max(first) - first) >> shift) as usize + 1);
        let (first_column, first_strip) = (scale.column(all.west()), scale.strip(all.south()));
        let column_bits = bits(first_column, scale.column(all.east()), 0);
        let strip_bits = bits(first_strip, scale.strip(all.north()), apart);
        let coarser = (column_bits + strip_bits).saturating_sub(32);
        let column_bits = column_bits - coarser;
        Self { scale, first_column, first_strip, apart, coarser, column_bits, bits: column_bits + strip_bits }
    }

    fn pack(&self, strip: i32, x: f32) -> u32 {
        let strip = (strip.wrapping_sub(self.first_strip) as u32) >> self.apart;
        let column = (self.scale.column(x).wrapping_sub(self.first_column) as u32) >> self.coarser;
        strip << self.column_bits | column
    }
}
