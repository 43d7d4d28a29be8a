//! The asking side of a request-response service: send, and wait for the one answer.

use core::fmt::Debug;
use std::time::{Duration, Instant};

use iceoryx2::pending_response::PendingResponse;
use iceoryx2::port::client::Client;
use iceoryx2::prelude::*;
use iceoryx2::service::port_factory::request_response;

use crate::error::OpenError;
use crate::qos::{self, Ipc};

/// Between two looks for an answer.
const POLL: Duration = Duration::from_micros(500);

/// Between two looks whether the server is still alive.
const CHECK: Duration = Duration::from_secs(1);

/// Why there is no answer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Silence {
    /// Nobody serves.
    Nobody,
    /// The server has ended meanwhile.
    Gone,
    /// It has not answered in time.
    Timeout,
    /// iceoryx2 can't deliver it, and why.
    Connection(String),
}

/// Asks the one server of a service.
#[derive(Debug)]
pub(crate) struct Asker<Q, A>
where
    Q: Copy + Debug + ZeroCopySend,
    A: Copy + Debug + ZeroCopySend,
{
    client: Client<Ipc, Q, (), A, ()>,
    service: request_response::PortFactory<Ipc, Q, (), A, ()>,
}

/// A question that was sent.
pub(crate) struct Asked<Q, A>(PendingResponse<Ipc, Q, (), A, ()>)
where
    Q: Copy + Debug + ZeroCopySend,
    A: Copy + Debug + ZeroCopySend;

impl<Q, A> Asker<Q, A>
where
    Q: Copy + Debug + ZeroCopySend,
    A: Copy + Debug + ZeroCopySend,
{
    /// Opens a client of a service that has room for `limit` of them.
    pub(crate) fn open(
        service: request_response::PortFactory<Ipc, Q, (), A, ()>,
        limit: usize,
    ) -> Result<Self, OpenError> {
        let client = service
            .client_builder()
            .backpressure_strategy(BackpressureStrategy::DiscardData)
            .create()
            .map_err(|e| qos::full_or(service.name(), limit, e))?;
        Ok(Self { client, service })
    }

    /// Whether somebody serves. One that was killed counts until another process joins the fleet.
    pub(crate) fn has_server(&self) -> bool {
        self.service.dynamic_config().number_of_servers() > 0
    }

    /// Sends a question.
    pub(crate) fn send(&self, question: Q) -> Result<Asked<Q, A>, Silence> {
        if !self.has_server() {
            return Err(Silence::Nobody);
        }
        self.client.send_copy(question).map(Asked).map_err(|e| Silence::Connection(e.to_string()))
    }

    /// Waits for the answer.
    pub(crate) fn wait(&self, asked: &Asked<Q, A>, timeout: Duration) -> Result<A, Silence> {
        let start = Instant::now();
        let mut next_check = CHECK;
        loop {
            // Asked before the look, so that an answer given just before the end is not missed.
            let connected = asked.0.is_connected();
            if let Some(answer) = asked.0.receive().map_err(|e| Silence::Connection(e.to_string()))? {
                return Ok(*answer.payload());
            }
            if !connected {
                return Err(Silence::Gone);
            }
            if start.elapsed() >= timeout {
                return Err(Silence::Timeout);
            }
            if start.elapsed() >= next_check {
                next_check += CHECK;
                // A server that was killed counts as connected until its traces are removed.
                self.service.try_cleanup_dead_nodes();
            }
            std::thread::sleep(POLL);
        }
    }
}
