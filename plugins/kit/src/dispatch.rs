//! Commands with answers, for a person or a program that gives single commands.

use std::time::{Duration, Instant};

use regatta_plugin::command::RouteLeg;
use regatta_plugin::event::{EventKind, EventRecord, Refusal};
use regatta_plugin::{
    CommandError, Commands, Control, EventReader, FleetName, OpenError, Participant, ReadError,
    World, WorldReader,
};

use super::way::{WayError, way_to};

/// The interval at which answers are polled.
const POLL: Duration = Duration::from_millis(2);

/// The error of a command, or of waiting for its answer.
#[derive(Debug, thiserror::Error)]
pub enum DispatchError {
    /// A port of the fleet can't be opened.
    #[error(transparent)]
    Open(#[from] OpenError),
    /// A port of the fleet can't be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// The command can't be sent.
    #[error(transparent)]
    Send(#[from] CommandError),
    /// There is no way to a node.
    #[error(transparent)]
    Way(#[from] WayError),
    /// The fleet has no world.
    #[error("fleet '{0}' has no world; is it running?")]
    NoWorld(FleetName),
    /// The command was refused, and changed nothing.
    #[error("refused: {}", refusal_text(.0))]
    Refused(EventRecord),
    /// The command was refused, because another process moves the robots.
    #[error(
        "refused: {owner} moves the robots of fleet '{fleet}'; stop it first, or ask it to send a \
         robot with `regatta command send`"
    )]
    NotOwner {
        /// The fleet.
        fleet: FleetName,
        /// The owner of the movement: its name and number.
        owner: String,
    },
    /// No answer came in time.
    #[error(
        "the fleet has not answered within {} s; is it paused? It takes the command at its next \
         tick",
        .0.as_secs()
    )]
    NoAnswer(Duration),
}

/// Gives commands to a fleet, and waits for their answers.
#[derive(Debug)]
pub struct Dispatcher {
    participant: Participant,
    events: EventReader,
    commands: Commands,
    timeout: Duration,
}

impl Dispatcher {
    /// Joins a fleet. The name is that of the sender. A command waits for its answer for at most
    /// this time.
    ///
    /// # Errors
    /// [`OpenError`] as [`Commands::open`].
    pub fn join(fleet: &FleetName, name: &str, timeout: Duration) -> Result<Self, OpenError> {
        let participant = Participant::join(fleet, name)?;
        let events = EventReader::open_on(&participant)?;
        let commands = Commands::open_on(&participant)?;
        Ok(Self { participant, events, commands, timeout })
    }

    /// Sends a command without waiting for its [answer](Self::answers). Returns its token. One that
    /// can't be sent is dropped.
    ///
    /// # Errors
    /// [`CommandError`].
    pub fn give(
        &mut self,
        command: impl FnOnce(&mut Commands) -> u64,
    ) -> Result<u64, CommandError> {
        let token = command(&mut self.commands);
        self.commands.send().inspect_err(|_| self.commands.clear())?;
        Ok(token)
    }

    /// The answers to the commands of all senders since the last call: acceptances and refusals.
    ///
    /// # Errors
    /// [`ReadError`] if the connection is broken.
    pub fn answers(&mut self) -> Result<Vec<EventRecord>, ReadError> {
        let mut answers = Vec::new();
        self.events.take(|tick| {
            let events = tick.records.iter().copied();
            answers.extend(events.filter(|event| {
                matches!(event.kind(), Some(EventKind::Accepted | EventKind::Refused))
            }));
            Ok::<_, ReadError>(())
        })?;
        Ok(answers)
    }

    /// Returns the fastest way of a robot to a node. `find` returns the node's index.
    ///
    /// # Errors
    /// See [`DispatchError`].
    pub fn way(
        &self,
        robot: u32,
        find: impl FnOnce(&World<'_>) -> Result<usize, WayError>,
        reverse: bool,
    ) -> Result<Vec<RouteLeg>, DispatchError> {
        Ok(self.world(|world| way_to(&self.participant, world, robot, find(world)?, reverse))??)
    }

    /// Sends a command, given by its token, and returns the event that accepts it.
    ///
    /// # Errors
    /// See [`DispatchError`]; among them that it was refused.
    pub fn send(
        &mut self,
        command: impl FnOnce(&mut Commands) -> u64,
    ) -> Result<EventRecord, DispatchError> {
        let token = self.give(command)?;
        let answer = self.answer(token)?;
        match answer.kind() {
            Some(EventKind::Accepted) => Ok(answer),
            _ => Err(self.refusal(answer)),
        }
    }

    /// Returns the error of a command that was refused, given its answer.
    pub fn refusal(&self, answer: EventRecord) -> DispatchError {
        if answer.detail == Refusal::NotOwner as u32
            && let Some(owner) = self.owner()
        {
            return DispatchError::NotOwner { fleet: self.participant.fleet().clone(), owner };
        }
        DispatchError::Refused(answer)
    }

    /// The process that owns the movement of the robots, if the engine says so.
    fn owner(&self) -> Option<String> {
        let status = Control::open_on(&self.participant).ok()?.status().ok()?;
        status.owner().map(str::to_owned)
    }

    /// Sends a robot to a node by the fastest way. `find` returns the node's index.
    ///
    /// # Errors
    /// See [`DispatchError`].
    pub fn send_to(
        &mut self,
        robot: u32,
        find: impl FnOnce(&World<'_>) -> Result<usize, WayError>,
        reverse: bool,
    ) -> Result<EventRecord, DispatchError> {
        let legs = self.way(robot, find, reverse)?;
        self.send(|commands| commands.assign(robot, &legs))
    }

    /// Calls `read` with the world.
    ///
    /// # Errors
    /// [`DispatchError::NoWorld`], or if it can't be read.
    pub fn world<T>(&self, read: impl FnOnce(&World<'_>) -> T) -> Result<T, DispatchError> {
        let mut worlds = WorldReader::open_on(&self.participant)?;
        let start = Instant::now();
        loop {
            if let Some(world) = worlds.latest()? {
                return Ok(read(&world));
            }
            if start.elapsed() > self.timeout {
                return Err(DispatchError::NoWorld(self.participant.fleet().clone()));
            }
            std::thread::sleep(POLL);
        }
    }

    fn answer(&mut self, token: u64) -> Result<EventRecord, DispatchError> {
        let start = Instant::now();
        while start.elapsed() < self.timeout {
            if let Some(answer) = self.answers()?.into_iter().find(|answer| answer.token == token) {
                return Ok(answer);
            }
            std::thread::sleep(POLL);
        }
        Err(DispatchError::NoAnswer(self.timeout))
    }
}

/// Returns the reason of a refusal in words, such as `edge 9 is closed`.
pub fn refusal_text(answer: &EventRecord) -> String {
    use Refusal::*;
    let id = answer.id;
    let reasons = [
        (UnknownRobot, format!("there is no robot {id}")),
        (UnknownEdge, format!("there is no edge {id}")),
        (UnknownNode, format!("there is no node {id}")),
        (UnknownRobotType, format!("there is no robot type {id}")),
        (
            NotConnected,
            format!("edge {id} doesn't start where the route before it, or the robot's edge, ends"),
        ),
        (NoReverse, format!("edge {id} can't be driven in reverse gear")),
        (MalformedRoute, "the route has no edges".to_owned()),
        (DistanceOutOfRange, format!("the distance is not on edge {id}")),
        (FleetFull, "the fleet has reached its maximum size".to_owned()),
        (MalformedCommand, "the command is malformed".to_owned()),
        (NotSteerable, "this producer takes no commands; an engine does".to_owned()),
        (NotAhead, format!("edge {id} is not ahead in the robot's plan, or is released already")),
        (EdgeClosed, format!("edge {id} is closed")),
        (NotOwner, "another process moves the robots of this fleet".to_owned()),
        (NoDoor, format!("no door is across edge {id}")),
        (NoLift, format!("node {id} is in no lift")),
        (LiftInUse, format!("the lift of node {id} is in use by another robot; try again later")),
        (NoCabin, format!("the cabin of the lift isn't at {id}")),
    ];
    let reason = reasons.into_iter().find(|(reason, _)| *reason as u32 == answer.detail);
    reason.map_or_else(|| format!("reason {}", answer.detail), |(_, text)| text)
}
