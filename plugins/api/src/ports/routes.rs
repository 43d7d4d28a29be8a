//! Both sides of the routes: a producer answers, any process asks.

use std::time::{Duration, Instant};

use super::ask::{Asked, Asker, NoAnswer, Responder};
use super::error::{OpenError, ReadError, RequestError};
use super::services;
use crate::process::join::Participant;
use crate::records::name::FleetName;
use crate::records::route::{RouteRequest, RouteResponse};

/// The error of a request for routes.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RouteError {
    /// The fleet has no producer, or one that knows no routes.
    #[error("no process of fleet '{fleet}' serves routes; only an engine does")]
    NoRoutes {
        /// The fleet.
        fleet: FleetName,
    },
    /// The engine hasn't answered.
    #[error(transparent)]
    Request(#[from] RequestError),
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
}

impl RouteClient {
    /// The time that [`route`](Self::route) waits for an answer.
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
        Ok(Self { asker: Asker::open(&services::ROUTES, participant)? })
    }

    /// Whether the fleet has a server of routes, which an engine is. One that was killed counts
    /// until another process joins the fleet.
    pub fn has_routes(&self) -> bool {
        self.asker.has_server()
    }

    /// Asks for a robot's route. An unknown robot is no error: see [`RouteResponse::is_found`].
    pub fn route(&mut self, robot: u32) -> Result<RouteResponse, RouteError> {
        let answer = self.asker.ask(RouteRequest::new(robot), Self::TIMEOUT);
        answer.map_err(|reason| self.failed(reason))
    }

    /// Asks for several robots' routes at once, and waits for all of them, `timeout` in all. The
    /// answers come in the order of the robots, [`MAX_OPEN_ROUTES`](services::MAX_OPEN_ROUTES) or
    /// so of the same tick.
    pub fn routes(
        &mut self,
        robots: &[u32],
        timeout: Duration,
    ) -> Result<Vec<RouteResponse>, RouteError> {
        let start = Instant::now();
        let mut routes = Vec::with_capacity(robots.len());
        for robots in robots.chunks(services::MAX_OPEN_ROUTES) {
            let asked: Result<Vec<_>, _> = robots.iter().map(|robot| self.ask(*robot)).collect();
            for asked in asked? {
                routes.push(self.asker.wait(&asked.0, start, timeout)?);
            }
        }
        Ok(routes)
    }

    /// Asks for a robot's route without waiting for the answer. At most
    /// [`MAX_OPEN_ROUTES`](services::MAX_OPEN_ROUTES) answers may be pending at a time.
    pub fn ask(&self, robot: u32) -> Result<PendingRoute, RouteError> {
        let asked = self.asker.send(RouteRequest::new(robot));
        asked.map(PendingRoute).map_err(|reason| self.failed(reason))
    }

    /// Returns the answer to [`ask`](Self::ask), once it has come. The producer answers between two
    /// ticks.
    ///
    /// # Errors
    /// [`RouteError`]: it will never come.
    pub fn answer(&self, pending: &PendingRoute) -> Result<Option<RouteResponse>, RouteError> {
        match self.asker.wait(&pending.0, Instant::now(), Duration::ZERO) {
            Ok(answer) => Ok(Some(answer)),
            Err(RequestError::Timeout { .. }) => Ok(None),
            Err(error) => Err(error.into()),
        }
    }

    fn failed(&self, reason: NoAnswer) -> RouteError {
        match reason {
            NoAnswer::NoServer => RouteError::NoRoutes { fleet: self.asker.fleet().clone() },
            NoAnswer::Failed(error) => error.into(),
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
///
/// ```
/// use regatta_plugin::route::RouteResponse;
/// use regatta_plugin::{Participant, Result, RouteServer};
///
/// # fn main() -> Result {
/// # let fleet = format!("doc-routes-{}", std::process::id()).parse()?;
/// let mut server = RouteServer::open_on(&Participant::join(&fleet, "producer")?)?;
/// // Between two ticks: robots have two legs left, along the edges 4 and 5, the first one released.
/// server.answer(100, |request| {
///     let edges = [(4, false), (5, false)];
///     RouteResponse::unknown(1, 7, request.robot).with_legs(1, 2, edges.into_iter())
/// })?;
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct RouteServer {
    server: Responder<RouteRequest, RouteResponse>,
}

impl RouteServer {
    /// Opens the routes of a fleet, for answering.
    ///
    /// # Errors
    /// [`OpenError::Full`] if another process answers for this fleet, [`OpenError::OtherVersion`]
    /// if it uses another contract, else [`OpenError::SharedMemory`].
    pub fn open_on(participant: &Participant) -> Result<Self, OpenError> {
        Ok(Self { server: Responder::open(&services::ROUTES, participant)? })
    }

    /// Answers the requests that have come since the last call, at most `most` requests; the rest
    /// waits for the next call. Allocates nothing of its own.
    ///
    /// # Errors
    /// [`ReadError::Receive`] if a connection is broken.
    pub fn answer(
        &mut self,
        most: usize,
        answer: impl FnMut(&RouteRequest) -> RouteResponse,
    ) -> Result<(), ReadError> {
        self.server.answer_all(most, answer)
    }
}
