//! One tick for every robot: advance, hand over to the next piece, write the poses.
//!
//! A robot is a row of the fleet's columns. Rows are worked through in blocks small enough to stay in the cache
//! between the stages of a tick:
//!
//! 1. advance: `w += speed · Δt`, in fixed point, in blocks where some type limits its acceleration with new speeds
//!    (`profile.rs` has the equations); rows that come to the end of their piece are listed;
//! 2. hand-over of the listed rows, one by one: they are few;
//! 3. poses of the whole block, written into the frame.
//!
//! Stages 1 and 3 exist as a plain reference (`scalar.rs`) and as vector code (`vector.rs`). Both do the same operations
//! in the same order, each correctly rounded by IEEE 754 (+ − × ÷ √, min, max, conversions; no fused multiply-add, no
//! libm), so all of them give the same bits.

mod atan2;
mod hand_over;
mod isa;
mod profile;
mod roads;
mod rows;
mod scalar;
mod vector;

pub use isa::{Isa, ParseIsaError};
pub(crate) use profile::UNLIMITED;
pub(crate) use roads::{Onward, Roads};
pub(crate) use rows::{LimitRows, Rows, leg_of, split_frame};

use regatta_plugin::frame::ColumnsMut;

use crate::fleet::{Events, Plans, RobotType};
use crate::graph::arc_length::Distance;

/// Rows in a block. Fixed, as events come in the order of blocks.
pub(crate) const BLOCK: usize = 1024;

/// Frames (or a thread's part of one) of this many rows and more are written past the cache.
const ROWS_PAST_CACHE: usize = 1 << 17;

/// Bit of the `piece` column that tells reverse gear.
pub(crate) const REVERSE: u32 = 1 << 31;

/// Bits of the `piece` column that tell the row: so few that 32 bits hold its place in bytes.
pub(crate) const PIECE: u32 = (1 << 27) - 1;

/// Metres in one unit of [`Distance`]; a power of two, so scaling by it is exact.
const METRES_PER_UNIT: f32 = 1.0 / (1u32 << 27) as f32;

/// A tick's length, as the stages use it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pace {
    /// Seconds a tick.
    seconds: f32,
    /// Units of [`Distance`] that a robot at 1 m/s drives in a tick.
    units: f32,
}

impl Pace {
    pub(crate) fn new(seconds: f64) -> Self {
        Self { seconds: seconds as f32, units: (seconds * Distance::PER_METRE) as f32 }
    }
}

/// The rows of a block that need a closer look.
#[derive(Debug)]
struct Listed {
    rows: [u16; BLOCK],
    len: usize,
}

impl Listed {
    const fn new() -> Self {
        Self { rows: [0; BLOCK], len: 0 }
    }

    fn push(&mut self, row: usize) {
        self.rows[self.len] = row as u16;
        self.len += 1;
    }

    fn rows(&self) -> impl Iterator<Item = usize> + '_ {
        self.rows[..self.len].iter().map(|&row| usize::from(row))
    }
}

/// What the first stage finds in a block.
#[derive(Debug)]
struct Lists {
    /// Robots that come to the end of their piece.
    arrived: Listed,
    /// Robots with limits that come to a stand.
    stood: Listed,
    /// Robots in blocks with limits that may come to the end of their leg: not moved yet.
    near: Listed,
}

impl Lists {
    const fn new() -> Self {
        Self { arrived: Listed::new(), stood: Listed::new(), near: Listed::new() }
    }
}

/// Everything that a tick reads and doesn't change.
#[derive(Debug)]
pub(crate) struct Motion {
    pub roads: Roads,
    pub plans: Plans,
    pub types: Vec<RobotType>,
    pub pace: Pace,
    pub isa: Isa,
}

impl Motion {
    /// One tick of these rows, into the frame if there is one.
    pub(crate) fn step(&self, mut rows: Rows, mut frame: Option<ColumnsMut>, events: &mut Events) {
        let past = is_past_cache(&frame);
        while !rows.is_empty() {
            let (mut block, rest) = rows.split_at(BLOCK);
            self.step_block(&mut block, events);
            if let Some(columns) = frame {
                let (now, later) = split_frame(columns, BLOCK);
                self.write_block(&block, now, past);
                frame = Some(later);
            }
            rows = rest;
        }
        vector::settle();
    }

    /// Writes the poses of these rows as they are.
    pub(crate) fn write(&self, mut rows: Rows, mut columns: ColumnsMut) {
        while !rows.is_empty() {
            let (block, rest) = rows.split_at(BLOCK);
            let (now, later) = split_frame(columns, BLOCK);
            self.write_block(&block, now, false);
            (rows, columns) = (rest, later);
        }
    }

    fn step_block(&self, block: &mut Rows, events: &mut Events) {
        let mut lists = Lists::new();
        if block.limits.as_ref().is_some_and(LimitRows::any) {
            self.accelerate(block, &mut lists);
            lists.stood.rows().for_each(|row| self.stand(block, row, events));
            self.fetch(block, &lists.near);
            lists.near.rows().for_each(|row| self.hand_over_limited(block, row, events));
        } else {
            self.advance(block, &mut lists.arrived);
        }
        self.next_pieces(block, &mut lists.arrived);
        self.fetch(block, &lists.arrived);
        lists.arrived.rows().for_each(|row| self.hand_over(block, row, events));
    }
}

/// Whether a frame is so large that its lines would push everything else out of the cache.
fn is_past_cache(frame: &Option<ColumnsMut>) -> bool {
    frame.as_ref().is_some_and(|columns| columns.x.len() >= ROWS_PAST_CACHE)
}
