//! The reader's side of the order log, for recorders. (Orders themselves go to the producer alone:
//! a second reader that stops would fill the senders' buffers.)

use super::error::OpenError;
use super::receive::{TickReader, TickRecords};
use super::services;
use crate::process::join::Participant;
use crate::records::order::OrderRecord;
use crate::records::order_log::OrderLogHeader;

/// The orders of one tick, refused ones too, in the order in which they were applied.
pub type OrderLog<'sample> = TickRecords<'sample, OrderLogHeader, OrderRecord>;

/// Reads the orders that a fleet's producer applied, as an [`EventReader`](crate::EventReader)
/// reads events.
pub type OrderLogReader = TickReader<OrderLogHeader, OrderRecord>;

impl OrderLogReader {
    /// Opens the order log of a fleet, whether or not it has a producer yet.
    ///
    /// # Errors
    /// As [`Subscriber::open`](crate::Subscriber::open).
    pub fn open_on(participant: &Participant) -> Result<Self, OpenError> {
        Self::of(&services::ORDER_LOG, participant)
    }
}
