//! One tick for every robot: advance it, hand it over to the next piece, write its pose.
//!
//! A robot is a row of the fleet's columns. Rows are processed in blocks that are small enough to
//! stay in the cache between the stages of a tick:
//!
//! 1. advance: `w += speed · Δt` in fixed point. Blocks with a robot whose type limits its
//!    acceleration also get new speeds (`profile.rs` has the equations). Rows that reach the end of
//!    their piece are listed.
//! 2. hand-over of the listed rows, one by one: they are few. Then the rows that turn on the spot
//!    (`turning.rs`).
//! 3. poses of the whole block, written into the frame.
//!
//! A robot whose base ends within its leg is listed like one near the end of its leg
//! (`base_end.rs`).
//!
//! Stages 1 and 3 exist as a plain reference (`scalar.rs`) and as vector code (`vector.rs`). Both
//! do the same operations in the same order, each correctly rounded by IEEE 754 (+ − × ÷ √, min,
//! max, conversions; no fused multiply-add, no libm), so all of them give the same bits.
//!
//! This module depends on the route graph only. The fleet, which owns the columns and applies
//! orders, depends on it.
//!
//! The preconditions of the vector code are types, so that no safe function can break them: a
//! [`PieceColumn`] holds only indices of the table's pieces, a [`SupportedIsa`] exists only for
//! instruction sets that were detected, and memory that is stored past the cache stays borrowed
//! until a [`StreamFence`] has run.

mod aligned_vec;
mod atan2;
mod base_end;
mod block;
mod events;
mod hand_over;
mod headings;
mod isa;
mod leg_table;
mod pieces;
mod profile;
mod routes;
mod rows;
mod scalar;
mod speed_variation;
mod time_step;
mod turning;
mod vector;

pub(crate) use aligned_vec::{AlignedVec, ROW_GROUP};
pub(crate) use block::BLOCK;
pub use events::EventBuffer;
pub(crate) use headings::{EdgeHeadings, HeadingRule};
pub(crate) use isa::SupportedIsa;
pub use isa::{Isa, ParseIsaError};
pub(crate) use leg_table::{LegTable, TooManyPieces};
pub(crate) use pieces::{MAX_PIECES, PieceColumn, PieceIndex};
pub(crate) use profile::{KinematicLimits, UNLIMITED};
pub use routes::Repeat;
pub(crate) use routes::{Plans, Route, RouteCursor, mix};
pub(crate) use rows::{HeadingRows, LimitRows, Rows, leg_of, split_frame};
pub(crate) use speed_variation::SpeedVariation;
pub(crate) use time_step::TimeStep;

use regatta_plugin::frame::ColumnsMut;

use self::block::{BlockLists, RowList};
use self::vector::{Cached, StoreMode, StreamFence};

/// Frames (or a thread's part of one) with at least this many rows are stored past the cache: their
/// lines would evict everything else from it.
const ROWS_PAST_CACHE: usize = 1 << 17;

/// Everything that a tick reads and doesn't change.
#[derive(Debug)]
pub(crate) struct Motion {
    pub legs: LegTable,
    pub plans: Plans,
    /// `None` if every robot's heading is that of its edge.
    pub headings: Option<EdgeHeadings>,
    /// By robot type.
    pub limits: Vec<KinematicLimits>,
    pub variation: SpeedVariation,
    pub time_step: TimeStep,
    pub isa: SupportedIsa,
}

impl Motion {
    /// Moves these rows by one tick and writes their poses into the frame, if there is one.
    pub(crate) fn step(&self, rows: Rows, frame: Option<ColumnsMut>, events: &mut EventBuffer) {
        match frame {
            None => self.step_unpublished(rows, events),
            Some(columns) if columns.x.len() >= ROWS_PAST_CACHE => {
                StreamFence::scope(|fence| self.step_into(rows, columns, fence, events));
            }
            Some(columns) => self.step_into(rows, columns, Cached, events),
        }
    }

    /// Writes the poses of these rows as they are.
    pub(crate) fn write(&self, mut rows: Rows, mut columns: ColumnsMut) {
        while !rows.is_empty() {
            let (block, later_rows) = rows.split_at(BLOCK);
            let (now, later) = split_frame(columns, BLOCK);
            self.write_block(&block, now, Cached);
            (rows, columns) = (later_rows, later);
        }
    }

    fn step_unpublished(&self, mut rows: Rows, events: &mut EventBuffer) {
        while !rows.is_empty() {
            let (mut block, later_rows) = rows.split_at(BLOCK);
            self.step_block(&mut block, events);
            rows = later_rows;
        }
    }

    fn step_into<'frame, S: StoreMode<'frame>>(
        &self,
        mut rows: Rows,
        mut columns: ColumnsMut<'frame>,
        mode: S,
        events: &mut EventBuffer,
    ) {
        while !rows.is_empty() {
            let (mut block, later_rows) = rows.split_at(BLOCK);
            let (now, later) = split_frame(columns, BLOCK);
            self.step_block(&mut block, events);
            self.write_block(&block, now, mode);
            (rows, columns) = (later_rows, later);
        }
    }

    fn step_block(&self, block: &mut Rows, events: &mut EventBuffer) {
        let turning = self.turning_rows(block);
        let mut lists = BlockLists::new();
        if block.limits.as_ref().is_some_and(LimitRows::any) {
            self.accelerate(block, &mut lists);
            lists.stopped.rows().for_each(|row| self.report_held(block, row, events));
            self.prefetch(block, &lists.near_leg_end);
            lists.near_leg_end.rows().for_each(|row| self.hand_over_limited(block, row, events));
        } else {
            self.advance(block, &mut lists.arrived);
        }
        self.next_pieces(block, &mut lists.arrived);
        self.prefetch(block, &lists.arrived);
        lists.arrived.rows().for_each(|row| self.hand_over(block, row, events));
        turning.iter().flat_map(RowList::rows).for_each(|row| self.turn(block, row, events));
    }
}
