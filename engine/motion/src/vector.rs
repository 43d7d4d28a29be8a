//! The stages of a tick, several rows at a time.
//!
//! Each stage is written once, over SIMD lanes ([`mod@kernel`]), and compiled for each instruction
//! set ([`lanes`]). The operations and their order are those of [`scalar`], so the bits are the
//! same.
//!
//! `unsafe` code calls functions for the detected instruction set, stores past the cache, and
//! prefetches.
#![allow(
    unsafe_code,
    reason = "calls of code for instruction sets, stores past the cache and prefetches"
)]

mod kernel;
mod lanes;
mod memory;

use crate::frame::PoseColumns;

use self::kernel::kernel;
use self::memory::prefetch;
pub(super) use self::memory::{Cached, Prefetched, StoreMode, StreamFence};
use super::isa::{KernelVariant, SupportedIsa};
use super::rows::{AlignedVec, BlockLists, RowList, Rows};
use super::{Motion, scalar};

#[cfg(target_arch = "x86_64")]
kernel!(
    #[target_feature(enable = "sse2")]
    sse2,
    stream_128
);
#[cfg(target_arch = "x86_64")]
kernel!(
    #[target_feature(enable = "avx2")]
    avx2,
    stream_256
);
#[cfg(target_arch = "x86_64")]
kernel!(
    #[target_feature(enable = "avx512f,avx512dq")]
    avx512,
    stream_512
);
#[cfg(target_arch = "aarch64")]
kernel!(
    #[target_feature(enable = "neon")]
    neon,
    store_plainly
);
kernel!(portable, store_plainly);

/// Calls a stage in the variant of the kernel for an instruction set.
macro_rules! dispatch {
    ($isa:expr, $scalar:expr, $stage:ident($($argument:expr),*)) => {
        match $isa.variant() {
            KernelVariant::Scalar => $scalar,
            KernelVariant::Portable => portable::$stage($($argument),*),
            // SAFETY: every 64-bit Arm machine has NEON.
            #[cfg(target_arch = "aarch64")]
            KernelVariant::Neon => unsafe { neon::$stage($($argument),*) },
            // SAFETY: every x86-64 machine has SSE2.
            #[cfg(target_arch = "x86_64")]
            KernelVariant::Sse2 => unsafe { sse2::$stage($($argument),*) },
            // SAFETY: `SupportedIsa` has this variant only if AVX2 was detected.
            #[cfg(target_arch = "x86_64")]
            KernelVariant::Avx2 => unsafe { avx2::$stage($($argument),*) },
            // SAFETY: `SupportedIsa` has this variant only if AVX-512 F and DQ were detected.
            #[cfg(target_arch = "x86_64")]
            KernelVariant::Avx512 => unsafe { avx512::$stage($($argument),*) },
        }
    };
}

impl SupportedIsa {
    /// Fills a column with stores past the cache, as frames of large fleets are written: the rate
    /// of these stores bounds a tick.
    ///
    /// # Panics
    /// If the column isn't a whole number of cache lines.
    pub fn fill_past_cache(self, column: &mut AlignedVec<f32>, value: f32) {
        StreamFence::scope(|fence| {
            dispatch!(self, column.fill(value), fill(column, value, fence));
        });
    }
}

impl Motion {
    /// Stage 1 under acceleration limits.
    pub(super) fn accelerate(&self, block: &mut Rows, lists: &mut BlockLists) {
        let time_step = self.time_step;
        dispatch!(
            self.isa,
            scalar::accelerate(block, time_step, lists),
            accelerate(block, time_step, lists)
        );
    }

    /// Stage 1.
    pub(super) fn advance(&self, block: &mut Rows, arrived: &mut RowList) {
        let time_step = self.time_step;
        dispatch!(
            self.isa,
            scalar::advance(block, time_step, arrived),
            advance(block, time_step, arrived)
        );
    }

    /// Stage 3.
    ///
    /// # Panics
    /// If the columns don't start on cache lines or are longer than the block.
    pub(super) fn write_block<'frame, S: StoreMode<'frame>>(
        &self,
        block: &Rows,
        columns: PoseColumns<'frame>,
        mode: S,
    ) {
        let table = self.legs.pieces();
        dispatch!(
            self.isa,
            scalar::write(block, table, columns),
            write(block, table, columns, mode)
        );
    }

    /// Prefetches what the hand-over of these rows reads.
    pub(super) fn prefetch_rows(&self, block: &Rows, listed: &RowList) {
        for row in listed.rows() {
            prefetch(&self.legs.spans()[block.piece.get(row).row()]);
            prefetch(&block.route[row]);
            prefetch(&block.robot_type[row]);
            prefetch(&block.s_end[row]);
            prefetch(&block.state[row]);
        }
    }

    /// Lists the rows that are about to leave their leg, and prefetches these legs.
    pub(super) fn prefetch_legs(&self, block: &Rows, lists: &mut BlockLists) {
        let BlockLists { arrived, leaving, .. } = lists;
        for row in arrived.rows() {
            leaving.push_if(row, self.legs.span(block.piece.get(row)).is_last());
        }
        for row in leaving.rows() {
            if let Some(leg) = block.leg(row) {
                prefetch(self.legs.leg(leg));
            }
        }
    }

    /// Prefetches the legs that the listed rows enter.
    pub(super) fn prefetch_next_legs(&self, block: &Rows, leaving: &RowList) {
        for row in leaving.rows() {
            if let Ok(leg) = self.next_leg(&mut self.route_cursor(block, row)) {
                prefetch(self.legs.leg(leg));
            }
        }
    }
}
