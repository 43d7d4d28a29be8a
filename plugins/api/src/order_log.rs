//! The order log: the orders that a producer took, tick by tick, for recorders. (Orders themselves go to the
//! producer alone: a second reader that stops would fill the senders' buffers.)

use bytemuck::{Pod, Zeroable};
use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::port::update_connections::UpdateConnections;
use iceoryx2::prelude::*;

use crate::error::{OpenError, PublishError, ReadError};
use crate::order::OrderRecord;
use crate::participant::Participant;
use crate::qos::{self, Ipc};
use crate::subscribe::receive_error;

/// The iceoryx2 user header of `regatta/F/order_log`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable, ZeroCopySend)]
#[repr(C)]
#[type_name("regatta_OrderLogHeader")]
pub struct OrderLogHeader {
    /// The run that the tick belongs to.
    pub run_id: u64,
    /// The tick that the orders took effect in.
    pub tick: u64,
    /// Counts the samples of the run, from 1.
    pub sequence: u64,
}

/// The orders of one tick, borrowed from shared memory.
#[derive(Clone, Copy, Debug)]
pub struct OrderLog<'sample> {
    /// The tick.
    pub header: &'sample OrderLogHeader,
    /// The orders, refused ones too, in the order in which they were applied.
    pub records: &'sample [OrderRecord],
    /// Ticks with orders that this reader was too slow for, between the last ones it got and these.
    pub missed: u64,
}

/// The producer's side.
#[derive(Debug)]
pub(crate) struct OrderLogPublisher {
    publisher: Publisher<Ipc, [OrderRecord], OrderLogHeader>,
    service: qos::OrderLogs,
    sent: u64,
}

impl OrderLogPublisher {
    pub(crate) fn open_on(participant: &Participant) -> Result<Self, OpenError> {
        let service = qos::order_log(&participant.node, participant.fleet())?;
        let publisher = service
            .publisher_builder()
            .max_loaned_samples(1)
            .backpressure_strategy(BackpressureStrategy::DiscardData)
            .initial_max_slice_len(qos::FIRST_RECORDS)
            .allocation_strategy(qos::GROWTH)
            .create()
            .map_err(|e| qos::full_or(service.name(), 1, e))?;
        Ok(Self { publisher, service, sent: 0 })
    }

    pub(crate) fn has_readers(&self) -> bool {
        self.service.dynamic_config().number_of_subscribers() > 0
    }

    pub(crate) fn publish(&mut self, run_id: u64, tick: u64, records: &[OrderRecord]) -> Result<(), PublishError> {
        let sample = self
            .publisher
            .loan_slice_uninit(records.len())
            .map_err(|e| PublishError::Loan { what: "the order log", reason: e.to_string() })?;
        let mut sample = sample.write_from_slice(records);
        self.sent += 1;
        *sample.user_header_mut() = OrderLogHeader { run_id, tick, sequence: self.sent };
        sample.send().map_err(|e| PublishError::Send { what: "the order log", reason: e.to_string() })?;
        Ok(())
    }

    pub(crate) fn update(&self) {
        if let Err(error) = self.publisher.update_connections() {
            tracing::debug!(%error, "connecting readers of the order log");
        }
    }
}

/// Reads the orders that a fleet's producer took.
#[derive(Debug)]
pub struct OrderLogReader {
    log: Subscriber<Ipc, [OrderRecord], OrderLogHeader>,
    gaps: qos::Gaps,
}

impl OrderLogReader {
    /// Opens the order log of a fleet, whether or not it has a producer yet.
    ///
    /// # Errors
    /// As [`Subscriber::open`](crate::Subscriber::open).
    pub fn open_on(participant: &Participant) -> Result<Self, OpenError> {
        let service = qos::order_log(&participant.node, participant.fleet())?;
        let log =
            service.subscriber_builder().create().map_err(|e| qos::full_or(service.name(), qos::MAX_READERS, e))?;
        Ok(Self { log, gaps: qos::Gaps::default() })
    }

    /// Hands over all ticks' orders that have arrived, oldest first.
    ///
    /// # Errors
    /// [`ReadError::Receive`] if the connection to the producer is broken, else what `each` returns.
    pub fn take<E: From<ReadError>>(&mut self, mut each: impl FnMut(&OrderLog<'_>) -> Result<(), E>) -> Result<(), E> {
        for _ in 0..2 * qos::EVENT_BUFFER {
            let Some(sample) = self.log.receive().map_err(|e| receive_error("the order log", e))? else { break };
            let header = sample.user_header();
            let missed = self.gaps.before(header.run_id, header.sequence);
            each(&OrderLog { header, records: sample.payload(), missed })?;
        }
        Ok(())
    }
}
