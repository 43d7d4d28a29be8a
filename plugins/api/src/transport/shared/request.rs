//! The ends of a request-response service in shared memory.

use iceoryx2::active_request::ActiveRequest;
use iceoryx2::pending_response::PendingResponse;
use iceoryx2::port::client::Client as ClientPort;
use iceoryx2::port::server::Server as ServerPort;
use iceoryx2::prelude::*;

use super::Ipc;
use super::full_memory::{loan_record, received, unless_full};
use super::open::{Requests, requests};
use super::places::place;
use crate::ports::error::{OpenError, ReadError};
use crate::ports::services::RequestService;
use crate::process::join::Participant;
use crate::records::Record;

/// A client of the one server of a service.
pub(crate) struct Client<Q: Record, A: Record> {
    port: ClientPort<Ipc, Q, (), A, ()>,
    service: Requests<Q, A>,
}

/// A request that was sent.
pub(crate) struct Asked<Q: Record, A: Record>(PendingResponse<Ipc, Q, (), A, ()>);

impl<Q: Record, A: Record> Client<Q, A> {
    pub(crate) fn open(
        service: &RequestService<Q, A>,
        participant: &Participant,
    ) -> Result<Self, OpenError> {
        let opened = requests(service, participant)?;
        let port = place(&opened, service.clients, || {
            let builder = opened.client_builder();
            builder.backpressure_strategy(BackpressureStrategy::DiscardData).create()
        })?;
        Ok(Self { port, service: opened })
    }

    pub(crate) fn has_server(&self) -> bool {
        self.service.dynamic_config().number_of_servers() > 0
    }

    pub(crate) fn send(&self, request: Q) -> Result<Asked<Q, A>, String> {
        let loaned = loan_record(|| self.port.loan_uninit(), |loaned| loaned.payload_mut())?;
        unless_full(|| loaned.write_payload(request).send()).map(Asked)
    }

    pub(crate) fn forget_dead(&self) {
        self.service.try_cleanup_dead_nodes();
    }
}

impl<Q: Record, A: Record> Asked<Q, A> {
    pub(crate) fn is_connected(&self) -> bool {
        self.0.is_connected()
    }

    pub(crate) fn receive(&self) -> Result<Option<A>, String> {
        Ok(unless_full(|| self.0.receive())?.map(|answer| *answer.payload()))
    }
}

/// A request that waits for its answer.
pub(crate) type Request<Q, A> = ActiveRequest<Ipc, Q, (), A, ()>;

/// The one server of a service.
pub(crate) struct Server<Q: Record, A: Record> {
    port: ServerPort<Ipc, Q, (), A, ()>,
    /// The subject of error messages.
    what: &'static str,
}

impl<Q: Record, A: Record> Server<Q, A> {
    pub(crate) fn open(
        service: &RequestService<Q, A>,
        participant: &Participant,
    ) -> Result<Self, OpenError> {
        let opened = requests(service, participant)?;
        let port = place(&opened, 1, || {
            let builder =
                opened.server_builder().backpressure_strategy(BackpressureStrategy::DiscardData);
            builder.max_loaned_responses_per_request(1).create()
        })?;
        Ok(Self { port, what: service.subject })
    }

    pub(crate) fn take(&self) -> Result<Option<Request<Q, A>>, ReadError> {
        received(self.what, || self.port.receive())
    }
}

/// Answers a request.
pub(crate) fn answer<Q: Record, A: Record>(request: &Request<Q, A>, answer: A) {
    let loaned = loan_record(|| request.loan_uninit(), |loaned| loaned.payload_mut());
    let sent = loaned.and_then(|loaned| unless_full(|| loaned.write_payload(answer).send()));
    if let Err(error) = sent {
        tracing::debug!(%error, "answering a request");
    }
}
