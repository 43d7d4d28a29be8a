//! The stages of a tick, several rows at a time.
//!
//! Each is written once, over lanes, and compiled for each instruction set. The operations and their order are those
//! of [`scalar`], so the bits are the same.
//!
//! This is the one file of the engine with `unsafe` code: to call what the machine has been found to have, to read
//! rows of pieces without looking at the table's length each time, and to write past the cache.
#![allow(unsafe_code, reason = "calls of code for instruction sets, unchecked rows and stores past the cache")]

#[cfg(target_arch = "x86_64")]
#[path = "vector/avx2.rs"]
mod avx2_lanes;
#[cfg(target_arch = "x86_64")]
#[path = "vector/avx512.rs"]
mod avx512_lanes;
#[path = "vector/kernel.rs"]
mod kernel;
#[path = "vector/ops.rs"]
mod ops;
#[cfg(any(test, not(target_arch = "x86_64")))]
#[path = "vector/portable.rs"]
mod portable_lanes;
#[cfg(target_arch = "x86_64")]
#[path = "vector/sse2.rs"]
mod sse2_lanes;

use self::kernel::kernel;
use regatta_plugin::frame::{ColumnsMut, WORDS_PER_LINE};

use super::atan2::{BELOW_PI, COEFFICIENTS, LEAST};
use super::profile::LAST_STEP;
use super::{BLOCK, Isa, Listed, Lists, METRES_PER_UNIT, Motion, PIECE, Pace, REVERSE, Rows, scalar};
use crate::graph::arc_length::Piece;

#[cfg(target_arch = "x86_64")]
kernel!(baseline, sse2_lanes, #[target_feature(enable = "sse2")], stream_128);
#[cfg(target_arch = "x86_64")]
kernel!(avx2, avx2_lanes, #[target_feature(enable = "avx2")], stream_256);
#[cfg(target_arch = "x86_64")]
kernel!(avx512, avx512_lanes, #[target_feature(enable = "avx512f,avx512dq")], stream_512);
#[cfg(any(test, not(target_arch = "x86_64")))]
kernel!(portable, portable_lanes, #[allow(dead_code, reason = "only tests use it where there is SSE2")], stream_plainly);

/// Declares a store past the cache.
#[cfg(target_arch = "x86_64")]
macro_rules! stream {
    ($name:ident, $feature:literal, $lanes:literal, $vector:ident, $store:ident) => {
        #[inline]
        #[target_feature(enable = $feature)]
        fn $name(to: &mut [f32; $lanes], value: std::arch::x86_64::$vector) {
            debug_assert!(to.as_ptr().addr().is_multiple_of(size_of_val(to)));
            // SAFETY: there is room for a vector, and it lies on a multiple of its size: the columns start on cache
            // lines, or `write_block` would not have asked for this.
            unsafe { std::arch::x86_64::$store(to.as_mut_ptr(), value) }
        }
    };
}

#[cfg(target_arch = "x86_64")]
stream!(stream_128, "sse2", 4, __m128, _mm_stream_ps);
#[cfg(target_arch = "x86_64")]
stream!(stream_256, "avx2", 8, __m256, _mm256_stream_ps);
#[cfg(target_arch = "x86_64")]
stream!(stream_512, "avx512f", 16, __m512, _mm512_stream_ps);

/// Stands in where there are no stores past the cache.
#[cfg(any(test, not(target_arch = "x86_64")))]
fn stream_plainly(to: &mut [f32; 4], value: [f32; 4]) {
    *to = value;
}

impl Listed {
    /// Lists a row per bit, from row `first` on.
    #[inline]
    fn push_bits(&mut self, first: usize, mut bits: u32) {
        while bits != 0 {
            self.push(first + bits.trailing_zeros() as usize);
            bits &= bits - 1;
        }
    }
}

/// The rows of the table that the robots are on.
#[inline]
fn table_rows<'table, const N: usize>(pieces: &'table [Piece], numbers: &[u32; N]) -> [&'table Piece; N] {
    let mut rows = [&pieces[0]; N];
    for (row, &number) in rows.iter_mut().zip(numbers) {
        let number = (number & PIECE) as usize;
        debug_assert!(number < pieces.len());
        // SAFETY: what stands in the column comes from the table's own tracks, and the table has no more rows than
        // `PIECE` can tell apart.
        *row = unsafe { pieces.get_unchecked(number) };
    }
    rows
}

/// Calls a stage in the kernel of an instruction set.
macro_rules! dispatch {
    ($isa:expr, $scalar:expr, $stage:ident $(::<$past:literal>)? ($($argument:expr),*)) => {
        match $isa {
            Isa::Scalar => $scalar,
            // SAFETY: a fleet is set up only with an instruction set that this machine has been found to have.
            #[cfg(target_arch = "x86_64")]
            Isa::Avx2 => unsafe { avx2::$stage$(::<$past>)?($($argument),*) },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            Isa::Avx512 => unsafe { avx512::$stage$(::<$past>)?($($argument),*) },
            // SAFETY: every x86-64 machine has SSE2.
            #[cfg(target_arch = "x86_64")]
            Isa::Baseline => unsafe { baseline::$stage$(::<$past>)?($($argument),*) },
            #[cfg(not(target_arch = "x86_64"))]
            _ => portable::$stage$(::<$past>)?($($argument),*),
        }
    };
}

impl Motion {
    /// Stage 1 under acceleration limits.
    pub(super) fn accelerate(&self, block: &mut Rows, lists: &mut Lists) {
        let pace = self.pace;
        dispatch!(self.isa, scalar::accelerate(block, pace, lists), accelerate(block, pace, lists));
    }

    /// Stage 1.
    pub(super) fn advance(&self, block: &mut Rows, arrived: &mut Listed) {
        let pace = self.pace;
        dispatch!(self.isa, scalar::advance(block, pace, arrived), advance(block, pace, arrived));
    }

    /// Stage 3; past the cache if `past`, which must be followed by [`settle`].
    pub(super) fn write_block(&self, block: &Rows, columns: ColumnsMut, past: bool) {
        let pieces = self.roads.pieces();
        if past && starts_lines(&columns) {
            dispatch!(self.isa, scalar::write(block, pieces, columns), write::<true>(block, pieces, columns));
        } else {
            dispatch!(self.isa, scalar::write(block, pieces, columns), write::<false>(block, pieces, columns));
        }
    }
}

impl Motion {
    /// Has what the hand-over of these rows will look up on its way to the cache.
    pub(super) fn fetch(&self, block: &Rows, listed: &Listed) {
        for row in listed.rows() {
            fetch(&self.roads.stretches()[(block.piece[row] & PIECE) as usize]);
            fetch(&block.route[row]);
            fetch(&block.kind[row]);
            fetch(&block.s_end[row]);
        }
    }
}

/// Has the value that stands in the same column and place of the next block on its way to the cache: the machine's
/// own look-ahead ends with the page.
#[inline]
fn fetch_ahead<T>(value: *const T) {
    fetch(value.wrapping_add(BLOCK));
}

/// Has the machine look up the pages that the next block will be written to, one line of each, while there is time.
fn fetch_pages_ahead(columns: &ColumnsMut) {
    const LAST_OF_NEXT: usize = 2 * BLOCK - 1;
    for column in [&columns.x, &columns.y, &columns.theta, &columns.speed, &columns.s] {
        fetch(column.as_ptr().wrapping_add(LAST_OF_NEXT));
    }
    fetch(columns.edge.as_ptr().wrapping_add(LAST_OF_NEXT));
    fetch(columns.state.as_ptr().wrapping_add(LAST_OF_NEXT));
}

/// Has a value on its way to the cache.
#[inline]
fn fetch<T>(value: *const T) {
    #[cfg(all(target_arch = "x86_64", not(miri)))]
    {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        // SAFETY: every x86-64 machine has SSE, and a prefetch of any address only hints.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(value.cast()) }
    }
}

/// Whether every column starts on a cache line.
fn starts_lines(columns: &ColumnsMut) -> bool {
    let metres = [&columns.x, &columns.y, &columns.theta, &columns.speed, &columns.s];
    let starts = metres.map(|column| column.as_ptr().addr());
    let others = [columns.edge.as_ptr().addr(), columns.state.as_ptr().addr()];
    starts.iter().chain(&others).all(|start| start % 64 == 0)
}

/// Makes stores past the cache visible before any store that follows.
pub(super) fn settle() {
    // SAFETY: every x86-64 machine has SSE.
    #[cfg(all(target_arch = "x86_64", not(miri)))]
    unsafe {
        std::arch::x86_64::_mm_sfence();
    }
}

#[cfg(test)]
#[path = "vector/tests.rs"]
mod tests;
