//! The ends of a publish-subscribe service in shared memory.

use core::cell::RefCell;
use core::mem::MaybeUninit;
use std::collections::HashMap;

use iceoryx2::identifiers::UniqueNodeId;
use iceoryx2::port::publisher::{Publisher as Port, PublisherCreateError};
use iceoryx2::port::subscriber::Subscriber as ReceivingPort;
use iceoryx2::port::update_connections::UpdateConnections;
use iceoryx2::prelude::*;
use iceoryx2::sample_mut::SampleMut;
use iceoryx2::sample_mut_uninit::SampleMutUninit;

use super::Ipc;
use super::full_memory::{self, FULL, received};
use super::open::{GROWTH, Slices, slices};
use super::places::{place, publisher_owner};
use crate::ports::error::{OpenError, PublishError, ReadError};
use crate::ports::services::SliceService;
use crate::process::health;
use crate::process::join::Participant;
use crate::records::{Header, Record};

/// The sending end of a service of slices of records.
pub(crate) struct Publisher<T: Record, H: Header> {
    port: Port<Ipc, [T], H>,
    service: Slices<T, H>,
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

impl<T: Record, H: Header> Publisher<T, H> {
    /// Opens one of several sending ends of a service. The first segment holds slices of
    /// `first_len` records; longer ones make it grow.
    pub(crate) fn open(
        service: &SliceService<T, H>,
        participant: &Participant,
        first_len: usize,
    ) -> Result<Self, OpenError> {
        let opened = slices(service, service.name, participant)?;
        let chunks = service.quality.shared_chunks();
        let port =
            place(&opened, service.quality.publishers, || create(&opened, first_len, chunks))?;
        Ok(Self::of(port, opened, service.subject))
    }

    /// Opens the one sending end of the service with a name. `taken` makes the error if another
    /// process has it, given its owner.
    pub(crate) fn open_only(
        service: &SliceService<T, H>,
        name: &str,
        participant: &Participant,
        first_len: usize,
        taken: impl FnOnce(String) -> OpenError,
    ) -> Result<Self, OpenError> {
        let opened = slices(service, name, participant)?;
        let chunks = service.quality.shared_chunks();
        let mut created = place(&opened, 1, || create(&opened, first_len, chunks));
        if matches!(created, Err(OpenError::Full { .. })) {
            // Its owner may have died just now, or another process may be cleaning up after it.
            opened.blocking_cleanup_dead_nodes(core::time::Duration::from_secs(1));
            created = place(&opened, 1, || create(&opened, first_len, chunks));
        }
        match created {
            Ok(port) => Ok(Self::of(port, opened, service.subject)),
            Err(OpenError::Full { .. }) => Err(taken(publisher_owner(&opened, participant))),
            Err(error) => Err(error),
        }
    }

    fn of(port: Port<Ipc, [T], H>, service: Slices<T, H>, what: &'static str) -> Self {
        Self { port, service, reserved: RefCell::default(), what }
    }

    /// Sends copies of `records`, and returns the number of readers that have them.
    pub(crate) fn send_copies(&self, header: H, records: &[T]) -> Result<usize, PublishError> {
        let mut sample = self.loan_uninit(records.len())?.write_from_slice(records);
        *sample.user_header_mut() = header;
        Loan { sample, what: self.what }.send()
    }

    /// Loans the memory of `len` records, to be written in place. Their values are left over from
    /// an older sample; the header is zero.
    #[expect(unsafe_code, reason = "the one way to loan a chunk without writing it twice")]
    pub(crate) fn loan(&self, len: usize) -> Result<Loan<T, H>, PublishError> {
        let sample = self.loan_uninit(len)?;
        // SAFETY: every bit pattern is a value of `T` (`AnyBitPattern`), and the chunk is mapped
        // from a shared-memory file: its bytes are zero or those of an older sample, never
        // undefined.
        let mut sample = unsafe { sample.assume_init() };
        *sample.user_header_mut() = H::default();
        Ok(Loan { sample, what: self.what })
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
        let (loaned, missing) = full_memory::guarded(|| self.port.loan_slice_uninit(len));
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

    /// Connects readers that have joined since, and gives them the samples that the service keeps
    /// for late joiners.
    pub(crate) fn update(&self) {
        let (updated, missing) = full_memory::guarded(|| self.port.update_connections());
        if missing.any() {
            // That reader has an error, and the others are served.
            tracing::warn!("connecting a reader of {}: {FULL}", self.what);
        } else if let Err(error) = updated {
            // A reader that died half connected is cleaned up by the next one to join.
            tracing::debug!(%error, "connecting readers of {}", self.what);
        }
    }

    /// The number of readers of the service.
    pub(crate) fn readers(&self) -> usize {
        self.service.dynamic_config().number_of_subscribers()
    }

    fn loan_error(&self, error: impl core::fmt::Display) -> PublishError {
        PublishError::Loan { what: self.what, reason: error.to_string() }
    }
}

/// The allowance in bytes for the management data of a new segment: ten times the 24 KiB that
/// one with 4161 chunks was measured to take, which is more than any has.
const SEGMENT_MANAGEMENT: u64 = 256 << 10;

/// Whether there is memory for a new segment, and a chunk of this size in it. A segment without
/// memory for its management data could not be repaired later.
fn has_room(bytes: usize) -> bool {
    // If the system doesn't say how much there is, there is nothing to check.
    health::space().map_or(true, |space| space.available >= bytes as u64 + SEGMENT_MANAGEMENT)
}

fn create<T: Record, H: Header>(
    service: &Slices<T, H>,
    first_len: usize,
    chunks: Option<usize>,
) -> Result<Port<Ipc, [T], H>, PublisherCreateError> {
    service
        .publisher_builder()
        .max_loaned_samples(1)
        .backpressure_strategy(BackpressureStrategy::DiscardData)
        .initial_max_slice_len(first_len)
        .override_sample_preallocation(move |most| chunks.unwrap_or(most))
        .allocation_strategy(GROWTH)
        .create()
}

/// A sample under construction.
pub(crate) struct Loan<T: Record, H: Header> {
    sample: SampleMut<Ipc, [T], H>,
    what: &'static str,
}

impl<T: Record, H: Header> Loan<T, H> {
    pub(crate) fn header_mut(&mut self) -> &mut H {
        self.sample.user_header_mut()
    }

    pub(crate) fn records_mut(&mut self) -> &mut [T] {
        self.sample.payload_mut()
    }

    /// Sends the sample, and returns the number of readers that have it.
    pub(crate) fn send(self) -> Result<usize, PublishError> {
        let Self { sample, what } = self;
        let (sent, missing) = full_memory::guarded(|| sample.send());
        if missing.any() {
            // Sending connects readers that have joined. One of them couldn't be connected, and has
            // an error.
            tracing::warn!("connecting a reader of {what}: {FULL}");
            return Ok(sent.unwrap_or_default());
        }
        sent.map_err(|e| PublishError::Send { what, reason: e.to_string() })
    }
}

/// A received sample.
pub(crate) type Sample<T, H> = iceoryx2::sample::Sample<Ipc, [T], H>;

/// The receiving end of a service of slices of records.
pub(crate) struct Subscriber<T: Record, H: Header> {
    port: ReceivingPort<Ipc, [T], H>,
    service: Slices<T, H>,
    /// The subject of error messages.
    what: &'static str,
}

impl<T: Record, H: Header> Subscriber<T, H> {
    /// Opens the receiving end of the service with a name. The last `buffer` samples wait to be
    /// taken.
    pub(crate) fn open(
        service: &SliceService<T, H>,
        name: &str,
        participant: &Participant,
        buffer: usize,
    ) -> Result<Self, OpenError> {
        let (opened, what) = (slices(service, name, participant)?, service.subject);
        let port = place(&opened, service.quality.subscribers, || {
            opened.subscriber_builder().buffer_size(buffer).create()
        })?;
        Ok(Self { port, service: opened, what })
    }

    pub(crate) fn receive(&self) -> Result<Option<Sample<T, H>>, ReadError> {
        received(self.what, || self.port.receive())
    }

    /// The process that has sent a sample; `None` if it has closed its port since.
    pub(crate) fn sender(&self, sample: &Sample<T, H>) -> Option<UniqueNodeId> {
        let mut sender = None;
        self.service.dynamic_config().list_publishers(|details| {
            if details.publisher_id == sample.origin() {
                sender = Some(details.node_id);
            }
            CallbackProgression::Continue
        });
        sender
    }

    pub(crate) fn has_samples(&self) -> Result<bool, ReadError> {
        received(self.what, || self.port.has_samples())
    }

    pub(crate) fn has_publisher(&self) -> bool {
        self.service.dynamic_config().number_of_publishers() > 0
    }

    pub(crate) fn forget_dead(&self) {
        self.service.try_cleanup_dead_nodes();
    }
}
