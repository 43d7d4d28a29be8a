//! Slices out: the sending end of a publish-subscribe service whose samples are slices of records.

use core::cell::Cell;
use core::fmt::Debug;
use std::rc::Rc;

use bytemuck::AnyBitPattern;
use iceoryx2::port::publisher::{Publisher, PublisherCreateError};
use iceoryx2::port::update_connections::UpdateConnections;
use iceoryx2::prelude::*;
use iceoryx2::sample_mut::SampleMut;
use iceoryx2::service::port_factory::publish_subscribe;

use super::error::{OpenError, PublishError};
use super::services::{self, Ipc};

type Service<T, H> = publish_subscribe::PortFactory<Ipc, [T], H>;

/// The sequence numbers of what is sent in a run. A loan that is sent later takes its number when it is sent.
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
    service: Service<T, H>,
    sequence: Sequence,
    /// The subject of error messages.
    what: &'static str,
}

impl<T, H> SliceSender<T, H>
where
    T: AnyBitPattern + Debug + ZeroCopySend,
    H: Debug + Default + ZeroCopySend,
{
    /// Opens the sending end of a service with room for `senders` of them. The first segment holds slices of
    /// `first_len` records; longer ones make it grow.
    pub(super) fn open(
        service: Service<T, H>,
        what: &'static str,
        first_len: usize,
        senders: usize,
    ) -> Result<Self, OpenError> {
        match create(&service, first_len) {
            Ok(publisher) => Ok(Self { publisher, service, sequence: Sequence::default(), what }),
            Err(error) => Err(services::full_or(service.name(), senders, error)),
        }
    }

    /// Opens the one sending end of a service. `taken` makes the error if another process has it, given its owner.
    pub(super) fn open_only(
        service: Service<T, H>,
        what: &'static str,
        first_len: usize,
        node: &Node<Ipc>,
        taken: impl FnOnce(String) -> OpenError,
    ) -> Result<Self, OpenError> {
        let mut created = create(&service, first_len);
        if matches!(created, Err(PublisherCreateError::ExceedsMaxSupportedPublishers)) {
            // Its owner may have died just now, or another process may be cleaning up after it.
            service.blocking_cleanup_dead_nodes(core::time::Duration::from_secs(1));
            created = create(&service, first_len);
        }
        match created {
            Ok(publisher) => Ok(Self { publisher, service, sequence: Sequence::default(), what }),
            Err(PublisherCreateError::ExceedsMaxSupportedPublishers) => {
                Err(taken(services::publisher_owner(&service, node)))
            }
            Err(error) => Err(services::full_or(service.name(), 1, error)),
        }
    }

    /// Sends copies of `records`, and returns how many readers have them.
    pub(super) fn send(&self, header: H, records: &[T]) -> Result<usize, PublishError> {
        let sample = self.publisher.loan_slice_uninit(records.len()).map_err(|e| self.loan_error(e))?;
        let mut sample = sample.write_from_slice(records);
        *sample.user_header_mut() = header;
        sample.send().map_err(|e| PublishError::Send { what: self.what, reason: e.to_string() })
    }

    /// Loans the memory of `len` records, to be written in place. Their values are left over from an older sample.
    #[expect(unsafe_code, reason = "the one way to loan a chunk without writing it twice")]
    pub(super) fn loan(&self, len: usize) -> Result<SampleMut<Ipc, [T], H>, PublishError> {
        let sample = self.publisher.loan_slice_uninit(len).map_err(|e| self.loan_error(e))?;
        // SAFETY: every bit pattern is a value of `T` (`AnyBitPattern`), and the chunk is mapped from a shared-memory
        // file: its bytes are zero or those of an older sample, never undefined.
        Ok(unsafe { sample.assume_init() })
    }

    /// The sequence numbers of this sender.
    pub(super) fn sequence(&self) -> &Sequence {
        &self.sequence
    }

    /// Connects readers that have joined since, and gives them what the service keeps for late joiners.
    pub(super) fn update(&self) {
        // A reader that died half connected is cleaned up by the next one to join.
        if let Err(error) = self.publisher.update_connections() {
            tracing::debug!(%error, "connecting readers of {}", self.what);
        }
    }

    /// How many readers the service has.
    pub(super) fn readers(&self) -> usize {
        self.service.dynamic_config().number_of_subscribers()
    }

    fn loan_error(&self, error: impl core::fmt::Display) -> PublishError {
        PublishError::Loan { what: self.what, reason: error.to_string() }
    }
}

fn create<T, H>(service: &Service<T, H>, first_len: usize) -> Result<Publisher<Ipc, [T], H>, PublisherCreateError>
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
