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
//! The kernel knows curves as pieces ([`Piece`]), which it is given, and neither layouts nor
//! fleets. The owner of the columns spawns robots and applies commands.
//!
//! The preconditions of the vector code are types, so that no safe function can break them: a
//! [`PieceColumn`] holds only indices of the table's pieces, a [`SupportedIsa`] exists only for
//! instruction sets that were detected, and memory that is stored past the cache stays borrowed
//! until a [`StreamFence`] has run.
//!
//! ```
//! use std::sync::Arc;
//!
//! use regatta_base::graph::{Gear, NodeIndex};
//! use regatta_motion::{
//!     Distance, Edge, HeadingRule, Isa, KinematicLimits, LegTable, Motion, Piece, PieceInfo,
//!     Plans, SpeedVariation, SupportedIsa, TimeStep, Tracks,
//! };
//!
//! // One edge from (0, 0) to (4, 0): a single piece. A piece counts the distance from its end.
//! let along_x = |x: f32| Piece { x: [x, 1.0, 0.0, 0.0], y: [0.0; 4] };
//! let info = PieceInfo { length: Distance::from_metres(4.0), s_end: 4.0 };
//! let mut tracks = Tracks::default();
//! tracks.push_edge([(along_x(4.0), info)], None::<[(Piece, PieceInfo); 1]>);
//! tracks.push_nodes([along_x(0.0), along_x(4.0)]);
//! let (origin, destination) = (NodeIndex(0), NodeIndex(1));
//! let edge = Edge { origin, destination, speed: 1.5, reverse_speed: None };
//! let motion = Motion {
//!     legs: LegTable::new(vec![1, 2], &[edge], Arc::new(tracks)).expect("few pieces"),
//!     plans: Plans::new(0),
//!     headings: None,
//!     limits: vec![KinematicLimits {
//!         max_speed: f32::INFINITY,
//!         max_acceleration: f32::INFINITY,
//!         max_rotation_speed: 0.0,
//!         max_rotation_acceleration: f32::INFINITY,
//!     }],
//!     variation: SpeedVariation::default(),
//!     time_step: TimeStep::new(0.02),
//!     isa: SupportedIsa::detect(Isa::detect()).expect("it was detected"),
//! };
//! // A robot one metre before the end of the piece.
//! let piece = motion.legs.piece(0, Gear::Forward);
//! let pose = motion.pose(piece, Distance::from_metres(-1.0).0, HeadingRule::TANGENT);
//! assert_eq!(pose, [3.0, 0.0, 0.0]);
//! ```

mod atan2;
mod base_end;
mod frame;
mod hand_over;
mod headings;
mod isa;
mod leg_table;
mod piece;
mod pieces;
mod profile;
mod routes;
mod rows;
mod scalar;
mod tracks;
mod turning;
mod vector;

pub use frame::{Event, EventSink, NO_EDGE, PoseColumns, RobotState};
pub use headings::{EdgeHeading, EdgeHeadings, HeadingRule};
pub use isa::{Isa, ParseIsaError, SupportedIsa};
pub use leg_table::{CompiledLeg, Edge, LegTable, TooManyPieces};
pub use piece::{Distance, Piece, PieceInfo, TimeStep};
pub use pieces::{MAX_PIECES, PieceColumn, PieceIndex, PieceRows};
pub use profile::{KinematicLimits, SpeedVariation, UNLIMITED};
pub use routes::{BaseEnd, Plans, Route, RouteCursor};
pub use rows::{AlignedVec, BLOCK, HeadingRows, LimitRows, ROW_GROUP, Rows, leg_of};
pub use tracks::{Track, Tracks};

use self::rows::BlockLists;
use self::vector::{Cached, Prefetched, StoreMode, StreamFence};

/// Frames (or a thread's part of one) with at least this many rows don't fit the second-level cache
/// together with the fleet's columns.
const ROWS_BEYOND_CACHE: usize = 1 << 15;

/// Frames with at least this many rows are stored past the cache: their lines would evict
/// everything else from it. Smaller ones aren't, because readers would wait for memory.
const ROWS_PAST_CACHE: usize = 1 << 17;

/// Everything that a tick reads and doesn't change.
#[derive(Debug)]
pub struct Motion {
    /// The legs, their pieces, and the edges that leave each node.
    pub legs: LegTable,
    /// The routes of all robots.
    pub plans: Plans,
    /// `None` if every robot's heading is that of its edge.
    pub headings: Option<EdgeHeadings>,
    /// By robot type.
    pub limits: Vec<KinematicLimits>,
    /// The variation of speeds.
    pub variation: SpeedVariation,
    /// The length of a tick.
    pub time_step: TimeStep,
    /// The instruction set of the vector code.
    pub isa: SupportedIsa,
}

impl Motion {
    /// Moves these rows by one tick and writes their poses into the frame, if there is one.
    pub fn step(&self, rows: Rows, frame: Option<PoseColumns>, events: &mut dyn EventSink) {
        match frame.as_ref().map_or(0, |columns| columns.x.len()) {
            ROWS_PAST_CACHE.. => {
                StreamFence::scope(|fence| self.step_into(rows, frame, fence, events));
            }
            ROWS_BEYOND_CACHE.. => self.step_into(rows, frame, Prefetched, events),
            _ => self.step_into(rows, frame, Cached, events),
        }
    }

    /// Writes the poses of these rows as they are.
    pub fn write(&self, mut rows: Rows, mut columns: PoseColumns) {
        while !rows.is_empty() {
            let (block, later_rows) = rows.split_at(BLOCK);
            let (now, later) = columns.split_at(BLOCK);
            self.write_block(&block, now, Cached);
            (rows, columns) = (later_rows, later);
        }
    }

    /// Steps block by block.
    ///
    /// In large fleets stage 1 of a block comes before the poses of the block before it are
    /// written: meanwhile the memory arrives that hand-overs need. Blocks with limits don't look
    /// ahead: the columns of two of them don't fit the first-level cache.
    fn step_into<'frame, S: StoreMode<'frame>>(
        &self,
        rows: Rows,
        mut frame: Option<PoseColumns<'frame>>,
        mode: S,
        events: &mut dyn EventSink,
    ) {
        let looks_ahead = rows.len() >= ROWS_BEYOND_CACHE && rows.limits.is_none();
        let (mut lists, mut next_lists) = (&mut BlockLists::new(), &mut BlockLists::new());
        let (mut block, mut later) = rows.split_at(BLOCK);
        self.begin_block(&mut block, lists);
        while !block.is_empty() {
            let (mut next, rest) = later.split_at(BLOCK);
            if looks_ahead {
                self.begin_block(&mut next, next_lists);
                self.prefetch_rows(&next, &next_lists.arrived);
            }
            self.end_block(&mut block, lists, events);
            if looks_ahead {
                self.prefetch_legs(&next, next_lists);
            }
            if let Some(columns) = frame {
                let (now, later_columns) = columns.split_at(BLOCK);
                self.write_block(&block, now, mode);
                frame = Some(later_columns);
            }
            if looks_ahead {
                self.prefetch_next_legs(&next, &next_lists.leaving);
            } else {
                self.begin_block(&mut next, next_lists);
            }
            (block, later) = (next, rest);
            std::mem::swap(&mut lists, &mut next_lists);
        }
    }

    /// Does stage 1 and lists the rows that need stage 2.
    fn begin_block(&self, block: &mut Rows, lists: &mut BlockLists) {
        lists.clear();
        self.list_turning(block, &mut lists.turning);
        if block.limits.as_ref().is_some_and(LimitRows::any) {
            self.accelerate(block, lists);
        } else {
            self.advance(block, &mut lists.arrived);
        }
    }

    /// Does stage 2.
    fn end_block(&self, block: &mut Rows, lists: &mut BlockLists, events: &mut dyn EventSink) {
        lists.stopped.rows().for_each(|row| self.report_held(block, row, events));
        self.prefetch_rows(block, &lists.near_leg_end);
        lists.near_leg_end.rows().for_each(|row| self.hand_over_limited(block, row, events));
        self.next_pieces(block, &mut lists.arrived);
        self.prefetch_rows(block, &lists.arrived);
        lists.arrived.rows().for_each(|row| self.hand_over(block, row, events));
        lists.turning.rows().for_each(|row| self.turn(block, row, events));
    }
}
