//! Both sides of a request-response service: a client sends a request and waits for its one answer,
//! the server answers.

use core::fmt::Debug;
use std::time::{Duration, Instant};

use iceoryx2::active_request::ActiveRequest;
use iceoryx2::pending_response::PendingResponse;
use iceoryx2::port::client::Client;
use iceoryx2::port::server::Server;
use iceoryx2::prelude::*;

use super::error::{OpenError, ReadError, RequestError};
use super::full_memory::{loan_record, received, unless_full};
use super::places::place;
use super::services::{Ipc, RequestService, Requests};
use crate::process::join::Participant;
use crate::records::name::FleetName;

/// The time between two checks for an answer.
const POLL: Duration = Duration::from_micros(500);

/// The time between two checks whether the server is still alive.
const CHECK: Duration = Duration::from_secs(1);

/// The reason why there is no answer.
#[derive(Debug)]
pub(super) enum NoAnswer {
    /// The service has no server.
    NoServer,
    /// The server hasn't answered.
    Failed(RequestError),
}

/// A client of the one server of a service.
#[derive(Debug)]
pub(super) struct Asker<Q, A>
where
    Q: Copy + Debug + ZeroCopySend,
    A: Copy + Debug + ZeroCopySend,
{
    client: Client<Ipc, Q, (), A, ()>,
    service: Requests<Q, A>,
    /// The server in error messages, such as `the engine`.
    server: &'static str,
    fleet: FleetName,
}

/// A request that was sent.
pub(super) struct Asked<Q, A>(PendingResponse<Ipc, Q, (), A, ()>)
where
    Q: Copy + Debug + ZeroCopySend,
    A: Copy + Debug + ZeroCopySend;

impl<Q, A> Asker<Q, A>
where
    Q: Copy + Debug + ZeroCopySend,
    A: Copy + Debug + ZeroCopySend,
{
    /// Opens a client of a service.
    pub(super) fn open(
        service: &RequestService<Q, A>,
        participant: &Participant,
    ) -> Result<Self, OpenError> {
        let opened = service.open(participant)?;
        let client = place(&opened, service.clients, || {
            let builder = opened.client_builder();
            builder.backpressure_strategy(BackpressureStrategy::DiscardData).create()
        })?;
        let (server, fleet) = (service.server, participant.fleet().clone());
        Ok(Self { client, service: opened, server, fleet })
    }

    /// Whether the service has a server. One that was killed counts until another process joins the
    /// fleet.
    pub(super) fn has_server(&self) -> bool {
        self.service.dynamic_config().number_of_servers() > 0
    }

    /// Sends a request.
    pub(super) fn send(&self, request: Q) -> Result<Asked<Q, A>, NoAnswer> {
        if !self.has_server() {
            return Err(NoAnswer::NoServer);
        }
        let loaned = loan_record(|| self.client.loan_uninit(), |loaned| loaned.payload_mut());
        let sent = loaned.and_then(|loaned| unless_full(|| loaned.write_payload(request).send()));
        sent.map(Asked).map_err(|reason| NoAnswer::Failed(self.unreachable(reason)))
    }

    /// Sends a request, and waits for the answer.
    pub(super) fn ask(&self, request: Q, timeout: Duration) -> Result<A, NoAnswer> {
        let asked = self.send(request)?;
        self.wait(&asked, Instant::now(), timeout).map_err(NoAnswer::Failed)
    }

    /// The fleet of the service.
    pub(super) fn fleet(&self) -> &FleetName {
        &self.fleet
    }

    fn unreachable(&self, reason: String) -> RequestError {
        RequestError::Connection { server: self.server, fleet: self.fleet.clone(), reason }
    }

    /// Waits for the answer, for at most `timeout` from `start` on.
    pub(super) fn wait(
        &self,
        asked: &Asked<Q, A>,
        start: Instant,
        timeout: Duration,
    ) -> Result<A, RequestError> {
        let mut next_check = CHECK;
        loop {
            // Checked before receiving, so that an answer given just before the end is not missed.
            let connected = asked.0.is_connected();
            let answer = unless_full(|| asked.0.receive());
            if let Some(answer) = answer.map_err(|reason| self.unreachable(reason))? {
                return Ok(*answer.payload());
            }
            let (server, fleet) = (self.server, &self.fleet);
            if !connected {
                return Err(RequestError::Gone { server, fleet: fleet.clone() });
            }
            if start.elapsed() >= timeout {
                return Err(RequestError::Timeout { server, fleet: fleet.clone(), timeout });
            }
            if start.elapsed() >= next_check {
                next_check += CHECK;
                // A server that was killed counts as connected until its resources are removed.
                self.service.try_cleanup_dead_nodes();
            }
            std::thread::sleep(POLL);
        }
    }
}

/// A request that waits for its answer.
pub(super) type Request<Q, A> = ActiveRequest<Ipc, Q, (), A, ()>;

/// The one server of a service.
#[derive(Debug)]
pub(super) struct Responder<Q: Debug + ZeroCopySend, A: Debug + ZeroCopySend> {
    server: Server<Ipc, Q, (), A, ()>,
    /// The subject of error messages.
    what: &'static str,
}

impl<Q: Debug + ZeroCopySend, A: Debug + ZeroCopySend> Responder<Q, A> {
    /// Opens the server of a service.
    pub(super) fn open(
        service: &RequestService<Q, A>,
        participant: &Participant,
    ) -> Result<Self, OpenError> {
        let opened = service.open(participant)?;
        let server = place(&opened, 1, || {
            let builder =
                opened.server_builder().backpressure_strategy(BackpressureStrategy::DiscardData);
            builder.max_loaned_responses_per_request(1).create()
        })?;
        Ok(Self { server, what: service.subject })
    }

    /// Takes the oldest request that has arrived.
    pub(super) fn take(&self) -> Result<Option<Request<Q, A>>, ReadError> {
        received(self.what, || self.server.receive())
    }

    /// Answers the requests that have arrived, at most `most` of them.
    pub(super) fn answer_all(
        &self,
        most: usize,
        mut answer: impl FnMut(&Q) -> A,
    ) -> Result<(), ReadError> {
        for _ in 0..most {
            let Some(request) = self.take()? else { break };
            let response = answer(request.payload());
            self.answer(&request, response);
        }
        Ok(())
    }

    /// Answers a request. A client that has gone away, or is stopped, misses its answer; the server
    /// doesn't wait for it.
    pub(super) fn answer(&self, request: &Request<Q, A>, response: A) {
        let loaned = loan_record(|| request.loan_uninit(), |loaned| loaned.payload_mut());
        let sent = loaned.and_then(|loaned| unless_full(|| loaned.write_payload(response).send()));
        if let Err(error) = sent {
            tracing::debug!(%error, "answering {}", self.what);
        }
    }
}
