//! The client's side of a request-response service: sends a request, and waits for its one answer.

use core::fmt::Debug;
use std::time::{Duration, Instant};

use iceoryx2::pending_response::PendingResponse;
use iceoryx2::port::client::Client;
use iceoryx2::prelude::*;
use iceoryx2::service::port_factory::request_response;

use super::error::OpenError;
use super::full_memory::{loan_record, unless_full};
use super::places::place;
use super::services::Ipc;

/// The time between two checks for an answer.
const POLL: Duration = Duration::from_micros(500);

/// The time between two checks whether the server is still alive.
const CHECK: Duration = Duration::from_secs(1);

/// The reason why there is no answer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum NoAnswer {
    /// The service has no server.
    NoServer,
    /// The server ended before it answered.
    Gone,
    /// The server has not answered in time.
    Timeout,
    /// iceoryx2 can't deliver the request or the answer, for this reason.
    Connection(String),
}

/// A client of the one server of a service.
#[derive(Debug)]
pub(super) struct Asker<Q, A>
where
    Q: Copy + Debug + ZeroCopySend,
    A: Copy + Debug + ZeroCopySend,
{
    client: Client<Ipc, Q, (), A, ()>,
    service: request_response::PortFactory<Ipc, Q, (), A, ()>,
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
    /// Opens a client of a service that has room for `limit` of them.
    pub(super) fn open(
        service: request_response::PortFactory<Ipc, Q, (), A, ()>,
        limit: usize,
    ) -> Result<Self, OpenError> {
        let create = || {
            service
                .client_builder()
                .backpressure_strategy(BackpressureStrategy::DiscardData)
                .create()
        };
        Ok(Self { client: place(&service, limit, create)?, service })
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
        sent.map(Asked).map_err(NoAnswer::Connection)
    }

    /// Waits for the answer.
    pub(super) fn wait(&self, asked: &Asked<Q, A>, timeout: Duration) -> Result<A, NoAnswer> {
        let start = Instant::now();
        let mut next_check = CHECK;
        loop {
            // Checked before receiving, so that an answer given just before the end is not missed.
            let connected = asked.0.is_connected();
            if let Some(answer) = unless_full(|| asked.0.receive()).map_err(NoAnswer::Connection)? {
                return Ok(*answer.payload());
            }
            if !connected {
                return Err(NoAnswer::Gone);
            }
            if start.elapsed() >= timeout {
                return Err(NoAnswer::Timeout);
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
