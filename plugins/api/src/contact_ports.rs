//! Writing and reading contacts.

use iceoryx2::port::publisher::{Publisher, PublisherCreateError};
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::port::update_connections::UpdateConnections;
use iceoryx2::prelude::*;
use iceoryx2::sample::Sample;

use crate::contact::{ContactEvent, ContactEventHeader, ContactHeader, ContactRecord};
use crate::error::{OpenError, PublishError, ReadError};
use crate::participant::Participant;
use crate::qos::{self, Ipc};
use crate::subscribe::{MOST_ROUNDS, receive_error};

/// Publishes a fleet's contacts. One per fleet is alive at a time.
#[derive(Debug)]
pub struct ContactPublisher {
    contacts: Publisher<Ipc, [ContactRecord], ContactHeader>,
    events: Publisher<Ipc, [ContactEvent], ContactEventHeader>,
    sent: u32,
    events_sent: u64,
}

impl ContactPublisher {
    /// Opens a fleet's contacts for writing.
    ///
    /// # Errors
    /// [`OpenError::ContactsTaken`] if somebody alive publishes them, [`OpenError::OtherVersion`] if the fleet
    /// speaks another contract, else [`OpenError::SharedMemory`].
    pub fn open_on(participant: &Participant) -> Result<Self, OpenError> {
        let (node, fleet) = (&*participant.node, participant.fleet());
        let contacts = qos::contacts(node, fleet)?;
        let events = qos::contact_events(node, fleet)?;
        let create = contacts
            .publisher_builder()
            .max_loaned_samples(1)
            .backpressure_strategy(BackpressureStrategy::DiscardData)
            .initial_max_slice_len(qos::FIRST_RECORDS)
            .allocation_strategy(qos::GROWTH)
            .create();
        let contacts = create.map_err(|e| match e {
            PublisherCreateError::ExceedsMaxSupportedPublishers => {
                OpenError::ContactsTaken { fleet: fleet.clone(), owner: qos::publisher_owner(&contacts, node) }
            }
            e => qos::full_or(contacts.name(), 1, e),
        })?;
        let events = events
            .publisher_builder()
            .max_loaned_samples(1)
            .backpressure_strategy(BackpressureStrategy::DiscardData)
            .initial_max_slice_len(qos::FIRST_RECORDS)
            .allocation_strategy(qos::GROWTH)
            .create()
            .map_err(|e| qos::full_or(events.name(), 1, e))?;
        Ok(Self { contacts, events, sent: 0, events_sent: 0 })
    }

    /// Publishes all current pairs, in place of those before. `sequence` of the header is filled in.
    ///
    /// # Errors
    /// [`PublishError`] when shared memory is full.
    pub fn publish(&mut self, header: &ContactHeader, pairs: &[ContactRecord]) -> Result<(), PublishError> {
        let sample = self
            .contacts
            .loan_slice_uninit(pairs.len())
            .map_err(|e| PublishError::Loan { what: "contacts", reason: e.to_string() })?;
        let mut sample = sample.write_from_slice(pairs);
        self.sent = self.sent.wrapping_add(1);
        *sample.user_header_mut() = ContactHeader { sequence: self.sent, ..*header };
        sample.send().map_err(|e| PublishError::Send { what: "contacts", reason: e.to_string() })?;
        Ok(())
    }

    /// Publishes what changed in one tick.
    ///
    /// # Errors
    /// [`PublishError`] when shared memory is full.
    pub fn publish_events(&mut self, run_id: u64, tick: u64, events: &[ContactEvent]) -> Result<(), PublishError> {
        let sample = self
            .events
            .loan_slice_uninit(events.len())
            .map_err(|e| PublishError::Loan { what: "contact events", reason: e.to_string() })?;
        let mut sample = sample.write_from_slice(events);
        self.events_sent += 1;
        *sample.user_header_mut() = ContactEventHeader { run_id, tick, sequence: self.events_sent };
        sample.send().map_err(|e| PublishError::Send { what: "contact events", reason: e.to_string() })?;
        Ok(())
    }

    /// Gives the newest contacts to readers that have joined since. Publishing does so as well.
    pub fn update(&self) {
        for result in [self.contacts.update_connections(), self.events.update_connections()] {
            if let Err(error) = result {
                tracing::debug!(%error, "connecting readers of contacts");
            }
        }
    }
}

/// All pairs of one frame, borrowed from shared memory.
#[derive(Clone, Copy, Debug)]
pub struct Contacts<'sample> {
    /// The frame, and totals.
    pub header: &'sample ContactHeader,
    /// The pairs: those that touch first, each kind by robots.
    pub pairs: &'sample [ContactRecord],
    /// Samples that were published between the ones that this reader returned last and these.
    pub missed: u64,
}

/// Reads a fleet's contacts: the newest, or [all of them](Self::take_next).
#[derive(Debug)]
pub struct ContactReader {
    contacts: Subscriber<Ipc, [ContactRecord], ContactHeader>,
    held: Option<Sample<Ipc, [ContactRecord], ContactHeader>>,
    gaps: qos::Gaps,
    missed: u64,
    service: qos::Contacts,
}

impl ContactReader {
    /// Opens a fleet's contacts, whether or not anybody publishes them yet.
    ///
    /// # Errors
    /// As [`Subscriber::open`](crate::Subscriber::open).
    pub fn open_on(participant: &Participant) -> Result<Self, OpenError> {
        Self::open(participant, 1)
    }

    /// The same for a reader that wants them all: the last [`COLUMN_BUFFER`](qos::COLUMN_BUFFER) samples wait for
    /// [`take_next`](Self::take_next).
    ///
    /// # Errors
    /// As [`Subscriber::open`](crate::Subscriber::open).
    pub fn open_for_all_on(participant: &Participant) -> Result<Self, OpenError> {
        Self::open(participant, qos::COLUMN_BUFFER)
    }

    fn open(participant: &Participant, buffer: usize) -> Result<Self, OpenError> {
        let service = qos::contacts(&participant.node, participant.fleet())?;
        let contacts = service.subscriber_builder().buffer_size(buffer).create();
        let contacts = contacts.map_err(|e| qos::full_or(service.name(), qos::MAX_READERS, e))?;
        Ok(Self { contacts, held: None, gaps: qos::Gaps::default(), missed: 0, service })
    }

    /// The oldest contacts that this hasn't returned yet.
    ///
    /// # Errors
    /// [`ReadError::Receive`] if the connection is broken.
    pub fn take_next(&mut self) -> Result<Option<Contacts<'_>>, ReadError> {
        self.missed = 0;
        Ok(if self.receive()? { self.current() } else { None })
    }

    /// Holds the oldest sample that is waiting, if there is one.
    fn receive(&mut self) -> Result<bool, ReadError> {
        if !self.contacts.has_samples().map_err(|e| receive_error("contacts", e))? {
            return Ok(false);
        }
        self.held = None;
        self.held = self.contacts.receive().map_err(|e| receive_error("contacts", e))?;
        if let Some(header) = self.held.as_ref().map(Sample::user_header) {
            self.missed += self.gaps.before(header.run_id, header.sequence.into());
        }
        Ok(self.held.is_some())
    }

    /// The newest contacts, if there are some that this hasn't returned yet.
    ///
    /// # Errors
    /// [`ReadError::Receive`] if the connection is broken.
    pub fn latest(&mut self) -> Result<Option<Contacts<'_>>, ReadError> {
        let mut received = 0;
        self.missed = 0;
        while received < MOST_ROUNDS && self.receive()? {
            received += 1;
        }
        self.missed += received.saturating_sub(1);
        Ok(if received > 0 { self.current() } else { None })
    }

    /// The contacts that [`latest`](Self::latest) or [`take_next`](Self::take_next) returned last.
    pub fn current(&self) -> Option<Contacts<'_>> {
        let missed = self.missed;
        self.held.as_ref().map(|sample| Contacts { header: sample.user_header(), pairs: sample.payload(), missed })
    }

    /// Whether anybody publishes them. One that was killed counts until another process joins the fleet.
    pub fn has_publisher(&self) -> bool {
        self.service.dynamic_config().number_of_publishers() > 0
    }
}

/// What changed in one tick, borrowed from shared memory.
#[derive(Clone, Copy, Debug)]
pub struct ContactEvents<'sample> {
    /// The tick.
    pub header: &'sample ContactEventHeader,
    /// The changes.
    pub records: &'sample [ContactEvent],
    /// Ticks with changes that this reader was too slow for, between the last ones it got and these.
    pub missed: u64,
}

/// Reads the changes of a fleet's contacts, tick by tick.
#[derive(Debug)]
pub struct ContactEventReader {
    events: Subscriber<Ipc, [ContactEvent], ContactEventHeader>,
    gaps: qos::Gaps,
}

impl ContactEventReader {
    /// Opens the changes of a fleet's contacts, whether or not anybody publishes them yet.
    ///
    /// # Errors
    /// As [`Subscriber::open`](crate::Subscriber::open).
    pub fn open_on(participant: &Participant) -> Result<Self, OpenError> {
        let service = qos::contact_events(&participant.node, participant.fleet())?;
        let events =
            service.subscriber_builder().create().map_err(|e| qos::full_or(service.name(), qos::MAX_READERS, e))?;
        Ok(Self { events, gaps: qos::Gaps::default() })
    }

    /// Hands over all ticks' changes that have arrived, oldest first.
    ///
    /// # Errors
    /// [`ReadError::Receive`] if the connection is broken, else what `each` returns.
    pub fn take<E: From<ReadError>>(
        &mut self,
        mut each: impl FnMut(&ContactEvents<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        for _ in 0..2 * qos::EVENT_BUFFER {
            let Some(sample) = self.events.receive().map_err(|e| receive_error("contact events", e))? else { break };
            let header = sample.user_header();
            let missed = self.gaps.before(header.run_id, header.sequence);
            each(&ContactEvents { header, records: sample.payload(), missed })?;
        }
        Ok(())
    }
}
