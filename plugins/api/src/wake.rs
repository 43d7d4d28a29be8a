//! Sleeping until another process has news.

use std::os::fd::BorrowedFd;
use std::time::Duration;

use iceoryx2::port::listener::{Listener, ListenerWaitError};
use iceoryx2::prelude::*;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;

use crate::error::{OpenError, ReadError};
use crate::participant::Participant;
use crate::qos::{self, Ipc};

/// Upper bound of one sleep: what a wake-up that got lost would cost.
const NAP: Duration = Duration::from_millis(100);

/// The sleeper's end of one of a fleet's event services.
///
/// It polls the listener's socket rather than wait on the listener, which empties the socket by a dozen
/// system calls before it returns: here they come after the news has been looked at, before the next sleep.
#[derive(Debug)]
pub(crate) struct Wake {
    listener: Listener<Ipc>,
}

impl Wake {
    pub(crate) fn open(participant: &Participant, service: &str) -> Result<Self, OpenError> {
        let service = qos::event(&participant.node, participant.fleet(), service)?;
        Ok(Self { listener: qos::listener(&service)? })
    }

    /// Forgets the wake-ups so far. To be followed by a look for the news that they were for: what is sent
    /// after this look will wake.
    pub(crate) fn forget(&self) -> Result<(), ReadError> {
        match self.listener.try_wait(|_| ()) {
            Ok(_) | Err(ListenerWaitError::InterruptSignal) => Ok(()),
            Err(error) => Err(wake_error(error)),
        }
    }

    /// Sleeps until woken, or for `left`, or for a [`NAP`]. `false` when a signal ended it.
    #[expect(unsafe_code, reason = "iceoryx2's descriptor has no safe conversion to the standard library's")]
    pub(crate) fn sleep(&self, left: Duration) -> Result<bool, ReadError> {
        // SAFETY: the listener owns the descriptor, and outlives this borrow of it, which ends with the function.
        let socket = unsafe { BorrowedFd::borrow_raw(self.listener.file_descriptor().native_handle()) };
        let timeout = Timespec { tv_sec: 0, tv_nsec: left.min(NAP).as_nanos() as i64 };
        match poll(&mut [PollFd::new(&socket, PollFlags::IN)], Some(&timeout)) {
            Ok(_) => Ok(true),
            Err(Errno::INTR) => Ok(false),
            Err(error) => Err(wake_error(error)),
        }
    }
}

fn wake_error(error: impl core::fmt::Display) -> ReadError {
    ReadError::Receive { what: "a wake-up", reason: error.to_string() }
}
