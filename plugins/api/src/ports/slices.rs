//! The sending end of a publish-subscribe service whose samples are slices of records.

use core::cell::{Cell, RefCell};
use core::fmt::Debug;
use core::mem::MaybeUninit;
use std::collections::HashMap;
use std::rc::Rc;

use bytemuck::AnyBitPattern;
use iceoryx2::port::publisher::{Publisher, PublisherCreateError};
use iceoryx2::port::update_connections::UpdateConnections;
use iceoryx2::prelude::*;
use iceoryx2::sample_mut::SampleMut;
use iceoryx2::sample_mut_uninit::SampleMutUninit;

use super::error::{OpenError, PublishError};
use super::full_memory::{self, FULL};
use super::places::{place, publisher_owner};
use super::services::{self, Ipc, SliceService, Slices};
use crate::process::health;
use crate::process::join::Participant;
use crate::records::sequence::Sequenced;

/// The sequence numbers of the samples of a run. A loan takes its number when it is sent.
#[derive(Clone, Debug, Default)]
pub(super) struct Sequence(Rc<Cell<(u64, u64)>>);

impl Sequence {
    /// The number of the next sample of a run, from 1.
    pub(super) fn next(&self, run_id: u64) -> u64 {
        let (run, sent) = self.0.get();
        let sequence = if run == run_id { sent + 1 } else { 1 };
        self.0.set((run_id, sequence));
        sequence
    }
}

/// Sends slices of records `T` under headers `H`. Never waits for a reader.
#[derive(Debug)]
pub(super) struct SliceSender<T, H>
where
    T: AnyBitPattern + Debug + ZeroCopySend,
    H: Debug + ZeroCopySend,
{
    publisher: Publisher<Ipc, [T], H>,
    service: Slices<T, H>,
    sequence: Sequence,
    reserved: RefCell<Reserved>,
    /// The subject of error messages.
    what: &'static str,
}

/// The chunks that have memory: their addresses, and the number of records of each.
#[derive(Debug, Default)]
struct Reserved {
    chunks: HashMap<usize, usize>,
    /// The longest slice so far. A longer one may come from a new segment, at addresses that
    /// another one had.
    longest: usize,
}

impl Reserved {
    /// Makes sure that a chunk has memory. Returns `false` if there is too little.
    fn take<T>(&mut self, chunk: &mut [MaybeUninit<T>]) -> bool {
        if chunk.len() > self.longest {
            self.longest = chunk.len();
            self.chunks.clear();
        }
        let records = self.chunks.entry(chunk.as_ptr() as usize).or_default();
        if chunk.len() <= *records {
            return true;
        }
        if !full_memory::reserve(chunk) {
            full_memory::release(chunk);
            *records = 0;
            return false;
        }
        *records = chunk.len();
        true
    }
}

impl<T, H> SliceSender<T, H>
where
    T: AnyBitPattern + Debug + ZeroCopySend,
    H: Debug + Default + ZeroCopySend,
{
    /// Opens the sending end of a service with room for `senders` of them. The first segment holds
    /// slices of `first_len` records; longer ones make it grow.
    pub(super) fn open(
        service: &SliceService<T, H>,
        participant: &Participant,
        first_len: usize,
        senders: usize,
    ) -> Result<Self, OpenError> {
        let opened = service.open(participant)?;
        let publisher = place(&opened, senders, || create(&opened, first_len))?;
        Ok(Self::of(publisher, opened, service.subject))
    }

    /// Opens the one sending end of a service. Other processes get [`OpenError::Taken`].
    pub(super) fn open_only(
        service: &SliceService<T, H>,
        participant: &Participant,
    ) -> Result<Self, OpenError> {
        let (opened, subject) = (service.open(participant)?, service.subject);
        let fleet = participant.fleet().clone();
        Self::only(opened, subject, services::FIRST_RECORDS, participant, |owner| {
            OpenError::Taken { subject, fleet, owner }
        })
    }

    /// Makes the one sending end of a service. `taken` makes the error if another process has it,
    /// given its owner.
    pub(super) fn only(
        service: Slices<T, H>,
        what: &'static str,
        first_len: usize,
        participant: &Participant,
        taken: impl FnOnce(String) -> OpenError,
    ) -> Result<Self, OpenError> {
        let mut created = place(&service, 1, || create(&service, first_len));
        if matches!(created, Err(OpenError::Full { .. })) {
            // Its owner may have died just now, or another process may be cleaning up after it.
            service.blocking_cleanup_dead_nodes(core::time::Duration::from_secs(1));
            created = place(&service, 1, || create(&service, first_len));
        }
        match created {
            Ok(publisher) => Ok(Self::of(publisher, service, what)),
            Err(OpenError::Full { .. }) => {
                Err(taken(publisher_owner(&service, participant.node())))
            }
            Err(error) => Err(error),
        }
    }

    fn of(publisher: Publisher<Ipc, [T], H>, service: Slices<T, H>, what: &'static str) -> Self {
        Self {
            publisher,
            service,
            sequence: Sequence::default(),
            reserved: RefCell::default(),
            what,
        }
    }

    /// Sends copies of `records`, and returns the number of readers that have them.
    pub(super) fn send(&self, header: H, records: &[T]) -> Result<usize, PublishError> {
        let mut sample = self.loan_uninit(records.len())?.write_from_slice(records);
        *sample.user_header_mut() = header;
        send(sample, self.what)
    }

    /// Sends copies of `records` under the next sequence number of the header's run.
    pub(super) fn publish(&self, mut header: H, records: &[T]) -> Result<(), PublishError>
    where
        H: Sequenced,
    {
        header.set_sequence(self.sequence.next(header.run_id()));
        self.send(header, records).map(drop)
    }

    /// Loans the memory of `len` records, to be written in place. Their values are left over from
    /// an older sample.
    #[expect(unsafe_code, reason = "the one way to loan a chunk without writing it twice")]
    pub(super) fn loan(&self, len: usize) -> Result<SampleMut<Ipc, [T], H>, PublishError> {
        let sample = self.loan_uninit(len)?;
        // SAFETY: every bit pattern is a value of `T` (`AnyBitPattern`), and the chunk is mapped
        // from a shared-memory file: its bytes are zero or those of an older sample, never
        // undefined.
        Ok(unsafe { sample.assume_init() })
    }

    /// Loans a chunk that has memory.
    fn loan_uninit(
        &self,
        len: usize,
    ) -> Result<SampleMutUninit<Ipc, [MaybeUninit<T>], H>, PublishError> {
        let full = PublishError::MemoryFull { what: self.what };
        if len > self.reserved.borrow().longest && !has_room(len * size_of::<T>()) {
            return Err(full);
        }
        let (loaned, missing) = full_memory::guarded(|| self.publisher.loan_slice_uninit(len));
        if missing.any() {
            // iceoryx2 has written the chunk's header. Other chunks are whole, and this one is from
            // here on.
            drop(loaned);
            return match full_memory::restore(&missing) {
                true => Err(full),
                false => Err(self.loan_error("shared memory is full, and was damaged by that")),
            };
        }
        let mut sample = loaned.map_err(|e| self.loan_error(e))?;
        if self.reserved.borrow_mut().take(sample.payload_mut()) { Ok(sample) } else { Err(full) }
    }

    /// The sequence numbers of this sender.
    pub(super) fn sequence(&self) -> &Sequence {
        &self.sequence
    }

    /// Connects readers that have joined since, and gives them the samples that the service keeps
    /// for late joiners.
    pub(super) fn update(&self) {
        let (updated, missing) = full_memory::guarded(|| self.publisher.update_connections());
        if missing.any() {
            // That reader has an error, and the others are served.
            tracing::warn!("connecting a reader of {}: {FULL}", self.what);
        } else if let Err(error) = updated {
            // A reader that died half connected is cleaned up by the next one to join.
            tracing::debug!(%error, "connecting readers of {}", self.what);
        }
    }

    /// The number of readers of the service.
    pub(super) fn readers(&self) -> usize {
        self.service.dynamic_config().number_of_subscribers()
    }

    fn loan_error(&self, error: impl core::fmt::Display) -> PublishError {
        PublishError::Loan { what: self.what, reason: error.to_string() }
    }
}

/// The allowance in bytes for the management data of a new segment: ten times the 24 KiB that
/// the one with the most chunks (4161, of events) was measured to take.
const SEGMENT_MANAGEMENT: u64 = 256 << 10;

/// Whether there is memory for a new segment, and a chunk of this size in it. A segment without
/// memory for its management data could not be repaired later.
fn has_room(bytes: usize) -> bool {
    // If the system doesn't say how much there is, there is nothing to check.
    health::space().map_or(true, |space| space.available >= bytes as u64 + SEGMENT_MANAGEMENT)
}

/// Sends a sample, and returns the number of readers that have it.
pub(super) fn send<T, H>(
    sample: SampleMut<Ipc, [T], H>,
    what: &'static str,
) -> Result<usize, PublishError>
where
    T: Debug + ZeroCopySend,
    H: Debug + ZeroCopySend,
{
    let (sent, missing) = full_memory::guarded(|| sample.send());
    if missing.any() {
        // Sending connects readers that have joined. One of them couldn't be connected, and has an
        // error.
        tracing::warn!("connecting a reader of {what}: {FULL}");
        return Ok(sent.unwrap_or_default());
    }
    sent.map_err(|e| PublishError::Send { what, reason: e.to_string() })
}

fn create<T, H>(
    service: &Slices<T, H>,
    first_len: usize,
) -> Result<Publisher<Ipc, [T], H>, PublisherCreateError>
where
    T: Debug + ZeroCopySend,
    H: Debug + Default + ZeroCopySend,
{
    service
        .publisher_builder()
        .max_loaned_samples(1)
        .backpressure_strategy(BackpressureStrategy::DiscardData)
        .initial_max_slice_len(first_len)
        .allocation_strategy(services::GROWTH)
        .create()
}
