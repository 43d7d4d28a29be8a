//! Both sides of requests to the fleet manager: it answers, any process asks.

use std::time::Duration;

use super::ask::{Asker, NoAnswer, Responder};
use super::error::{OpenError, ReadError, RequestError};
use super::services;
use crate::process::join::Participant;
use crate::records::manager::{ManagerAnswer, ManagerRequest, ManagerResponse};
use crate::records::name::FleetName;

/// The error of a request to the fleet manager.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ManagerError {
    /// The fleet has no manager that takes requests.
    #[error(
        "fleet '{fleet}' has no fleet manager that takes requests; `regatta command assign` sends a \
         robot without one"
    )]
    NoManager {
        /// The fleet.
        fleet: FleetName,
    },
    /// The manager hasn't answered.
    #[error(transparent)]
    Request(#[from] RequestError),
    /// The manager refused the request, and has changed nothing.
    #[error("refused: {}", refusal(.request, *.answer))]
    Refused {
        /// The request.
        request: ManagerRequest,
        /// Its answer; `None` for one that this version doesn't know.
        answer: Option<ManagerAnswer>,
    },
}

fn refusal(request: &ManagerRequest, answer: Option<ManagerAnswer>) -> String {
    let ManagerRequest { robot, node, .. } = request;
    match answer {
        Some(ManagerAnswer::UnknownRobot) => format!("there is no robot {robot}"),
        Some(ManagerAnswer::UnknownNode) => format!("there is no node {node}"),
        Some(ManagerAnswer::NoWay) => format!("robot {robot} has no way to node {node}"),
        Some(ManagerAnswer::NotSent) => format!("robot {robot} was not sent anywhere"),
        Some(ManagerAnswer::NotReady) => "the fleet manager has seen no frame yet".to_owned(),
        _ => "the fleet manager doesn't know how".to_owned(),
    }
}

/// Asks a fleet's manager to send robots somewhere.
///
/// ```no_run
/// use regatta_plugin::{FleetName, ManagerClient, Result};
///
/// # fn main() -> Result {
/// let manager = ManagerClient::open(&FleetName::default())?;
/// manager.send(7, 446)?;
/// manager.recall(7)?;
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct ManagerClient {
    asker: Asker<ManagerRequest, ManagerResponse>,
}

impl ManagerClient {
    /// The time that a client waits for an answer: managers answer between two cycles, also while
    /// the clock is paused.
    pub const TIMEOUT: Duration = Duration::from_secs(5);

    /// Opens the requests of a fleet, whether or not it has a manager yet.
    ///
    /// # Errors
    /// [`OpenError::OtherVersion`] if the fleet uses another contract, [`OpenError::Full`] if it
    /// has [`MAX_CONTROL_CLIENTS`](services::MAX_CONTROL_CLIENTS) clients, else
    /// [`OpenError::SharedMemory`].
    pub fn open(fleet: &FleetName) -> Result<Self, OpenError> {
        Self::open_on(&Participant::join(fleet, "manager-requests")?)
    }

    /// Opens the requests for a process that has joined the fleet.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub fn open_on(participant: &Participant) -> Result<Self, OpenError> {
        Ok(Self { asker: Asker::open(&services::MANAGER, participant)? })
    }

    /// Whether the fleet has a manager that takes requests. A manager that was killed counts until
    /// another process joins the fleet.
    pub fn has_manager(&self) -> bool {
        self.asker.has_server()
    }

    /// Sends a robot to a node, by its id: now, or when its order is finished, as the answer says.
    ///
    /// # Errors
    /// [`ManagerError`], also if the manager refuses.
    pub fn send(&self, robot: u32, node: u32) -> Result<ManagerResponse, ManagerError> {
        self.ask(ManagerRequest::send(robot, node))
    }

    /// Calls a robot back, so that it is managed as before.
    ///
    /// # Errors
    /// [`ManagerError`], also if the manager refuses.
    pub fn recall(&self, robot: u32) -> Result<ManagerResponse, ManagerError> {
        self.ask(ManagerRequest::recall(robot))
    }

    fn ask(&self, request: ManagerRequest) -> Result<ManagerResponse, ManagerError> {
        let response = match self.asker.ask(request, Self::TIMEOUT) {
            Ok(response) => response,
            Err(NoAnswer::NoServer) => {
                return Err(ManagerError::NoManager { fleet: self.asker.fleet().clone() });
            }
            Err(NoAnswer::Failed(error)) => return Err(error.into()),
        };
        match response.answer() {
            Some(answer) if answer.is_granted() => Ok(response),
            answer => Err(ManagerError::Refused { request, answer }),
        }
    }
}

/// Answers for a fleet manager.
///
/// ```
/// use regatta_plugin::manager::{ManagerAnswer, ManagerResponse};
/// use regatta_plugin::{ManagerServer, Participant, Result};
///
/// # fn main() -> Result {
/// # let fleet = format!("doc-manager-{}", std::process::id()).parse()?;
/// let mut server = ManagerServer::open_on(&Participant::join(&fleet, "manager")?)?;
/// server.answer(|request| ManagerResponse::new(request, ManagerAnswer::NotReady, 0))?;
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct ManagerServer {
    server: Responder<ManagerRequest, ManagerResponse>,
}

impl ManagerServer {
    /// Opens the requests of a fleet, for answering.
    ///
    /// # Errors
    /// [`OpenError::Full`] if another process answers for this fleet, [`OpenError::OtherVersion`]
    /// if it uses another contract, else [`OpenError::SharedMemory`].
    pub fn open_on(participant: &Participant) -> Result<Self, OpenError> {
        Ok(Self { server: Responder::open(&services::MANAGER, participant)? })
    }

    /// Answers the requests that have come since the last call.
    ///
    /// # Errors
    /// [`ReadError::Receive`] if a connection is broken.
    pub fn answer(
        &mut self,
        answer: impl FnMut(&ManagerRequest) -> ManagerResponse,
    ) -> Result<(), ReadError> {
        self.server.answer_all(usize::MAX, answer)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn join(name: &str) -> Participant {
        let fleet: FleetName =
            format!("unit-{name}-{}", std::process::id()).parse().expect("a name");
        Participant::join(&fleet, "test").expect("joined")
    }

    #[test]
    fn a_manager_answers_each_request() {
        let participant = join("manager");
        let mut server = ManagerServer::open_on(&participant).expect("a server");
        let fleet = participant.fleet().clone();
        let client = std::thread::spawn(move || {
            let client = ManagerClient::open(&fleet).expect("a client");
            (client.send(3, 40), client.recall(3))
        });
        let mut requests = Vec::new();
        while requests.len() < 2 {
            let take = |request: &ManagerRequest| {
                requests.push(*request);
                let answer = [ManagerAnswer::Later, ManagerAnswer::NotSent][requests.len() - 1];
                ManagerResponse::new(request, answer, 9)
            };
            server.answer(take).expect("readable");
            std::thread::sleep(Duration::from_millis(1));
        }
        let (sent, recalled) = client.join().expect("no panic");
        assert_eq!(requests, [ManagerRequest::send(3, 40), ManagerRequest::recall(3)]);
        assert_eq!(
            sent.map(|response| (response.order, response.answer())),
            Ok((9, Some(ManagerAnswer::Later)))
        );
        assert_eq!(
            recalled.expect_err("refused").to_string(),
            "refused: robot 3 was not sent anywhere"
        );
    }

    #[test]
    fn without_a_manager_nobody_is_waited_for() {
        let participant = join("no-manager");
        let client = ManagerClient::open_on(&participant).expect("a client");
        let error = client.send(1, 2).expect_err("nobody answers");
        assert!(
            !client.has_manager() && matches!(error, ManagerError::NoManager { .. }),
            "{error}"
        );
    }
}
