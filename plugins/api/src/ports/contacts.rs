//! Both sides of contacts: a collision checker publishes them, any process reads them.

use super::error::{OpenError, PublishError, ReadError};
use super::receive::{Newest, TickReader, TickRecords};
use super::services;
use super::slices::SliceSender;
use crate::process::join::Participant;
use crate::records::contact::{
    ContactEvent, ContactEventHeader, ContactHeader, ContactRecord, Contacts,
};

/// Publishes a fleet's contacts. A fleet has one such publisher at a time.
///
/// ```
/// use regatta_plugin::contact::{ContactHeader, ContactLevel, ContactRecord};
/// use regatta_plugin::{ContactPublisher, ContactReader, Participant, Result};
///
/// # fn main() -> Result {
/// # let fleet = format!("doc-contacts-{}", std::process::id()).parse()?;
/// let participant = Participant::join(&fleet, "checker")?;
/// let mut publisher = ContactPublisher::open_on(&participant)?;
/// let mut reader = ContactReader::open_on(&participant)?;
/// let level = ContactLevel::Touching as u32;
/// let pair = ContactRecord { robots: [3, 8], level, ..ContactRecord::default() };
/// publisher.publish(&ContactHeader { tick: 9, touching: 1, ..ContactHeader::default() }, &[pair])?;
/// assert_eq!(reader.latest()?.expect("contacts").pairs, [pair]);
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct ContactPublisher {
    contacts: SliceSender<ContactRecord, ContactHeader>,
    events: SliceSender<ContactEvent, ContactEventHeader>,
}

impl ContactPublisher {
    /// Opens a fleet's contacts for writing.
    ///
    /// # Errors
    /// [`OpenError::Taken`] if a live process publishes them, [`OpenError::OtherVersion`]
    /// if the fleet uses another contract, else [`OpenError::SharedMemory`].
    pub fn open_on(participant: &Participant) -> Result<Self, OpenError> {
        let few = services::FIRST_RECORDS;
        Ok(Self {
            contacts: SliceSender::open_only(&services::CONTACTS, participant)?,
            events: SliceSender::open(&services::CONTACT_EVENTS, participant, few)?,
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
        self.contacts.publish(*header, pairs)
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
        self.events.publish(ContactEventHeader { run_id, tick, sequence: 0 }, events)
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
}

impl ContactReader {
    /// Opens a fleet's contacts, whether or not a process publishes them yet.
    ///
    /// # Errors
    /// As [`Subscriber::open`](crate::Subscriber::open).
    pub fn open_on(participant: &Participant) -> Result<Self, OpenError> {
        Ok(Self { contacts: Newest::open(&services::CONTACTS, participant)? })
    }

    /// Opens a fleet's contacts for a reader that wants all of them: the last
    /// [`COLUMN_BUFFER`](services::COLUMN_BUFFER) samples wait for [`take_next`](Self::take_next).
    ///
    /// # Errors
    /// As [`Subscriber::open`](crate::Subscriber::open).
    pub fn open_for_all_on(participant: &Participant) -> Result<Self, OpenError> {
        let buffer = services::COLUMN_BUFFER;
        Ok(Self { contacts: Newest::with_buffer(&services::CONTACTS, participant, buffer)? })
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
        self.contacts.has_publisher()
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
        Self::of(&services::CONTACT_EVENTS, participant)
    }
}
