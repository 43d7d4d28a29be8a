//! Both sides of contacts: a collision checker publishes them, any process reads them.

use iceoryx2::service::port_factory::PortFactory as _;

use super::error::{OpenError, PublishError, ReadError};
use super::every_tick::{TickReader, TickRecords};
use super::newest::Newest;
use super::services;
use super::slices::SliceSender;
use crate::process::join::Participant;
use crate::records::contact::{
    ContactEvent, ContactEventHeader, ContactHeader, ContactRecord, Contacts,
};

/// Publishes a fleet's contacts. A fleet has one such publisher at a time.
#[derive(Debug)]
pub struct ContactPublisher {
    contacts: SliceSender<ContactRecord, ContactHeader>,
    events: SliceSender<ContactEvent, ContactEventHeader>,
}

impl ContactPublisher {
    /// Opens a fleet's contacts for writing.
    ///
    /// # Errors
    /// [`OpenError::ContactsTaken`] if a live process publishes them, [`OpenError::OtherVersion`]
    /// if the fleet uses another contract, else [`OpenError::SharedMemory`].
    pub fn open_on(participant: &Participant) -> Result<Self, OpenError> {
        let (node, fleet) = (participant.node(), participant.fleet());
        let contacts = services::contacts(node, fleet)?;
        let events = services::contact_events(node, fleet)?;
        let taken = |owner| OpenError::ContactsTaken { fleet: fleet.clone(), owner };
        Ok(Self {
            contacts: SliceSender::open_only(
                contacts,
                "contacts",
                services::FIRST_RECORDS,
                node,
                taken,
            )?,
            events: SliceSender::open(events, "contact events", services::FIRST_RECORDS, 1)?,
        })
    }

    /// Publishes all current pairs, in place of those before. Fills in the header's `sequence`.
    ///
    /// # Errors
    /// [`PublishError`] when shared memory is full.
    pub fn publish(
        &mut self,
        header: &ContactHeader,
        pairs: &[ContactRecord],
    ) -> Result<(), PublishError> {
        let sequence = self.contacts.sequence().next(header.run_id);
        self.contacts.send(ContactHeader { sequence, ..*header }, pairs).map(drop)
    }

    /// Publishes the changes of one tick.
    ///
    /// # Errors
    /// [`PublishError`] when shared memory is full.
    pub fn publish_events(
        &mut self,
        run_id: u64,
        tick: u64,
        events: &[ContactEvent],
    ) -> Result<(), PublishError> {
        let sequence = self.events.sequence().next(run_id);
        self.events.send(ContactEventHeader { run_id, tick, sequence }, events).map(drop)
    }

    /// Gives the newest contacts to readers that have joined since. Publishing does so as well.
    pub fn update(&self) {
        self.contacts.update();
        self.events.update();
    }
}

/// Reads a fleet's contacts: the newest, or [all of them](Self::take_next).
#[derive(Debug)]
pub struct ContactReader {
    contacts: Newest<ContactRecord, ContactHeader>,
    service: services::Contacts,
}

impl ContactReader {
    /// Opens a fleet's contacts, whether or not a process publishes them yet.
    ///
    /// # Errors
    /// As [`Subscriber::open`](crate::Subscriber::open).
    pub fn open_on(participant: &Participant) -> Result<Self, OpenError> {
        Self::open(participant, 1)
    }

    /// Opens a fleet's contacts for a reader that wants all of them: the last
    /// [`COLUMN_BUFFER`](services::COLUMN_BUFFER) samples wait for [`take_next`](Self::take_next).
    ///
    /// # Errors
    /// As [`Subscriber::open`](crate::Subscriber::open).
    pub fn open_for_all_on(participant: &Participant) -> Result<Self, OpenError> {
        Self::open(participant, services::COLUMN_BUFFER)
    }

    fn open(participant: &Participant, buffer: usize) -> Result<Self, OpenError> {
        let service = services::contacts(participant.node(), participant.fleet())?;
        Ok(Self { contacts: Newest::open(&service, "contacts", buffer)?, service })
    }

    /// Returns the oldest contacts that this hasn't returned yet.
    ///
    /// # Errors
    /// [`ReadError::Receive`] if the connection is broken.
    pub fn take_next(&mut self) -> Result<Option<Contacts<'_>>, ReadError> {
        Ok(if self.contacts.take_next()? { self.current() } else { None })
    }

    /// Returns the newest contacts, if there are some that this hasn't returned yet.
    ///
    /// # Errors
    /// [`ReadError::Receive`] if the connection is broken.
    pub fn latest(&mut self) -> Result<Option<Contacts<'_>>, ReadError> {
        Ok(if self.contacts.take_newest()? { self.current() } else { None })
    }

    /// The contacts that [`latest`](Self::latest) or [`take_next`](Self::take_next) returned last.
    pub fn current(&self) -> Option<Contacts<'_>> {
        let missed = self.contacts.missed();
        self.contacts.held().map(|(header, pairs)| Contacts { header, pairs, missed })
    }

    /// Whether a process publishes them. One that was killed counts until another process joins the
    /// fleet.
    pub fn has_publisher(&self) -> bool {
        self.service.dynamic_config().number_of_publishers() > 0
    }
}

/// The changes of contacts in one tick, borrowed from shared memory.
pub type ContactEvents<'sample> = TickRecords<'sample, ContactEventHeader, ContactEvent>;

/// Reads the changes of a fleet's contacts.
pub type ContactEventReader = TickReader<ContactEventHeader, ContactEvent>;

impl ContactEventReader {
    /// Opens the changes of a fleet's contacts, whether or not a process publishes them yet.
    ///
    /// # Errors
    /// As [`Subscriber::open`](crate::Subscriber::open).
    pub fn open_on(participant: &Participant) -> Result<Self, OpenError> {
        Self::of(
            &services::contact_events(participant.node(), participant.fleet())?,
            "contact events",
        )
    }
}
