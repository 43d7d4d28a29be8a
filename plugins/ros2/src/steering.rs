//! Commands to the fleet: through its manager if it has one, else straight to the engine.

use std::collections::HashMap;
use std::time::Duration;

use regatta_kit::{DispatchError, Dispatcher, WayError};
use regatta_plugin::event::{EventKind, EventRecord};
use regatta_plugin::{
    CommandError, Commands, FleetName, ManagerClient, ManagerError, Result, tell,
};

use crate::link::Logger;
use crate::options::robot_name;

/// The time within which the fleet's world is there.
const TIMEOUT: Duration = Duration::from_secs(5);

/// The reason why a robot can't be sent.
#[derive(Debug, thiserror::Error)]
pub(crate) enum SteeringError {
    #[error(transparent)]
    Manager(#[from] ManagerError),
    #[error(transparent)]
    Way(#[from] DispatchError),
    #[error(transparent)]
    Command(#[from] CommandError),
}

/// A robot that was sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Sent {
    /// It drives there, now or when its order is finished.
    OnItsWay,
    /// It is there.
    There,
}

/// A command that the engine refused.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Refusal {
    pub robot: u32,
    pub reason: String,
}

/// The ports of commands.
pub(crate) struct Steering {
    fleet: FleetName,
    dispatcher: Dispatcher,
    manager: ManagerClient,
    logger: Logger,
    /// Robots by the tokens of commands that aren't answered yet.
    pending: HashMap<u64, u32>,
    /// Whether the user was told of a refusal.
    has_told: bool,
}

impl Steering {
    pub fn join(fleet: &FleetName, logger: Logger) -> Result<Self> {
        Ok(Self {
            fleet: fleet.clone(),
            dispatcher: Dispatcher::join(fleet, "ros2", TIMEOUT)?,
            manager: ManagerClient::open(fleet)?,
            logger,
            pending: HashMap::new(),
            has_told: false,
        })
    }

    pub fn fleet(&self) -> &FleetName {
        &self.fleet
    }

    /// Sends a robot to a node, by its id.
    pub fn send(&mut self, robot: u32, node: u32) -> Result<Sent, SteeringError> {
        if self.manager.has_manager() {
            self.manager.send(robot, node)?;
            return Ok(Sent::OnItsWay);
        }
        let find = |world: &regatta_plugin::World<'_>| {
            let place = world.nodes().iter().position(|other| other.id == node);
            place.ok_or_else(|| WayError::UnknownNode(node.to_string()))
        };
        let legs = match self.dispatcher.way(robot, find, false) {
            Ok(legs) => legs,
            Err(DispatchError::Way(WayError::AtGoal { .. })) => return Ok(Sent::There),
            Err(error) => return Err(error.into()),
        };
        self.give(robot, |commands| commands.assign(robot, &legs))?;
        Ok(Sent::OnItsWay)
    }

    /// Lets a robot give its goal up.
    pub fn cancel(&mut self, robot: u32) -> Result<(), SteeringError> {
        if self.manager.has_manager() {
            self.manager.recall(robot)?;
            return Ok(());
        }
        self.give(robot, |commands| commands.cancel(robot)).map(|_| ())
    }

    /// Gives a command, whose refusal is logged as one for this robot. Returns its token.
    pub fn give(
        &mut self,
        robot: u32,
        command: impl FnOnce(&mut Commands) -> u64,
    ) -> Result<u64, SteeringError> {
        let token = self.dispatcher.give(command)?;
        self.pending.insert(token, robot);
        Ok(token)
    }

    /// The answers to commands since the last call.
    pub fn answers(&mut self) -> Result<Vec<EventRecord>> {
        let answers = self.dispatcher.answers()?;
        Ok(answers.into_iter().filter(|answer| self.pending.contains_key(&answer.token)).collect())
    }

    /// Notes an answer, and returns the refusal if it is one.
    pub fn note(&mut self, answer: &EventRecord) -> Option<Refusal> {
        let robot = self.pending.remove(&answer.token)?;
        if answer.kind() != Some(EventKind::Refused) {
            return None;
        }
        let reason = self.dispatcher.refusal(*answer).to_string();
        Some(Refusal { robot, reason })
    }

    /// Answers a request of a robot that can't be met.
    pub fn log_refusal(&mut self, what: &str, robot: u32, reason: &str) {
        self.log(&format!("{what} of {}", robot_name(robot)), reason);
    }

    /// Answers a request that can't be met: in the log of ROS, and once on standard error.
    pub fn log(&mut self, what: &str, reason: &str) {
        let text = format!("{what} refused: {reason}");
        self.logger.warn(&text);
        if !std::mem::replace(&mut self.has_told, true) {
            tell!("ros2: {text}; further refusals are on /rosout");
        }
    }
}
