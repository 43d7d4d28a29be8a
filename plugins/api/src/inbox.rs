//! What comes in to a producer: orders, and requests of the control service.

use iceoryx2::active_request::ActiveRequest;
use iceoryx2::port::server::Server;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::*;

use crate::control::{ControlRequest, ControlResponse};
use crate::error::{OpenError, ReadError};
use crate::order::{OrderHeader, OrderRecord};
use crate::participant::Participant;
use crate::publish::Producer;
use crate::qos::{self, Ipc};
use crate::subscribe::receive_error;

type Request = ActiveRequest<Ipc, ControlRequest, (), ControlResponse, ()>;

/// What a producer does with a request.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "made a few times a second at most, and never stored")]
pub enum Answer {
    /// Answer it at once.
    Now(ControlResponse),
    /// Keep it until [`Producer::answer_waiting`] has an answer for this ticket, a tick number say.
    Later(u64),
}

#[derive(Debug)]
pub(crate) struct OrderInbox {
    samples: Subscriber<Ipc, [OrderRecord], OrderHeader>,
}

impl OrderInbox {
    pub(crate) fn open(participant: &Participant) -> Result<Self, OpenError> {
        let service = qos::orders(&participant.node, participant.fleet())?;
        let samples = service.subscriber_builder().create().map_err(|e| qos::full_or(service.name(), 1, e))?;
        Ok(Self { samples })
    }
}

#[derive(Debug)]
pub(crate) struct RequestInbox {
    server: Server<Ipc, ControlRequest, (), ControlResponse, ()>,
    waiting: Vec<(u64, Request)>,
}

impl RequestInbox {
    pub(crate) fn open(participant: &Participant) -> Result<Self, OpenError> {
        let service = qos::control(&participant.node, participant.fleet())?;
        let server = service
            .server_builder()
            .backpressure_strategy(BackpressureStrategy::DiscardData)
            .max_loaned_responses_per_request(1)
            .create()
            .map_err(|e| qos::full_or(service.name(), 1, e))?;
        Ok(Self { server, waiting: Vec::new() })
    }
}

/// A client that has gone away, or is stopped, misses its answer; nobody waits for it.
fn reply(request: &Request, response: ControlResponse) {
    if let Err(error) = request.send_copy(response) {
        tracing::debug!(%error, "answering a control request");
    }
}

impl Producer {
    /// Hands over all orders that have arrived, sample by sample; those of one sender in the order in which it
    /// sent them. At most [`ORDER_BUFFER`](qos::ORDER_BUFFER) samples per sender and call.
    ///
    /// # Errors
    /// [`ReadError::Receive`] if a connection is broken.
    pub fn take_orders(&mut self, mut each: impl FnMut(&OrderHeader, &[OrderRecord])) -> Result<(), ReadError> {
        // Bounded, so that a sender that never stops can't keep a tick from ending.
        for _ in 0..qos::ORDER_BUFFER * qos::MAX_ORDER_SENDERS {
            let Some(sample) = self.orders.samples.receive().map_err(|e| receive_error("orders", e))? else { break };
            each(sample.user_header(), sample.payload());
        }
        Ok(())
    }

    /// Hands over all requests that have arrived, to be answered now or later.
    ///
    /// # Errors
    /// [`ReadError::Receive`] if a connection is broken.
    pub fn take_requests(&mut self, mut answer: impl FnMut(&ControlRequest) -> Answer) -> Result<(), ReadError> {
        for _ in 0..qos::MAX_OPEN_REQUESTS * qos::MAX_CONTROL_CLIENTS {
            let inbox = &mut self.requests;
            let Some(request) = inbox.server.receive().map_err(|e| receive_error("control requests", e))? else {
                break;
            };
            match answer(request.payload()) {
                Answer::Now(response) => reply(&request, response),
                Answer::Later(ticket) => inbox.waiting.push((ticket, request)),
            }
        }
        Ok(())
    }

    /// Answers those of the requests kept for [`Answer::Later`] that `answer` has an answer for, given the ticket.
    pub fn answer_waiting(&mut self, mut answer: impl FnMut(u64) -> Option<ControlResponse>) {
        self.requests.waiting.retain(|(ticket, request)| match answer(*ticket) {
            Some(response) => {
                reply(request, response);
                false
            }
            None => request.is_connected(),
        });
    }

    /// How many requests wait for an answer.
    pub fn waiting_requests(&self) -> usize {
        self.requests.waiting.len()
    }
}
