//! The sending end of a publish-subscribe service whose samples are slices of records.

use core::cell::Cell;
use std::rc::Rc;

use super::error::{OpenError, PublishError};
use super::services::{self, SliceService};
use crate::process::join::Participant;
use crate::records::sequence::Sequenced;
use crate::records::{Header, Record};
use crate::transport::{Loan, Publisher};

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
pub(super) struct SliceSender<T: Record, H: Header> {
    port: Publisher<T, H>,
    sequence: Sequence,
}

impl<T: Record, H: Header> SliceSender<T, H> {
    /// Opens the sending end of a service that may have several. The first segment of shared memory
    /// holds slices of `first_len` records; longer ones make it grow.
    pub(super) fn open(
        service: &SliceService<T, H>,
        participant: &Participant,
        first_len: usize,
    ) -> Result<Self, OpenError> {
        Publisher::open(service, participant, first_len).map(Self::of)
    }

    /// Opens the one sending end of a service. Other processes get [`OpenError::Taken`].
    pub(super) fn open_only(
        service: &SliceService<T, H>,
        participant: &Participant,
    ) -> Result<Self, OpenError> {
        let (subject, fleet) = (service.subject, participant.fleet().clone());
        Self::only(service, service.name, services::FIRST_RECORDS, participant, |owner| {
            OpenError::Taken { subject, fleet, owner }
        })
    }

    /// Opens the one sending end of the service with a name. `taken` makes the error if another
    /// process has it, given its owner.
    pub(super) fn only(
        service: &SliceService<T, H>,
        name: &str,
        first_len: usize,
        participant: &Participant,
        taken: impl FnOnce(String) -> OpenError,
    ) -> Result<Self, OpenError> {
        Publisher::open_only(service, name, participant, first_len, taken).map(Self::of)
    }

    fn of(port: Publisher<T, H>) -> Self {
        Self { port, sequence: Sequence::default() }
    }

    /// Sends copies of `records`, and returns the number of readers that have them.
    pub(super) fn send(&self, header: H, records: &[T]) -> Result<usize, PublishError> {
        self.port.send(header, records)
    }

    /// Sends copies of `records` under the next sequence number of the header's run.
    pub(super) fn publish(&self, mut header: H, records: &[T]) -> Result<(), PublishError>
    where
        H: Sequenced,
    {
        header.set_sequence(self.sequence.next(header.run_id()));
        self.send(header, records).map(drop)
    }

    /// Sends copies of `records` under the next sequence number of the header's run. If there is no
    /// memory, no number is used: the sender will send the same records again.
    pub(super) fn publish_unless_full(&self, header: H, records: &[T]) -> Result<(), PublishError>
    where
        H: Sequenced,
    {
        let before = self.sequence.0.get();
        let published = self.publish(header, records);
        if matches!(published, Err(PublishError::MemoryFull { .. })) {
            self.sequence.0.set(before);
        }
        published
    }

    /// Loans the memory of `len` records, to be written in place. Their values are left over from
    /// an older sample.
    pub(super) fn loan(&self, len: usize) -> Result<Loan<T, H>, PublishError> {
        self.port.loan(len)
    }

    /// The sequence numbers of this sender.
    pub(super) fn sequence(&self) -> &Sequence {
        &self.sequence
    }

    /// Connects readers that have joined since, and gives them the samples that the service keeps
    /// for late joiners.
    pub(super) fn update(&self) {
        self.port.update();
    }

    /// The number of readers of the service.
    pub(super) fn readers(&self) -> usize {
        self.port.readers()
    }
}

impl<T: Record, H: Header> core::fmt::Debug for SliceSender<T, H> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("SliceSender").field("sequence", &self.sequence).finish_non_exhaustive()
    }
}
