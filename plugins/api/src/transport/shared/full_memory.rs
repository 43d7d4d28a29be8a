//! Shared memory that is full, as an error rather than the end of the process.
//!
//! The kernel takes a page of shared memory from the file system at the first write to it, and
//! raises `SIGBUS` if there is none left: by default that ends the process, even if another one
//! filled the memory. Two measures turn it into an error:
//!
//! - [`reserve`] takes the pages of a chunk before it is written, by
//!   `madvise(MADV_POPULATE_WRITE)`, which fails where a write would raise `SIGBUS`.
//! - iceoryx2 writes on its own (headers of chunks, connections to new readers) in [`guarded`]
//!   calls: a handler of `SIGBUS` puts a page of private memory where one is missing, as libwayland
//!   does for the memory of its clients, and the caller gets the page. Writes to it
//!   reach no other process.
//!
//! Only Linux is guarded in this way.

#[cfg(target_os = "linux")]
pub(crate) use linux::{guarded, release, reserve, restore};
#[cfg(not(target_os = "linux"))]
pub(crate) use other::{guarded, release, reserve, restore};

use core::mem::MaybeUninit;

pub(crate) use crate::ports::error::FULL;
use crate::ports::error::ReadError;

/// The pages that were missing during a [`guarded`] call.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Missing {
    /// The addresses of the first of them.
    addresses: [usize; MAX_PAGES],
    /// The number of them all.
    count: usize,
}

/// The largest number of pages that can be restored after a call. A chunk's headers lie on two at
/// most.
const MAX_PAGES: usize = 4;

impl Missing {
    const NONE: Self = Self { addresses: [0; MAX_PAGES], count: 0 };

    /// Whether there were any.
    pub(crate) fn any(&self) -> bool {
        self.count > 0
    }
}

/// Receives by `receive`, which connects new senders first. A sender for whose connection there is
/// no memory is left out: it has an error, and the others are served.
pub(crate) fn received<T: Default, E: core::fmt::Display>(
    what: &'static str,
    receive: impl FnOnce() -> Result<T, E>,
) -> Result<T, ReadError> {
    let (received, missing) = guarded(receive);
    if missing.any() {
        tracing::warn!("connecting a sender of {what}: {FULL}");
        return Ok(received.unwrap_or_default());
    }
    received.map_err(|error| receive_error(what, error))
}

/// The error of receiving `what`.
pub(crate) fn receive_error(what: &'static str, error: impl core::fmt::Display) -> ReadError {
    ReadError::Receive { what, reason: error.to_string() }
}

/// Calls an operation of iceoryx2, with full memory as an error. Missing pages are shared again
/// afterwards, so that a later attempt can succeed.
pub(crate) fn unless_full<T, E: core::fmt::Display>(
    operation: impl FnOnce() -> Result<T, E>,
) -> Result<T, String> {
    let (result, missing) = guarded(operation);
    if !missing.any() {
        return result.map_err(|error| error.to_string());
    }
    drop(result);
    if !restore(&missing) {
        tracing::warn!("a part of shared memory is lost to this process: {FULL}");
    }
    Err(FULL.to_owned())
}

/// Loans a chunk for one record: an answer, a request or a report. It has memory, so that the
/// record can be sent.
pub(crate) fn loan_record<L, T, E: core::fmt::Display>(
    loan: impl FnOnce() -> Result<L, E>,
    record: impl FnOnce(&mut L) -> &mut MaybeUninit<T>,
) -> Result<L, String> {
    let mut loaned = unless_full(loan)?;
    match reserve(core::slice::from_mut(record(&mut loaned))) {
        true => Ok(loaned),
        false => Err(FULL.to_owned()),
    }
}

#[cfg(target_os = "linux")]
mod linux {
    use core::cell::Cell;
    use core::mem::MaybeUninit;
    use core::ops::Range;
    use core::ptr;
    use std::sync::Once;

    use super::{MAX_PAGES, Missing};

    thread_local! {
        /// The pages that were missing so far, while a call of this thread is guarded.
        static MISSING: Cell<Option<Missing>> = const { Cell::new(None) };
    }

    /// Calls `operation`, and returns the pages of shared memory that it wrote to and that were
    /// missing.
    pub(crate) fn guarded<T>(operation: impl FnOnce() -> T) -> (T, Missing) {
        static INSTALLED: Once = Once::new();
        INSTALLED.call_once(install);
        let outer = MISSING.replace(Some(Missing::NONE));
        let result = operation();
        let missing = MISSING.replace(outer).unwrap_or(Missing::NONE);
        (result, missing)
    }

    /// Takes the pages of a chunk of shared memory from the file system. Returns `false` if there
    /// are too few.
    #[expect(unsafe_code, reason = "the standard library has no madvise")]
    pub(crate) fn reserve<T>(chunk: &mut [MaybeUninit<T>]) -> bool {
        let bytes = bytes(chunk);
        let (start, end) =
            (bytes.start / page_size() * page_size(), bytes.end.next_multiple_of(page_size()));
        let (start, length) = (start as *mut libc::c_void, end - start);
        // SAFETY: the range consists of pages that the chunk lies on, which are mapped; populating
        // them changes no contents.
        let result = unsafe { libc::madvise(start, length, libc::MADV_POPULATE_WRITE) };
        // Kernels before 5.14 don't know the call (EINVAL). Only an error of the memory itself
        // counts.
        let error = if result == 0 { None } else { std::io::Error::last_os_error().raw_os_error() };
        !matches!(error, Some(libc::EFAULT | libc::ENOMEM | libc::EHWPOISON))
    }

    /// Gives the pages back that lie within a chunk whose contents don't count.
    #[expect(unsafe_code, reason = "the standard library has no madvise")]
    pub(crate) fn release<T>(chunk: &mut [MaybeUninit<T>]) {
        let bytes = bytes(chunk);
        let (start, end) =
            (bytes.start.next_multiple_of(page_size()), bytes.end / page_size() * page_size());
        if start < end {
            // SAFETY: the range lies within the chunk, which the caller may write to, and reads as
            // zeros from here on. An error leaves the pages as they are.
            unsafe { libc::madvise(start as *mut _, end - start, libc::MADV_REMOVE) };
        }
    }

    /// Maps shared memory again where private pages have taken its place. Returns `false` if that
    /// isn't possible.
    pub(crate) fn restore(missing: &Missing) -> bool {
        missing.count <= MAX_PAGES
            && missing.addresses[..missing.count].iter().all(|page| restore_page(*page))
    }

    /// Maps the page of the same file that comes after the page before.
    #[expect(unsafe_code, reason = "a mapping is changed")]
    fn restore_page(page: usize) -> bool {
        let size = page_size();
        // SAFETY: with an old size of zero, `mremap` maps the pages of a shared mapping a second
        // time, at a new address: those from the page before on, which the segment's management
        // data or another chunk lies on. The first of them is unmapped again, and the second moves
        // to the place of the private page, to which only the guarded call has written.
        unsafe {
            let copy = libc::mremap((page - size) as *mut _, 0, 2 * size, libc::MREMAP_MAYMOVE);
            if copy == libc::MAP_FAILED {
                return false;
            }
            let second = copy.byte_add(size);
            let flags = libc::MREMAP_MAYMOVE | libc::MREMAP_FIXED;
            let moved = libc::mremap(second, size, size, flags, page as *mut libc::c_void);
            libc::munmap(copy, if moved == libc::MAP_FAILED { 2 * size } else { size });
            moved != libc::MAP_FAILED
        }
    }

    /// Returns the addresses of a chunk.
    fn bytes<T>(chunk: &mut [MaybeUninit<T>]) -> Range<usize> {
        let range = chunk.as_mut_ptr_range();
        range.start as usize..range.end as usize
    }

    fn page_size() -> usize {
        rustix::param::page_size()
    }

    /// Installs the handler of `SIGBUS`. If that fails, full memory ends the process as it does
    /// without the handler.
    #[expect(unsafe_code, reason = "the standard library handles no signals")]
    fn install() {
        // The handler reads the page size, which is looked up only once.
        page_size();
        // SAFETY: an all-zero `sigaction` is valid, and the handler has the signature that
        // SA_SIGINFO requires.
        unsafe {
            let mut action: libc::sigaction = core::mem::zeroed();
            let handler: extern "C" fn(libc::c_int, *mut libc::siginfo_t, *mut libc::c_void) =
                handle;
            action.sa_sigaction = handler as usize;
            action.sa_flags = libc::SA_SIGINFO | libc::SA_ONSTACK;
            libc::sigaction(libc::SIGBUS, &action, ptr::null_mut());
        }
    }

    /// Puts a private page where one of shared memory is missing; the write is then repeated. It
    /// does only what a signal handler may: system calls, and cells of this thread without
    /// destructors.
    #[expect(unsafe_code, reason = "a signal handler")]
    extern "C" fn handle(_: libc::c_int, info: *mut libc::siginfo_t, _: *mut libc::c_void) {
        // SAFETY: the kernel passes a valid siginfo_t, and SIGBUS sets its address.
        let address = unsafe { (*info).si_addr() } as usize;
        let page = address / page_size() * page_size();
        if MISSING.get().is_some_and(|missing| missing.count < usize::MAX) && map_private(page) {
            let mut missing = MISSING.get().unwrap_or(Missing::NONE);
            if let Some(slot) = missing.addresses.get_mut(missing.count) {
                *slot = page;
            }
            missing.count += 1;
            MISSING.set(Some(missing));
            return;
        }
        // SAFETY: restores the default, by which the repeated access ends the process.
        unsafe { libc::signal(libc::SIGBUS, libc::SIG_DFL) };
    }

    #[expect(unsafe_code, reason = "a mapping is changed")]
    fn map_private(page: usize) -> bool {
        let protection = libc::PROT_READ | libc::PROT_WRITE;
        let flags = libc::MAP_FIXED | libc::MAP_PRIVATE | libc::MAP_ANONYMOUS;
        // SAFETY: the page is part of a mapping that was just accessed and has no memory behind it:
        // nothing is lost.
        unsafe {
            libc::mmap(page as *mut _, page_size(), protection, flags, -1, 0) != libc::MAP_FAILED
        }
    }
}

#[cfg(not(target_os = "linux"))]
mod other {
    use core::mem::MaybeUninit;

    use super::Missing;

    pub(crate) fn guarded<T>(operation: impl FnOnce() -> T) -> (T, Missing) {
        (operation(), Missing::NONE)
    }

    pub(crate) fn reserve<T>(_chunk: &mut [MaybeUninit<T>]) -> bool {
        true
    }

    pub(crate) fn release<T>(_chunk: &mut [MaybeUninit<T>]) {}

    pub(crate) fn restore(_missing: &Missing) -> bool {
        false
    }
}
