//! The receiving ends of publish-subscribe services: [`Newest`] for readers of the newest sample,
//! or of all of the last few, and [`TickReader`] for readers of the records of every tick.

use super::error::{OpenError, ReadError};
use super::services::{self, SliceService};
use crate::process::join::Participant;
use crate::records::name::ColumnName;
use crate::records::sequence::{LostSamples, Sequenced};
use crate::records::{Header, Record};
use crate::transport::{Sample, Subscriber};

/// The largest number of samples that one search for the newest goes through: samples that dead
/// publishers left unread come before those of the living one. It is bounded so that a publisher
/// faster than the reader can't keep it busy.
const MAX_ROUNDS: u64 = 2 * services::COLUMN_BUFFER as u64;

/// Takes samples of records `T` under headers `H`, and holds the last one, which readers borrow.
pub(super) struct Newest<T: Record, H: Header + Sequenced> {
    port: Subscriber<T, H>,
    held: Option<Sample<T, H>>,
    lost: LostSamples,
    /// Samples between the one that was handed out before and the held one.
    missed: u64,
}

impl<T: Record, H: Header + Sequenced> Newest<T, H> {
    /// Opens the receiving end of a service for the newest sample.
    pub(super) fn open(
        service: &SliceService<T, H>,
        participant: &Participant,
    ) -> Result<Self, OpenError> {
        Self::with_buffer(service, participant, 1)
    }

    /// Opens the receiving end of a service. The last `buffer` samples wait to be taken.
    pub(super) fn with_buffer(
        service: &SliceService<T, H>,
        participant: &Participant,
        buffer: usize,
    ) -> Result<Self, OpenError> {
        Self::named(service, service.name, participant, buffer)
    }

    /// Opens the receiving end of a column.
    pub(super) fn of_column(
        service: &SliceService<T, H>,
        participant: &Participant,
        name: &ColumnName,
        buffer: usize,
    ) -> Result<Self, OpenError> {
        Self::named(service, &services::column_service(name), participant, buffer)
    }

    fn named(
        service: &SliceService<T, H>,
        name: &str,
        participant: &Participant,
        buffer: usize,
    ) -> Result<Self, OpenError> {
        let port = Subscriber::open(service, name, participant, buffer)?;
        Ok(Self { port, held: None, lost: LostSamples::default(), missed: 0 })
    }

    /// Whether a process publishes the service. One that was killed counts until another process
    /// joins the fleet.
    pub(super) fn has_publisher(&self) -> bool {
        self.port.has_publisher()
    }

    /// Removes the resources of dead processes at the service, so that
    /// [`has_publisher`](Self::has_publisher) is exact. Takes a millisecond or so.
    pub(super) fn forget_dead(&self) {
        self.port.forget_dead();
    }

    /// Whether a sample waits to be taken.
    pub(super) fn has_newer(&self) -> Result<bool, ReadError> {
        self.port.has_samples()
    }

    /// Holds the oldest sample that waits, and returns whether there was one.
    pub(super) fn take_next(&mut self) -> Result<bool, ReadError> {
        self.missed = 0;
        self.receive()
    }

    /// Holds the newest sample, and returns whether there was one that wasn't taken yet.
    pub(super) fn take_newest(&mut self) -> Result<bool, ReadError> {
        let mut received = 0;
        self.missed = 0;
        while received < MAX_ROUNDS && self.receive()? {
            received += 1;
        }
        self.missed += received.saturating_sub(1);
        Ok(received > 0)
    }

    fn receive(&mut self) -> Result<bool, ReadError> {
        if !self.has_newer()? {
            return Ok(false);
        }
        // Given back first: a reader may hold few samples at a time.
        self.held = None;
        self.held = self.port.receive()?;
        if let Some(sample) = &self.held {
            self.missed += self.lost.before(sample.header());
        }
        Ok(self.held.is_some())
    }

    /// The held sample.
    pub(super) fn held(&self) -> Option<(&H, &[T])> {
        self.held.as_ref().map(|sample| (sample.header(), sample.records()))
    }

    /// The number of samples that were published between the one that was handed out before and the
    /// held one.
    pub(super) fn missed(&self) -> u64 {
        self.missed
    }

    /// Gives the held sample back, so that its memory can serve another.
    pub(super) fn release(&mut self) {
        self.held = None;
    }
}

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
pub struct TickReader<H: Header + Sequenced, T: Record> {
    port: Subscriber<T, H>,
    lost: LostSamples,
}

impl<H: Header + Sequenced, T: Record> TickReader<H, T> {
    pub(super) fn of(
        service: &SliceService<T, H>,
        participant: &Participant,
    ) -> Result<Self, OpenError> {
        let buffer = services::EVENT_BUFFER;
        let port = Subscriber::open(service, service.name, participant, buffer)?;
        Ok(Self { port, lost: LostSamples::default() })
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
            let Some(sample) = self.port.receive()? else { break };
            let header = sample.header();
            let missed = self.lost.before(header);
            each(&TickRecords { header, records: sample.records(), missed })?;
        }
        Ok(())
    }

    /// The number of samples that this reader has lost so far.
    pub fn lost(&self) -> u64 {
        self.lost.total()
    }
}

impl<H: Header + Sequenced, T: Record> core::fmt::Debug for TickReader<H, T> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("TickReader").field("lost", &self.lost).finish_non_exhaustive()
    }
}

impl<T: Record, H: Header + Sequenced> core::fmt::Debug for Newest<T, H> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Newest").field("lost", &self.lost).finish_non_exhaustive()
    }
}
