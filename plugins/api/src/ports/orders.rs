//! Both sides of the order log: a fleet manager writes it, any process reads it.

use super::error::{OpenError, PublishError};
use super::receive::{TickReader, TickRecords};
use super::services;
use super::slices::SliceSender;
use crate::process::join::Participant;
use crate::records::order::{OrderHeader, OrderRecord};

/// Publishes a fleet's order log. A fleet has one such publisher at a time.
///
/// ```
/// use regatta_plugin::order::{OrderKind, OrderRecord};
/// use regatta_plugin::{Participant, Result, OrderPublisher, OrderReader};
///
/// # fn main() -> Result {
/// # let fleet = format!("doc-orders-{}", std::process::id()).parse()?;
/// let participant = Participant::join(&fleet, "manager")?;
/// let mut log = OrderPublisher::open_on(&participant)?;
/// let mut reader = OrderReader::open_on(&participant)?;
/// log.publish(1, 7, 0, &[OrderRecord::new(3, OrderKind::Assigned).of_robot(5)])?;
/// reader.take(|tick| -> Result {
///     assert_eq!((tick.header.tick, tick.records[0].robot), (7, 5));
///     Ok(())
/// })?;
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct OrderPublisher {
    orders: SliceSender<OrderRecord, OrderHeader>,
    /// The records of a run for which there was no memory.
    unsent: (u64, Vec<OrderRecord>),
}

impl OrderPublisher {
    /// Opens a fleet's order log for writing.
    ///
    /// # Errors
    /// [`OpenError::Taken`] if a live process publishes it, [`OpenError::OtherVersion`] if the
    /// fleet uses another contract, else [`OpenError::SharedMemory`].
    pub fn open_on(participant: &Participant) -> Result<Self, OpenError> {
        let orders = SliceSender::open_only(&services::ORDERS, participant)?;
        Ok(Self { orders, unsent: (0, Vec::new()) })
    }

    /// Publishes the records of one tick, `dropped` of which were left out because there were too
    /// many.
    ///
    /// # Errors
    /// [`PublishError`] when shared memory is full. The records are kept, and come first the next
    /// time, in the same sample.
    pub fn publish(
        &mut self,
        run_id: u64,
        tick: u64,
        dropped: u64,
        records: &[OrderRecord],
    ) -> Result<(), PublishError> {
        let (of_run, unsent) = &mut self.unsent;
        if std::mem::replace(of_run, run_id) != run_id {
            unsent.clear();
        }
        unsent.extend_from_slice(records);
        let header = OrderHeader { run_id, tick, dropped, sequence: 0 };
        self.orders.publish_unless_full(header, unsent)?;
        unsent.clear();
        Ok(())
    }

    /// Whether records wait for memory: publishing, also of none, sends them.
    pub fn has_unsent(&self) -> bool {
        !self.unsent.1.is_empty()
    }

    /// Connects readers that have joined since. Publishing does so as well.
    pub fn update(&self) {
        self.orders.update();
    }

    /// Whether a process reads the order log.
    pub fn has_readers(&self) -> bool {
        self.orders.readers() > 0
    }
}

/// The records of orders of one tick, borrowed from shared memory, in the order in which they
/// happened.
pub type Orders<'sample> = TickRecords<'sample, OrderHeader, OrderRecord>;

/// Reads a fleet's order log.
pub type OrderReader = TickReader<OrderHeader, OrderRecord>;

impl OrderReader {
    /// Opens the order log of a fleet, whether or not a process writes it yet.
    ///
    /// # Errors
    /// As [`Subscriber::open`](crate::Subscriber::open).
    pub fn open_on(participant: &Participant) -> Result<Self, OpenError> {
        Self::of(&services::ORDERS, participant)
    }
}
