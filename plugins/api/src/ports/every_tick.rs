//! The receiving end of a service that carries records tick by tick.

use core::fmt::Debug;

use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::*;

use super::error::{OpenError, ReadError};
use super::full_memory::received;
use super::places::place;
use super::services::{self, Ipc, SliceService};
use crate::process::join::Participant;
use crate::records::sequence::{LostSamples, Sequenced};

/// The records of one tick, borrowed from shared memory.
#[derive(Clone, Copy, Debug)]
pub struct TickRecords<'sample, H, T> {
    /// The tick.
    pub header: &'sample H,
    /// The records, in the order in which they happened.
    pub records: &'sample [T],
    /// The number of samples (ticks with records) that this reader lost between the last one and
    /// this one, because it was too slow.
    pub missed: u64,
}

/// Reads the records of a service tick by tick. A reader that lags more than
/// [`EVENT_BUFFER`](services::EVENT_BUFFER) samples behind loses the oldest, and gets their number.
#[derive(Debug)]
pub struct TickReader<H, T>
where
    T: Debug + ZeroCopySend + 'static,
    H: Debug + Sequenced + ZeroCopySend + 'static,
{
    port: Subscriber<Ipc, [T], H>,
    lost: LostSamples,
    what: &'static str,
}

impl<H, T> TickReader<H, T>
where
    T: Debug + ZeroCopySend + 'static,
    H: Debug + Sequenced + ZeroCopySend + 'static,
{
    pub(super) fn of(
        service: &SliceService<T, H>,
        participant: &Participant,
    ) -> Result<Self, OpenError> {
        let opened = service.open(participant)?;
        let port = place(&opened, services::MAX_READERS, || opened.subscriber_builder().create())?;
        Ok(Self { port, lost: LostSamples::default(), what: service.subject })
    }

    /// Passes all samples that have arrived to `each`, oldest first.
    ///
    /// # Errors
    /// [`ReadError::Receive`] if the connection to the publisher is broken, else the error of
    /// `each`.
    pub fn take<E: From<ReadError>>(
        &mut self,
        mut each: impl FnMut(&TickRecords<'_, H, T>) -> Result<(), E>,
    ) -> Result<(), E> {
        // Bounded, so that a publisher faster than `each` can't keep a reader from its frames.
        for _ in 0..2 * services::EVENT_BUFFER {
            let Some(sample) = received(self.what, || self.port.receive())? else { break };
            let header = sample.user_header();
            let missed = self.lost.before(header);
            each(&TickRecords { header, records: sample.payload(), missed })?;
        }
        Ok(())
    }

    /// The number of samples that this reader has lost so far.
    pub fn lost(&self) -> u64 {
        self.lost.total()
    }
}
