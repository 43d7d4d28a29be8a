//! Lockstep: the one case in which a producer waits for readers, because it was asked to by name.
//!
//! While a frame's `lockstep` is nonzero, each reader reports on `regatta/F/done` which tick it has
//! finished, after it has sent its commands and columns for it. [`run`](crate::run) does so for
//! every plugin. The producer waits for the reports of the readers that it was told to wait for. A
//! reader that comes *after* others waits for their reports, too, before it handles the frame: then
//! it finds their columns of the same tick.

use core::time::Duration;
use std::time::Instant;

use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::port::update_connections::UpdateConnections;
use iceoryx2::prelude::*;

pub use super::error::LockstepError;
use super::error::{OpenError, PublishError, ReadError};
use super::producer::ProducerPorts;
use super::services;
use crate::process::join::Participant;
use crate::process::termination::Termination;
pub use crate::records::lockstep::Done;
use crate::records::{padded, text};
use crate::transport::shared::{Ipc, done, loan_record, place, received, unless_full};
use crate::transport::{Notifier, Wake};

/// The receiving end of reports: the last tick that each reader has finished.
pub(crate) struct DoneReports {
    reports: Subscriber<Ipc, Done, ()>,
    wake: Wake,
    finished: Vec<Done>,
    /// The readers that have left since this was last asked for.
    left: Vec<String>,
}

impl DoneReports {
    /// Opens the reports of a fleet. Readers that have reported before report their last tick
    /// again.
    pub(crate) fn open(participant: &Participant) -> Result<Self, OpenError> {
        let service = done(participant)?;
        let reports =
            place(&service, services::MAX_READERS, || service.subscriber_builder().create())?;
        Ok(Self {
            reports,
            wake: Wake::open(participant, "done")?,
            finished: Vec::new(),
            left: Vec::new(),
        })
    }

    /// Returns the readers that have left since the last call.
    pub(crate) fn take_left(&mut self) -> Vec<String> {
        std::mem::take(&mut self.left)
    }

    /// Returns the readers among `names` that haven't finished a tick of a run yet.
    pub(crate) fn missing<'a>(
        &mut self,
        names: &'a [String],
        run_id: u64,
        tick: u64,
    ) -> Result<impl Iterator<Item = &'a String>, ReadError> {
        while let Some(done) = received("lockstep reports", || self.reports.receive())? {
            if done.tick == Done::LEFT {
                self.left.push(text(&done.name).to_owned());
            }
            match self.finished.iter_mut().find(|before| before.name == done.name) {
                Some(before) => *before = *done,
                None => self.finished.push(*done),
            }
        }
        Ok(names.iter().filter(move |name| {
            !self.finished.iter().any(|done| {
                text(&done.name) == **name && done.run_id == run_id && done.tick >= tick
            })
        }))
    }

    /// Forgets the wake-ups so far. Must be followed by a check for [missing](Self::missing)
    /// readers.
    pub(crate) fn forget_wake_ups(&self) -> Result<(), ReadError> {
        self.wake.forget()
    }

    /// Sleeps until a reader reports, for about a tenth of a second or `left` at most. Returns
    /// `false` if a signal ended it.
    pub(crate) fn sleep(&self, left: Duration) -> Result<bool, ReadError> {
        self.wake.sleep(left)
    }
}

impl ProducerPorts {
    /// Waits until each of the named readers has reported that it has finished `tick`. Doesn't wait
    /// in a local fleet, where a driver calls the readers.
    ///
    /// # Errors
    /// [`LockstepError::Timeout`] names those that haven't when `timeout` has passed;
    /// [`LockstepError::Interrupted`] when a signal arrives, or this process was asked to end.
    pub fn wait_done(
        &mut self,
        names: &[String],
        tick: u64,
        timeout: Duration,
    ) -> Result<(), LockstepError> {
        let Some(mut reports) = self.reports.take() else { return Ok(()) };
        let outcome = self.wait_for(&mut reports, names, tick, timeout);
        if outcome.is_ok() {
            tell_who_left(self.participant(), &reports.take_left(), names);
        }
        self.reports = Some(reports);
        outcome
    }

    fn wait_for(
        &self,
        reports: &mut DoneReports,
        names: &[String],
        tick: u64,
        timeout: Duration,
    ) -> Result<(), LockstepError> {
        /// The time to spin before sleeping: a reader that is nearly done then costs no wake-up.
        const SPIN: Duration = Duration::from_micros(20);
        let start = Instant::now();
        loop {
            let waited = start.elapsed();
            let sleeps = waited >= SPIN;
            if sleeps {
                // A reader that joins now has to get the frame that the producer waits for.
                self.update();
                reports.forget_wake_ups()?;
            }
            let mut missing = reports.missing(names, self.run_id(), tick)?.peekable();
            if missing.peek().is_none() {
                return Ok(());
            }
            if waited >= timeout {
                let missing = missing.cloned().collect();
                return Err(LockstepError::Timeout { tick, timeout, missing });
            }
            drop(missing);
            // The signal may have come before the sleep, which it then doesn't end.
            if Termination::was_requested() {
                return Err(LockstepError::Interrupted { tick });
            }
            if !sleeps {
                core::hint::spin_loop();
            } else if !reports.sleep(timeout - waited)? {
                return Err(LockstepError::Interrupted { tick });
            }
        }
    }
}

/// Tells the user, once, that readers have left the lockstep.
fn tell_who_left(participant: &Participant, left: &[String], names: &[String]) {
    for name in left {
        if names.contains(name) && !Termination::was_requested() {
            let (producer, fleet) = (participant.name(), participant.fleet());
            crate::tell!(
                "{producer}: fleet '{fleet}': {name} has left the lockstep; the run continues \
                 without waiting for it"
            );
        }
    }
}

/// A reader's sending end: reports ticks under the reader's name. [`run`](crate::run) has one for
/// each plugin.
///
/// ```no_run
/// use std::time::Duration;
///
/// use regatta_plugin::{FleetName, Participant, Reporter, Result, Subscriber};
///
/// # fn main() -> Result {
/// let participant = Participant::join(&FleetName::default(), "planner")?;
/// let reporter = Reporter::open_on(&participant)?;
/// let mut frames = Subscriber::open_on(&participant)?;
/// while let Some(frame) = frames.wait(Duration::from_secs(10))? {
///     // Send commands and columns for the tick here.
///     reporter.done(frame.run_id(), frame.tick())?;
/// }
/// # Ok(())
/// # }
/// ```
pub struct Reporter {
    reports: Publisher<Ipc, Done, ()>,
    wake: Notifier,
    name: [u8; 64],
}

impl Reporter {
    /// Opens the reports of a fleet, under the name by which the process joined.
    ///
    /// # Errors
    /// [`OpenError::OtherVersion`] if the fleet uses another contract, [`OpenError::Full`] if it
    /// has [`MAX_READERS`](services::MAX_READERS) reporters, else [`OpenError::SharedMemory`].
    pub fn open_on(participant: &Participant) -> Result<Self, OpenError> {
        let service = done(participant)?;
        let reports = place(&service, services::MAX_READERS, || {
            let builder = service.publisher_builder().max_loaned_samples(1);
            builder.backpressure_strategy(BackpressureStrategy::DiscardData).create()
        })?;
        Ok(Self {
            reports,
            wake: Notifier::open(participant, "done")?,
            name: padded(participant.name()),
        })
    }

    /// Reports that a tick is finished. All commands and columns for it must have been sent before.
    ///
    /// # Errors
    /// [`PublishError`] if the report can't be delivered.
    pub fn done(&self, run_id: u64, tick: u64) -> Result<(), PublishError> {
        let done = Done { run_id, tick, name: self.name };
        let loaned = loan_record(|| self.reports.loan_uninit(), |loaned| loaned.payload_mut());
        let sent = loaned.and_then(|loaned| unless_full(|| loaned.write_payload(done).send()));
        sent.map_err(|reason| PublishError::Send { what: "a lockstep report", reason })?;
        self.wake.notify();
        Ok(())
    }

    /// Reports that this reader leaves the lockstep of a run, so that no process waits for it any
    /// more. To be called before a reader ends; a run whose reader ends without it, or dies, ends
    /// by [`LockstepError::Timeout`].
    ///
    /// # Errors
    /// [`PublishError`] if the report can't be delivered.
    pub fn leave(&self, run_id: u64) -> Result<(), PublishError> {
        self.done(run_id, Done::LEFT)
    }

    /// Gives the last report to readers that have joined since and come after this one. To be
    /// called every now and then while no frame comes.
    pub fn update(&self) {
        if let Err(error) = unless_full(|| self.reports.update_connections()) {
            tracing::debug!(%error, "connecting readers of lockstep reports");
        }
    }
}

impl core::fmt::Debug for Reporter {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Reporter").field("name", &text(&self.name)).finish_non_exhaustive()
    }
}
