//! The routes of selected robots, polled a few times a second.

use std::time::{Duration, Instant};

use regatta_plugin::ports::error::RequestError;
use regatta_plugin::route::RouteResponse;
use regatta_plugin::{OpenError, Participant, RouteClient, RouteError};

/// The maximum number of robots whose routes are polled.
pub const MAX_ROBOTS: usize = 8;
/// The time between two polls.
const POLL_EVERY: Duration = Duration::from_millis(250);

/// Polls the routes of some robots.
#[derive(Debug, Default)]
pub struct RoutePoller {
    robots: Vec<u32>,
    /// Open only while routes are polled.
    client: Option<RouteClient>,
    due: Option<Instant>,
}

impl RoutePoller {
    /// Sets the robots whose routes are polled from now on: the first [`MAX_ROBOTS`] of them.
    pub fn watch(&mut self, mut robots: Vec<u32>, now: Instant) {
        robots.truncate(MAX_ROBOTS);
        self.due = (!robots.is_empty()).then_some(now);
        self.robots = robots;
    }

    /// The time of the next poll; `None` if no robots are watched.
    pub fn due(&self) -> Option<Instant> {
        self.due
    }

    /// Requests the routes if a poll is due, and waits for the answers for `timeout` at most.
    /// Returns `None` if nothing is new, and an empty list if no process answers.
    ///
    /// # Errors
    /// As [`RouteClient::open_on`]. Polling stops then.
    pub fn poll(
        &mut self,
        participant: &Participant,
        timeout: Duration,
    ) -> Result<Option<Vec<RouteResponse>>, OpenError> {
        if self.robots.is_empty() {
            self.client = None;
        }
        if self.due.is_none_or(|due| Instant::now() < due) {
            return Ok(None);
        }
        self.due = None;
        let client = match &mut self.client {
            Some(client) => client,
            none => none.insert(RouteClient::open_on(participant)?),
        };
        let answers = client.routes(&self.robots, timeout);
        self.due = Some(Instant::now() + POLL_EVERY);
        Ok(match answers {
            Ok(routes) => Some(routes),
            Err(RouteError::Request(RequestError::Timeout { .. })) => None,
            Err(error) => {
                tracing::debug!(%error, "polling routes");
                Some(Vec::new())
            }
        })
    }
}
