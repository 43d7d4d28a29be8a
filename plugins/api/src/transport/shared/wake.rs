//! The ends of event services: waking other processes, and sleeping until woken.

use std::time::Duration;

use iceoryx2::port::listener::{Listener, ListenerWaitError};

use super::Ipc;
use super::full_memory::receive_error;
use super::open::event;
use super::places::place;
use crate::ports::error::{OpenError, ReadError};
use crate::ports::services::MAX_READERS;
use crate::process::join::Participant;

/// The notifying end of an event service.
pub(crate) type Notifier = iceoryx2::port::notifier::Notifier<Ipc>;

/// Opens the notifying end of an event service.
pub(crate) fn notifier(participant: &Participant, service: &str) -> Result<Notifier, OpenError> {
    let service = event(participant, service)?;
    place(&service, MAX_READERS, || service.notifier_builder().create())
}

/// The longest sleep, which bounds the cost of a lost wake-up.
const NAP: Duration = Duration::from_millis(100);

/// The listening end of one of a fleet's event services.
///
/// It polls the listener's socket rather than waiting on the listener, which empties the socket by
/// a dozen system calls before it returns: here they come after the news has been read, before the
/// next sleep.
#[derive(Debug)]
pub(crate) struct Wake {
    listener: Listener<Ipc>,
}

impl Wake {
    /// Opens the event service of a name.
    pub(crate) fn open(participant: &Participant, service: &str) -> Result<Self, OpenError> {
        let service = event(participant, service)?;
        let listener = place(&service, MAX_READERS, || service.listener_builder().create())?;
        Ok(Self { listener })
    }

    /// Forgets the wake-ups so far. Must be followed by a check for the news that they announced:
    /// samples that are sent after this check wake again.
    pub(crate) fn forget(&self) -> Result<(), ReadError> {
        match self.listener.try_wait(|_| ()) {
            Ok(_) | Err(ListenerWaitError::InterruptSignal) => Ok(()),
            Err(error) => Err(wake_error(error)),
        }
    }

    /// Sleeps until woken, but no longer than `left` or a [`NAP`]. Returns `false` if a signal
    /// ended the sleep.
    #[cfg(unix)]
    #[expect(
        unsafe_code,
        reason = "iceoryx2's descriptor has no safe conversion to the standard library's"
    )]
    pub(crate) fn sleep(&self, left: Duration) -> Result<bool, ReadError> {
        use iceoryx2::prelude::FileDescriptorBased;
        use rustix::event::{PollFd, PollFlags, Timespec, poll};
        use rustix::io::Errno;
        use std::os::fd::BorrowedFd;

        // SAFETY: the listener owns the descriptor, and outlives this borrow of it, which ends with
        // the function.
        let socket =
            unsafe { BorrowedFd::borrow_raw(self.listener.file_descriptor().native_handle()) };
        let timeout = Timespec { tv_sec: 0, tv_nsec: left.min(NAP).as_nanos() as i64 };
        match poll(&mut [PollFd::new(&socket, PollFlags::IN)], Some(&timeout)) {
            Ok(_) => Ok(true),
            Err(Errno::INTR) => Ok(false),
            Err(error) => Err(wake_error(error)),
        }
    }

    /// Sleeps until woken, but no longer than `left` or a [`NAP`]. Returns `false` if a signal
    /// ended the sleep.
    #[cfg(not(unix))]
    pub(crate) fn sleep(&self, left: Duration) -> Result<bool, ReadError> {
        match self.listener.timed_wait(|_| (), left.min(NAP)) {
            Ok(_) => Ok(true),
            Err(ListenerWaitError::InterruptSignal) => Ok(false),
            Err(error) => Err(wake_error(error)),
        }
    }
}

fn wake_error(error: impl core::fmt::Display) -> ReadError {
    receive_error("a wake-up", error)
}
