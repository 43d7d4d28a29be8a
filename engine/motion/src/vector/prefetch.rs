//! Prefetches: hints to load memory into the cache before it is read.

use crate::block::BLOCK;
use crate::frame::PoseColumns;

/// Prefetches the value at the same position of the same column in the next block: the processor's
/// own prefetcher stops at the end of a page.
#[inline]
pub(super) fn prefetch_next_block<T>(value: *const T) {
    prefetch(value.wrapping_add(BLOCK));
}

/// Prefetches a line of each page that the next block will be written to, so that their addresses
/// are translated in time.
pub(super) fn prefetch_next_pages(columns: &PoseColumns) {
    const LAST_OF_NEXT: usize = 2 * BLOCK - 1;
    for column in [&columns.x, &columns.y, &columns.theta, &columns.speed, &columns.s] {
        prefetch(column.as_ptr().wrapping_add(LAST_OF_NEXT));
    }
    prefetch(columns.edge.as_ptr().wrapping_add(LAST_OF_NEXT));
    prefetch(columns.state.as_ptr().wrapping_add(LAST_OF_NEXT));
}

/// Prefetches a value, which need not exist.
#[inline]
pub(super) fn prefetch<T>(value: *const T) {
    #[cfg(all(target_arch = "x86_64", not(miri)))]
    {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        // SAFETY: every x86-64 machine has SSE, and a prefetch is only a hint, whatever the
        // address.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(value.cast()) }
    }
    #[cfg(not(all(target_arch = "x86_64", not(miri))))]
    let _ = value;
}
