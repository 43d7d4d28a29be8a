//! Both sides of a request-response service: a client sends a request and waits for its one answer,
//! the server answers.

use std::time::{Duration, Instant};

use super::error::{OpenError, ReadError, RequestError};
use super::services::RequestService;
use crate::process::join::Participant;
use crate::records::Record;
use crate::records::name::FleetName;
pub(super) use crate::transport::{Asked, Request};
use crate::transport::{Client, Server};

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
pub(super) struct Asker<Q: Record, A: Record> {
    client: Client<Q, A>,
    /// The server in error messages, such as `the engine`.
    server: &'static str,
    fleet: FleetName,
}

impl<Q: Record, A: Record> Asker<Q, A> {
    /// Opens a client of a service.
    pub(super) fn open(
        service: &RequestService<Q, A>,
        participant: &Participant,
    ) -> Result<Self, OpenError> {
        let (server, fleet) = (service.server, participant.fleet().clone());
        Ok(Self { client: Client::open(service, participant)?, server, fleet })
    }

    /// Whether the service has a server. One that was killed counts until another process joins the
    /// fleet.
    pub(super) fn has_server(&self) -> bool {
        self.client.has_server()
    }

    /// Sends a request.
    pub(super) fn send(&self, request: Q) -> Result<Asked<Q, A>, NoAnswer> {
        if !self.has_server() {
            return Err(NoAnswer::NoServer);
        }
        self.client.send(request).map_err(|reason| NoAnswer::Failed(self.unreachable(reason)))
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
            let connected = asked.is_connected();
            let answer = asked.receive().map_err(|reason| self.unreachable(reason))?;
            if let Some(answer) = answer {
                return Ok(answer);
            }
            let (server, fleet) = (self.server, &self.fleet);
            if !connected {
                return Err(RequestError::Gone { server, fleet: fleet.clone() });
            }
            if start.elapsed() >= timeout || !self.client.may_wait() {
                return Err(RequestError::Timeout { server, fleet: fleet.clone(), timeout });
            }
            if start.elapsed() >= next_check {
                next_check += CHECK;
                // A server that was killed counts as connected until its resources are removed.
                self.client.forget_dead();
            }
            std::thread::sleep(POLL);
        }
    }
}

/// The one server of a service.
pub(super) struct Responder<Q: Record, A: Record> {
    server: Server<Q, A>,
}

impl<Q: Record, A: Record> Responder<Q, A> {
    /// Opens the server of a service.
    pub(super) fn open(
        service: &RequestService<Q, A>,
        participant: &Participant,
    ) -> Result<Self, OpenError> {
        Ok(Self { server: Server::open(service, participant)? })
    }

    /// Takes the oldest request that has arrived.
    pub(super) fn take(&self) -> Result<Option<Request<Q, A>>, ReadError> {
        self.server.take()
    }

    /// Answers the requests that have arrived, at most `most` of them.
    pub(super) fn answer_all(
        &self,
        most: usize,
        mut answer: impl FnMut(&Q) -> A,
    ) -> Result<(), ReadError> {
        for _ in 0..most {
            let Some(request) = self.take()? else { break };
            request.answer(answer(request.payload()));
        }
        Ok(())
    }
}

impl<Q: Record, A: Record> core::fmt::Debug for Asker<Q, A> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Asker").field("server", &self.server).finish_non_exhaustive()
    }
}

impl<Q: Record, A: Record> core::fmt::Debug for Responder<Q, A> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("Responder")
    }
}
