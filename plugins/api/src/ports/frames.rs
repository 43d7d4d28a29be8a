//! The reader's side of frames.

use std::time::{Duration, Instant};

use super::error::{OpenError, ReadError};
use super::receive::Newest;
use super::services;
use crate::process::join::Participant;
use crate::records::frame::{Frame, FrameHeader, Line};
use crate::records::name::FleetName;
use crate::transport::Wake;

/// Reads a fleet's frames: always the newest, at any pace. It can't slow the producer down.
///
/// It outlives producers: without one it has nothing new, and it continues with the frames of the
/// next.
///
/// ```no_run
/// use std::time::Duration;
///
/// use regatta_plugin::{FleetName, Result, Subscriber};
///
/// # fn main() -> Result {
/// let mut frames = Subscriber::open(&FleetName::default())?;
/// while let Some(frame) = frames.wait(Duration::from_secs(10))? {
///     println!("tick {}: {} robots", frame.tick(), frame.len());
/// }
/// # Ok(())
/// # }
/// ```
pub struct Subscriber {
    frames: Newest<Line, FrameHeader>,
    wake: Wake,
    participant: Participant,
}

impl Subscriber {
    /// Opens the frames of a fleet, whether or not it has a producer yet.
    ///
    /// # Errors
    /// [`OpenError::OtherVersion`] if the fleet uses another contract, [`OpenError::Full`] if it
    /// has [`MAX_READERS`](services::MAX_READERS) readers, else [`OpenError::SharedMemory`].
    pub fn open(fleet: &FleetName) -> Result<Self, OpenError> {
        Self::open_on(&Participant::join(fleet, "reader")?)
    }

    /// Opens the frames for a process that has joined the fleet.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub fn open_on(participant: &Participant) -> Result<Self, OpenError> {
        Ok(Self {
            frames: Newest::open(&services::FRAMES, participant)?,
            wake: Wake::open(participant, "wake")?,
            participant: participant.clone(),
        })
    }

    /// Returns the newest frame, if there is one that this hasn't returned yet. Gives back the one
    /// before.
    ///
    /// # Errors
    /// [`ReadError`] if the connection to the producer is broken, or the frame contradicts its
    /// header.
    pub fn latest(&mut self) -> Result<Option<Frame<'_>>, ReadError> {
        if self.frames.take_newest()? { self.current() } else { Ok(None) }
    }

    /// The frame that [`latest`](Self::latest) returned last, unless it was
    /// [released](Self::release).
    ///
    /// # Errors
    /// [`ReadError::Malformed`] if the frame contradicts its header.
    pub fn current(&self) -> Result<Option<Frame<'_>>, ReadError> {
        let Some((header, lines)) = self.frames.held() else { return Ok(None) };
        match Frame::new(header, lines) {
            Some(frame) => Ok(Some(frame.after_missing(self.frames.missed()))),
            None => Err(ReadError::Malformed { what: "a frame", lines: lines.len() }),
        }
    }

    /// Whether [`latest`](Self::latest) would return a frame.
    ///
    /// # Errors
    /// [`ReadError::Receive`] if the connection to the producer is broken.
    pub fn has_newer(&self) -> Result<bool, ReadError> {
        self.frames.has_newer()
    }

    /// Gives the held frame back, so that its memory can serve another.
    pub fn release(&mut self) {
        self.frames.release();
    }

    /// Waits for a frame that this hasn't returned yet, and returns the newest; `None` when
    /// `timeout` has passed, or earlier when a signal has arrived.
    ///
    /// # Errors
    /// As [`latest`](Self::latest).
    pub fn wait(&mut self, timeout: Duration) -> Result<Option<Frame<'_>>, ReadError> {
        let start = Instant::now();
        while !self.has_newer()? {
            self.forget_wake_ups()?;
            let left = timeout.saturating_sub(start.elapsed());
            if self.has_newer()? || left.is_zero() || !self.sleep(left)? {
                break;
            }
        }
        self.latest()
    }

    /// Forgets the wake-ups so far. Must be followed by a check for news, before
    /// [`sleep`](Self::sleep).
    pub(crate) fn forget_wake_ups(&self) -> Result<(), ReadError> {
        self.wake.forget()
    }

    /// Sleeps until the producer wakes its readers, for about a tenth of a second or `left` at
    /// most. Returns `false` if a signal ended it.
    pub(crate) fn sleep(&self, left: Duration) -> Result<bool, ReadError> {
        self.wake.sleep(left)
    }

    /// Whether the fleet has a producer. One that was killed counts until another process joins the
    /// fleet.
    pub fn has_producer(&self) -> bool {
        self.frames.has_publisher()
    }

    /// Removes the resources of dead processes at this service, so that
    /// [`has_producer`](Self::has_producer) is exact. Takes a millisecond or so.
    pub fn forget_dead(&self) {
        self.frames.forget_dead();
    }

    /// The fleet that this reads, and the name of this process in it.
    pub fn participant(&self) -> &Participant {
        &self.participant
    }
}

impl core::fmt::Debug for Subscriber {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Subscriber").field("frames", &self.frames).finish_non_exhaustive()
    }
}
