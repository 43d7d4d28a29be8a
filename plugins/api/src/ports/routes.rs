//! Both sides of the routes: a producer answers, any process asks.

use std::time::{Duration, Instant};

use iceoryx2::port::server::Server;

use super::ask::{Asked, Asker, NoAnswer};
use super::error::{OpenError, ReadError};
use super::full_memory::received;
use super::inbox::reply;
use super::services::{self, Ipc};
use crate::process::join::Participant;
use crate::records::name::FleetName;
use crate::records::route::{RouteRequest, RouteResponse};

/// The error of a request for routes.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RouteError {
    /// Nobody answers: there is no producer, or one that knows no routes.
    #[error("no process of fleet '{fleet}' serves routes; only an engine does")]
    NoRoutes {
        /// The fleet.
        fleet: FleetName,
    },
    /// The producer has ended meanwhile.
    #[error("the engine of fleet '{fleet}' ended before it answered")]
    Gone {
        /// The fleet.
        fleet: FleetName,
    },
    /// The producer has not answered in time.
    #[error("the engine of fleet '{fleet}' has not answered within {:.1} s; is it stopped or overloaded?", timeout.as_secs_f32())]
    Timeout {
        /// The fleet.
        fleet: FleetName,
        /// How long it was waited for.
        timeout: Duration,
    },
    /// iceoryx2 can't deliver it.
    #[error(
        "can't reach the engine of fleet '{fleet}' ({reason}); `regatta doctor` reports what is wrong"
    )]
    Connection {
        /// The fleet.
        fleet: FleetName,
        /// iceoryx2's reason.
        reason: String,
    },
}

/// Asks a fleet's engine for robots' routes.
///
/// ```no_run
/// use regatta_plugin::{FleetName, Result, RouteClient};
///
/// # fn main() -> Result {
/// let mut routes = RouteClient::open(&FleetName::default())?;
/// let route = routes.route(7)?;
/// println!("robot {} has {} legs to drive, {} of them now", route.robot, route.legs, route.released);
/// for leg in route.legs() {
///     println!("edge {} of the world{}", leg.edge, if leg.released { "" } else { " (horizon)" });
/// }
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct RouteClient {
    asker: Asker<RouteRequest, RouteResponse>,
    fleet: FleetName,
}

impl RouteClient {
    /// How long [`route`](Self::route) waits for an answer.
    pub const TIMEOUT: Duration = Duration::from_secs(5);

    /// Opens the routes of a fleet, whether or not it has an engine yet.
    ///
    /// # Errors
    /// [`OpenError::OtherVersion`] if the fleet uses another contract, [`OpenError::Full`] if it
    /// has [`MAX_ROUTE_CLIENTS`](services::MAX_ROUTE_CLIENTS) clients, else
    /// [`OpenError::SharedMemory`].
    pub fn open(fleet: &FleetName) -> Result<Self, OpenError> {
        Self::open_on(&Participant::join(fleet, "routes")?)
    }

    /// Opens the routes for a process that has joined the fleet.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub fn open_on(participant: &Participant) -> Result<Self, OpenError> {
        let service = services::routes(participant.node(), participant.fleet())?;
        Ok(Self {
            asker: Asker::open(service, services::MAX_ROUTE_CLIENTS)?,
            fleet: participant.fleet().clone(),
        })
    }

    /// Whether somebody answers: an engine does. One that was killed counts until another process
    /// joins the fleet.
    pub fn has_routes(&self) -> bool {
        self.asker.has_server()
    }

    /// Asks for a robot's route. An unknown robot is no error: see [`RouteResponse::is_found`].
    ///
    /// # Errors
    /// [`RouteError`].
    pub fn route(&mut self, robot: u32) -> Result<RouteResponse, RouteError> {
        self.routes(&[robot], Self::TIMEOUT)?
            .pop()
            .ok_or(RouteError::Gone { fleet: self.fleet.clone() })
    }

    /// Asks for several robots' routes at once, and waits for all of them, `timeout` in all. The
    /// answers come in the order of the robots, [`MAX_OPEN_ROUTES`](services::MAX_OPEN_ROUTES) or
    /// so of the same tick.
    ///
    /// # Errors
    /// [`RouteError`].
    pub fn routes(
        &mut self,
        robots: &[u32],
        timeout: Duration,
    ) -> Result<Vec<RouteResponse>, RouteError> {
        let failed = |reason| self.failed(reason, timeout);
        let start = Instant::now();
        let mut routes = Vec::with_capacity(robots.len());
        for robots in robots.chunks(services::MAX_OPEN_ROUTES) {
            let asked = robots.iter().map(|robot| self.asker.send(RouteRequest::new(*robot)));
            for asked in asked.collect::<Result<Vec<_>, _>>().map_err(failed)? {
                let rest = timeout.saturating_sub(start.elapsed());
                routes.push(self.asker.wait(&asked, rest).map_err(failed)?);
            }
        }
        Ok(routes)
    }

    /// Asks for a robot's route without waiting for the answer. At most
    /// [`MAX_OPEN_ROUTES`](services::MAX_OPEN_ROUTES) answers may be pending at a time.
    ///
    /// # Errors
    /// [`RouteError`].
    pub fn ask(&self, robot: u32) -> Result<PendingRoute, RouteError> {
        self.asker
            .send(RouteRequest::new(robot))
            .map(PendingRoute)
            .map_err(|reason| self.failed(reason, Duration::ZERO))
    }

    /// Returns the answer to [`ask`](Self::ask), once it has come. The producer answers between two
    /// ticks.
    ///
    /// # Errors
    /// [`RouteError`]: it will never come.
    pub fn answer(&self, pending: &PendingRoute) -> Result<Option<RouteResponse>, RouteError> {
        match self.asker.wait(&pending.0, Duration::ZERO) {
            Ok(answer) => Ok(Some(answer)),
            Err(NoAnswer::Timeout) => Ok(None),
            Err(reason) => Err(self.failed(reason, Duration::ZERO)),
        }
    }

    fn failed(&self, reason: NoAnswer, timeout: Duration) -> RouteError {
        let fleet = self.fleet.clone();
        match reason {
            NoAnswer::NoServer => RouteError::NoRoutes { fleet },
            NoAnswer::Gone => RouteError::Gone { fleet },
            NoAnswer::Timeout => RouteError::Timeout { fleet, timeout },
            NoAnswer::Connection(reason) => RouteError::Connection { fleet, reason },
        }
    }
}

/// A route that was asked for with [`RouteClient::ask`].
pub struct PendingRoute(Asked<RouteRequest, RouteResponse>);

impl core::fmt::Debug for PendingRoute {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("PendingRoute")
    }
}

/// Answers for a producer that knows routes.
#[derive(Debug)]
pub struct RouteServer {
    server: Server<Ipc, RouteRequest, (), RouteResponse, ()>,
}

impl RouteServer {
    /// Opens the routes of a fleet, for answering.
    ///
    /// # Errors
    /// [`OpenError::Full`] if another process answers for this fleet, [`OpenError::OtherVersion`]
    /// if it uses another contract, else [`OpenError::SharedMemory`].
    pub fn open_on(participant: &Participant) -> Result<Self, OpenError> {
        let service = services::routes(participant.node(), participant.fleet())?;
        Ok(Self { server: services::only_server(&service)? })
    }

    /// Answers what was asked since the last call, at most `most` requests; the rest waits for the
    /// next call. Allocates nothing of its own.
    ///
    /// # Errors
    /// [`ReadError::Receive`] if a connection is broken.
    pub fn answer(
        &mut self,
        most: usize,
        mut answer: impl FnMut(&RouteRequest) -> RouteResponse,
    ) -> Result<(), ReadError> {
        for _ in 0..most {
            let Some(request) = received("route requests", || self.server.receive())? else {
                break;
            };
            // A client that has gone away, or is stopped, misses its answer; nobody waits for it.
            let response = answer(request.payload());
            if let Err(error) = reply(&request, response) {
                tracing::debug!(%error, "answering a route request");
            }
        }
        Ok(())
    }
}
