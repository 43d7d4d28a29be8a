//! Prefetches: hints to load memory into the cache before it is read.

use crate::block::BLOCK;
use crate::frame::PoseColumns;

/// Prefetches the value at the same position of the same column in the block after the next, into
/// the second-level cache: the processor's own prefetcher stops at the end of a page, and the next
/// block may have begun already.
#[inline]
pub(super) fn prefetch_later_block<T>(value: *const T) {
    let later = value.wrapping_add(2 * BLOCK);
    #[cfg(all(target_arch = "x86_64", not(miri)))]
    {
        use std::arch::x86_64::{_MM_HINT_T1, _mm_prefetch};
        // SAFETY: every x86-64 machine has SSE, and a prefetch is only a hint, whatever the
        // address.
        unsafe { _mm_prefetch::<_MM_HINT_T1>(later.cast()) }
    }
    #[cfg(not(all(target_arch = "x86_64", not(miri))))]
    let _ = later;
}

/// Prefetches the line of a value, which need not exist, to write it: then no other processor has
/// it.
#[inline]
pub(super) fn prefetch_to_write<T>(value: *const T) {
    #[cfg(all(target_arch = "x86_64", not(miri)))]
    // SAFETY: `prefetchw` is only a hint, whatever the address, and does nothing on the x86-64
    // machines that don't know it.
    unsafe {
        std::arch::asm!("prefetchw [{}]", in(reg) value, options(nostack, preserves_flags));
    }
    #[cfg(not(all(target_arch = "x86_64", not(miri))))]
    let _ = value;
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
