//! Lockstep: the one case in which a producer waits for readers, because it was asked to by name.
//!
//! While a frame's `lockstep` is nonzero, each reader reports on `regatta/F/done` which tick it has finished,
//! after it has sent its orders for it. [`run`](crate::run) does so for every plugin.

use std::collections::HashMap;
use std::time::{Duration, Instant};

use bytemuck::{Pod, Zeroable};
use iceoryx2::port::notifier::Notifier;
use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::*;

use crate::error::{OpenError, PublishError, ReadError};
use crate::participant::Participant;
use crate::publish::Producer;
use crate::qos::{self, Ipc};
use crate::subscribe::receive_error;
use crate::termination::Termination;
use crate::wake::Wake;
use crate::world::{padded, text};

/// A reader's report that it has finished a tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable, ZeroCopySend)]
#[repr(C)]
#[type_name("regatta_Done")]
pub struct Done {
    /// The run.
    pub run_id: u64,
    /// The tick.
    pub tick: u64,
    /// The reader's name in UTF-8, padded with zeros.
    pub name: [u8; 64],
}

/// Why a tick in lockstep doesn't end.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LockstepError {
    /// Not all of them have finished in time.
    #[error("tick {tick}: no report within {:.1} s from {}; are they running, under these names?", timeout.as_secs_f32(), missing.join(", "))]
    Timeout {
        /// The tick waited for.
        tick: u64,
        /// How long.
        timeout: Duration,
        /// Names of the readers that haven't reported it.
        missing: Vec<String>,
    },
    /// A signal has arrived meanwhile. Whoever waits looks whether it is to stop, or else waits again.
    #[error("waiting for tick {tick} was interrupted by a signal")]
    Interrupted {
        /// The tick waited for.
        tick: u64,
    },
    /// Reports can't be read.
    #[error(transparent)]
    Read(#[from] ReadError),
}

/// How long a producer spins before it sleeps: a reader that is nearly done costs it no wake-up.
const SPIN: Duration = Duration::from_micros(20);

/// The producer's end: the last tick that each reader has reported.
#[derive(Debug)]
pub(crate) struct Collector {
    reports: Subscriber<Ipc, Done, ()>,
    wake: Wake,
    finished: HashMap<String, u64>,
}

impl Collector {
    pub(crate) fn open(participant: &Participant) -> Result<Self, OpenError> {
        let service = qos::done(&participant.node, participant.fleet())?;
        Ok(Self {
            reports: service.subscriber_builder().create().map_err(|e| qos::full_or(service.name(), 1, e))?,
            wake: Wake::open(participant, "done")?,
            finished: HashMap::new(),
        })
    }

    fn collect(&mut self, run_id: u64) -> Result<(), ReadError> {
        while let Some(done) = self.reports.receive().map_err(|e| receive_error("lockstep reports", e))? {
            if done.run_id == run_id {
                self.finished.insert(text(&done.name).to_owned(), done.tick);
            }
        }
        Ok(())
    }

    /// Starts afresh, for another run: its ticks may have lower numbers.
    pub(crate) fn forget(&mut self) {
        self.finished.clear();
    }

    fn missing<'a>(&'a self, names: &'a [String], tick: u64) -> impl Iterator<Item = &'a String> {
        names.iter().filter(move |name| self.finished.get(*name).is_none_or(|&done| done < tick))
    }
}

impl Producer {
    /// Waits until each of the named readers has reported that it has finished `tick`.
    ///
    /// # Errors
    /// [`LockstepError::Timeout`] names those that haven't when `timeout` has passed;
    /// [`LockstepError::Interrupted`] when a signal arrives, or this process was asked to end.
    pub fn wait_done(&mut self, names: &[String], tick: u64, timeout: Duration) -> Result<(), LockstepError> {
        let start = Instant::now();
        loop {
            let waited = start.elapsed();
            let sleeps = waited >= SPIN;
            if sleeps {
                // A reader that joins now has to get the frame that it is waited for.
                self.update();
                self.collector.wake.forget()?;
            }
            self.collector.collect(self.run_id())?;
            let mut missing = self.collector.missing(names, tick).peekable();
            if missing.peek().is_none() {
                return Ok(());
            }
            if waited >= timeout {
                return Err(LockstepError::Timeout { tick, timeout, missing: missing.cloned().collect() });
            }
            // The signal may have come before the sleep, which it then doesn't end.
            if Termination::was_requested() {
                return Err(LockstepError::Interrupted { tick });
            }
            if !sleeps {
                core::hint::spin_loop();
            } else if !self.collector.wake.sleep(timeout - waited)? {
                return Err(LockstepError::Interrupted { tick });
            }
        }
    }
}

/// A reader's end: reports ticks under its name.
#[derive(Debug)]
pub struct Reporter {
    reports: Publisher<Ipc, Done, ()>,
    wake: Notifier<Ipc>,
    name: [u8; 64],
}

impl Reporter {
    /// Opens the reports of a fleet, under the name that the process joined by.
    ///
    /// # Errors
    /// [`OpenError::OtherVersion`] if the fleet speaks another contract, [`OpenError::Full`] if it has
    /// [`MAX_READERS`](qos::MAX_READERS) reporters, else [`OpenError::SharedMemory`].
    pub fn open_on(participant: &Participant) -> Result<Self, OpenError> {
        let service = qos::done(&participant.node, participant.fleet())?;
        Ok(Self {
            reports: service
                .publisher_builder()
                .max_loaned_samples(1)
                .backpressure_strategy(BackpressureStrategy::DiscardData)
                .create()
                .map_err(|e| qos::full_or(service.name(), qos::MAX_READERS, e))?,
            wake: qos::notifier(&qos::event(&participant.node, participant.fleet(), "done")?)?,
            name: padded(participant.name()),
        })
    }

    /// Reports that a tick is finished.
    ///
    /// # Errors
    /// [`PublishError`] if it can't be delivered.
    pub fn done(&self, run_id: u64, tick: u64) -> Result<(), PublishError> {
        self.reports
            .send_copy(Done { run_id, tick, name: self.name })
            .map_err(|e| PublishError::Send { what: "a lockstep report", reason: e.to_string() })?;
        if let Err(error) = self.wake.notify() {
            tracing::debug!(%error, "waking the producer");
        }
        Ok(())
    }
}
