//! The reader's side of frames and of the world.

use std::time::{Duration, Instant};

use iceoryx2::prelude::*;
use iceoryx2::sample::Sample;

use crate::error::{OpenError, ReadError};
use crate::fleet_name::FleetName;
use crate::frame::{Frame, FrameHeader, Line};
use crate::participant::Participant;
use crate::qos::{self, Ipc};
use crate::wake::Wake;
use crate::world::{World, WorldHeader};

/// Reads a fleet's frames: always the newest, at whatever pace. It can't slow the producer down.
///
/// It outlives producers: while there is none it has nothing new, and it goes on with the frames of the next.
#[derive(Debug)]
pub struct Subscriber {
    frames: iceoryx2::port::subscriber::Subscriber<Ipc, [Line], FrameHeader>,
    wake: Wake,
    /// The frame handed out last. Kept until the next is asked for, so that a [`Frame`] needs only to borrow.
    held: Option<Sample<Ipc, [Line], FrameHeader>>,
    service: qos::Frames,
    participant: Participant,
}

impl Subscriber {
    /// Opens the frames of a fleet, whether or not it has a producer yet.
    ///
    /// # Errors
    /// [`OpenError::OtherVersion`] if the fleet speaks another contract, [`OpenError::Full`] if it has
    /// [`MAX_READERS`](qos::MAX_READERS) readers, else [`OpenError::SharedMemory`].
    pub fn open(fleet: &FleetName) -> Result<Self, OpenError> {
        Self::open_on(&Participant::join(fleet, "reader")?)
    }

    /// The same, on a place that the process already has.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub fn open_on(participant: &Participant) -> Result<Self, OpenError> {
        let (node, fleet) = (&*participant.node, participant.fleet());
        let service = qos::frames(node, fleet)?;
        Ok(Self {
            frames: service
                .subscriber_builder()
                .create()
                .map_err(|e| qos::full_or(service.name(), qos::MAX_READERS, e))?,
            wake: Wake::open(participant, "wake")?,
            held: None,
            service,
            participant: participant.clone(),
        })
    }

    /// The newest frame, if there is one that this hasn't returned yet. Gives back the one before.
    ///
    /// # Errors
    /// [`ReadError`] if the connection to the producer is broken, or the frame contradicts its header.
    pub fn latest(&mut self) -> Result<Option<Frame<'_>>, ReadError> {
        let mut fresh = false;
        // A few rounds: what producers that have died since left unread comes before the frames of the living
        // one. No more, or a producer faster than this loop would keep it busy.
        for _ in 0..8 {
            if !self.has_newer()? {
                break;
            }
            self.held = None;
            self.held = self.frames.receive().map_err(|e| receive_error("a frame", e))?;
            fresh |= self.held.is_some();
        }
        if fresh { self.current() } else { Ok(None) }
    }

    /// The frame that [`latest`](Self::latest) returned last, unless it was [released](Self::release).
    ///
    /// # Errors
    /// [`ReadError::Malformed`] if the frame contradicts its header.
    pub fn current(&self) -> Result<Option<Frame<'_>>, ReadError> {
        let Some(sample) = &self.held else { return Ok(None) };
        match Frame::new(sample.user_header(), sample.payload()) {
            Some(frame) => Ok(Some(frame)),
            None => Err(ReadError::Malformed { what: "a frame", lines: sample.payload().len() }),
        }
    }

    /// Whether [`latest`](Self::latest) would return a frame.
    ///
    /// # Errors
    /// [`ReadError::Receive`] if the connection to the producer is broken.
    pub fn has_newer(&self) -> Result<bool, ReadError> {
        self.frames.has_samples().map_err(|e| receive_error("a frame", e))
    }

    /// Gives the held frame back, so that its memory can serve another.
    pub fn release(&mut self) {
        self.held = None;
    }

    /// The newest frame, as soon as there is one that this hasn't returned yet; `None` when `timeout` has
    /// passed, or earlier when a signal has arrived.
    ///
    /// # Errors
    /// As [`latest`](Self::latest).
    pub fn wait(&mut self, timeout: Duration) -> Result<Option<Frame<'_>>, ReadError> {
        let deadline = Instant::now() + timeout;
        while !self.has_newer()? {
            self.wake.forget()?;
            let left = deadline.saturating_duration_since(Instant::now());
            if self.has_newer()? || left.is_zero() || !self.wake.sleep(left)? {
                break;
            }
        }
        self.latest()
    }

    /// Whether the fleet has a producer. One that was killed counts until another process joins the fleet.
    pub fn has_producer(&self) -> bool {
        self.service.dynamic_config().number_of_publishers() > 0
    }

    /// Removes what dead processes left at this service, so that [`has_producer`](Self::has_producer) is exact.
    /// Takes a millisecond or so.
    pub fn forget_dead(&self) {
        self.service.try_cleanup_dead_nodes();
    }

    /// The place in the fleet that this is opened on.
    pub fn participant(&self) -> &Participant {
        &self.participant
    }
}

/// Reads a fleet's route graph and robot types.
#[derive(Debug)]
pub struct WorldReader {
    worlds: iceoryx2::port::subscriber::Subscriber<Ipc, [Line], WorldHeader>,
    held: Option<Sample<Ipc, [Line], WorldHeader>>,
}

impl WorldReader {
    /// Opens the world of a fleet.
    ///
    /// # Errors
    /// As [`Subscriber::open`].
    pub fn open(fleet: &FleetName) -> Result<Self, OpenError> {
        Self::open_on(&Participant::join(fleet, "reader")?)
    }

    /// The same, on a place that the process already has.
    ///
    /// # Errors
    /// As [`Subscriber::open`].
    pub fn open_on(participant: &Participant) -> Result<Self, OpenError> {
        let service = qos::world(&participant.node, participant.fleet())?;
        let worlds =
            service.subscriber_builder().create().map_err(|e| qos::full_or(service.name(), qos::MAX_READERS, e))?;
        Ok(Self { worlds, held: None })
    }

    /// The newest world, if there is one that this hasn't returned yet.
    ///
    /// # Errors
    /// [`ReadError`] if the connection to the producer is broken, or the world contradicts its header.
    pub fn latest(&mut self) -> Result<Option<World<'_>>, ReadError> {
        let mut fresh = false;
        for _ in 0..8 {
            if !self.worlds.has_samples().map_err(|e| receive_error("the world", e))? {
                break;
            }
            self.held = None;
            self.held = self.worlds.receive().map_err(|e| receive_error("the world", e))?;
            fresh |= self.held.is_some();
        }
        if fresh { self.current() } else { Ok(None) }
    }

    /// The world that [`latest`](Self::latest) returned last.
    ///
    /// # Errors
    /// [`ReadError::Malformed`] if the world contradicts its header.
    pub fn current(&self) -> Result<Option<World<'_>>, ReadError> {
        let Some(sample) = &self.held else { return Ok(None) };
        match World::split(sample.user_header(), sample.payload()) {
            Some(world) => Ok(Some(world)),
            None => Err(ReadError::Malformed { what: "the world", lines: sample.payload().len() }),
        }
    }
}

/// Most samples that a look for the newest goes through: what publishers that have died since left unread comes before
/// those of the living one. No more, or a publisher faster than the reader would keep it busy.
pub(crate) const MOST_ROUNDS: u64 = 2 * crate::qos::COLUMN_BUFFER as u64;

pub(crate) fn receive_error(what: &'static str, error: impl core::fmt::Display) -> ReadError {
    ReadError::Receive { what, reason: error.to_string() }
}
