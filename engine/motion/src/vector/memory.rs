//! Access to memory beyond plain loads and stores: prefetches, which are hints to load memory into
//! the cache before it is read, and stores past the cache (non-temporal stores), with the fence
//! that must follow them.
//!
//! Memory that was stored past the cache must not be accessed before a fence has run on the same
//! thread. Types make sure of that: such stores need a [`StreamFence`], which exists only inside
//! [`StreamFence::scope`] and can't leave its thread, and the memory stays mutably borrowed until
//! the scope has run the fence.

use std::marker::PhantomData;

use crate::frame::PoseColumns;
use crate::rows::BLOCK;

/// Prefetches the value at the same position of the same column in a later block: the processor's
/// own prefetcher stops at the end of a page. If the tick looks ahead, the next block has begun
/// already, and it is the one after that, for the second-level cache.
#[inline]
pub(super) fn prefetch_later_block<T>(value: *const T, looks_ahead: bool) {
    if !looks_ahead {
        return prefetch(value.wrapping_add(BLOCK));
    }
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

/// The way in which the kernel stores a frame that is borrowed for `'frame`.
pub(crate) trait StoreMode<'frame>: Copy {
    /// Whether the lines of the next block are prefetched.
    const PREFETCHES: bool;

    /// Returns the fence that allows stores past the cache, if the frame is to be stored that way.
    fn fence(&self) -> Option<&StreamFence<'frame>>;
}

/// Plain stores, which go through the cache.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cached;

impl<'frame> StoreMode<'frame> for Cached {
    const PREFETCHES: bool = false;

    #[inline]
    fn fence(&self) -> Option<&StreamFence<'frame>> {
        None
    }
}

/// Plain stores, of a frame that the second-level cache doesn't hold: its lines are prefetched.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Prefetched;

impl<'frame> StoreMode<'frame> for Prefetched {
    const PREFETCHES: bool = true;

    #[inline]
    fn fence(&self) -> Option<&StreamFence<'frame>> {
        None
    }
}

/// Permission to store past the cache to memory that is borrowed for exactly `'frame`.
///
/// When it is dropped it orders these stores before all that follow. It is invariant in `'frame`,
/// neither `Send` nor `Sync`, and only [`scope`](Self::scope) makes one.
#[derive(Debug)]
pub(crate) struct StreamFence<'frame>(PhantomData<*mut &'frame ()>);

impl<'frame> StreamFence<'frame> {
    /// Calls `work` with a fence and runs the fence afterwards, also if `work` panics.
    pub(crate) fn scope<R>(work: impl FnOnce(&Self) -> R) -> R {
        let fence = Self(PhantomData);
        work(&fence)
    }
}

impl Drop for StreamFence<'_> {
    fn drop(&mut self) {
        // SAFETY: every x86-64 machine has SSE.
        #[cfg(all(target_arch = "x86_64", not(miri)))]
        unsafe {
            std::arch::x86_64::_mm_sfence();
        }
    }
}

impl<'frame> StoreMode<'frame> for &StreamFence<'frame> {
    const PREFETCHES: bool = false;

    #[inline]
    fn fence(&self) -> Option<&StreamFence<'frame>> {
        Some(self)
    }
}

/// Declares a store of a vector past the cache.
#[cfg(target_arch = "x86_64")]
macro_rules! stream {
    ($name:ident, $feature:literal, $vector:ident, $store:ident) => {
        /// Stores a vector past the cache.
        ///
        /// # Safety
        /// `to` must not be accessed until the fence is dropped.
        #[inline]
        #[target_feature(enable = $feature)]
        pub(super) unsafe fn $name(
            _fence: &StreamFence,
            to: &mut std::arch::x86_64::$vector,
            value: std::arch::x86_64::$vector,
        ) {
            // SAFETY: a reference to a vector is aligned and valid for a store of it. The caller
            // keeps the fence's promise.
            unsafe { std::arch::x86_64::$store(std::ptr::from_mut(to).cast(), value) }
        }
    };
}

#[cfg(target_arch = "x86_64")]
stream!(stream_128, "sse2", __m128, _mm_stream_ps);
#[cfg(target_arch = "x86_64")]
stream!(stream_256, "avx2", __m256, _mm256_stream_ps);
#[cfg(target_arch = "x86_64")]
stream!(stream_512, "avx512f", __m512, _mm512_stream_ps);

/// Stores a vector plainly, where there are no stores past the cache.
///
/// # Safety
/// None needed; the signature is that of the stores past the cache.
#[inline]
pub(super) unsafe fn store_plainly<V>(_fence: &StreamFence, to: &mut V, value: V) {
    *to = value;
}
