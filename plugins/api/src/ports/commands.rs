//! The sender's side of commands.

use super::error::{FULL, OpenError, PublishError};
use super::services;
use super::slices::SliceSender;
use crate::process::join::Participant;
use crate::records::command::{CommandHeader, CommandKind, CommandRecord, RouteLeg};
use crate::records::name::FleetName;
use crate::records::order::NO_ROBOT;

/// The error of sending commands. They are kept, to be sent again.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CommandError {
    /// The fleet has no engine.
    #[error(
        "fleet '{fleet}' has no engine to take commands; start one, or name another fleet with \
         --fleet"
    )]
    NoEngine {
        /// The fleet.
        fleet: FleetName,
    },
    /// [`COMMAND_BUFFER`](services::COMMAND_BUFFER) samples wait already.
    #[error(
        "fleet '{fleet}' has not taken the last {} samples of commands (is it paused?); send fewer, \
         or wait",
        services::COMMAND_BUFFER
    )]
    Full {
        /// The fleet.
        fleet: FleetName,
    },
    /// `/dev/shm` is full. The commands are kept, and a later attempt may succeed.
    #[error("can't send commands: {FULL}; `regatta doctor` shows how much there is")]
    MemoryFull,
    /// iceoryx2 can't deliver the commands.
    #[error("can't send commands ({reason}); `regatta doctor` reports what is wrong")]
    Send {
        /// iceoryx2's reason.
        reason: String,
    },
}

/// Sends commands: collects them, then sends them as one sample, so that all take effect in the
/// same tick.
///
/// Each command gets a token, which the events that answer it carry: a hash of the sender's name
/// (32 bits) and a count (32 bits). So a sender's tokens are the same in every run, and those of
/// two senders differ unless they have the same name, or one chance in four billion makes their
/// hashes equal.
///
/// ```no_run
/// use regatta_plugin::command::RouteLeg;
/// use regatta_plugin::{FleetName, Commands, Result};
///
/// # fn main() -> Result {
/// let mut commands = Commands::open(&FleetName::default())?;
/// commands.hold(4);
/// commands.assign(7, &[RouteLeg::forward(12), RouteLeg::forward(13).horizon()]);
/// commands.send()?;
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct Commands {
    sender: SliceSender<CommandRecord, CommandHeader>,
    fleet: FleetName,
    sender_hash: u64,
    last_token: u64,
    records: Vec<CommandRecord>,
}

impl Commands {
    /// Opens the commands of a fleet, whether or not it has an engine yet.
    ///
    /// # Errors
    /// [`OpenError::OtherVersion`] if the fleet uses another contract, [`OpenError::Full`] if it
    /// has [`MAX_COMMAND_SENDERS`](services::MAX_COMMAND_SENDERS) senders, else
    /// [`OpenError::SharedMemory`].
    pub fn open(fleet: &FleetName) -> Result<Self, OpenError> {
        Self::open_on(&Participant::join(fleet, &format!("commands-{}", std::process::id()))?)
    }

    /// Opens the commands for a process that has joined the fleet. The participant's name is the
    /// sender's.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub fn open_on(participant: &Participant) -> Result<Self, OpenError> {
        let sender_hash = fnv1a(participant.name().as_bytes());
        Ok(Self {
            sender: SliceSender::open(&services::COMMANDS, participant, services::FIRST_RECORDS)?,
            fleet: participant.fleet().clone(),
            sender_hash,
            last_token: sender_hash << 32,
            records: Vec::new(),
        })
    }

    /// Gives a robot a new route. Returns the command's token.
    pub fn assign(&mut self, robot: u32, legs: &[RouteLeg]) -> u64 {
        self.route(CommandKind::Assign, robot, legs)
    }

    /// Drops a robot's horizon and appends legs to its released base. Returns the command's token.
    pub fn extend(&mut self, robot: u32, legs: &[RouteLeg]) -> u64 {
        self.route(CommandKind::Extend, robot, legs)
    }

    /// Releases a robot's horizon up to `metres` along a leg, from where the leg is entered;
    /// infinity for all of it. The leg is the first one with this edge and gear at or after the end
    /// of the base. Whether the leg is [released](RouteLeg::released) or not doesn't matter.
    /// Returns the command's token.
    pub fn release(&mut self, robot: u32, leg: RouteLeg, metres: f32) -> u64 {
        let record = CommandRecord {
            robot,
            id: leg.edge,
            reverse: leg.reverse.into(),
            s: metres,
            ..CommandRecord::default()
        };
        self.push(CommandKind::Release, record)
    }

    /// Drops a robot's route beyond its current edge. Returns the command's token.
    pub fn cancel(&mut self, robot: u32) -> u64 {
        self.push(CommandKind::Cancel, CommandRecord { robot, ..CommandRecord::default() })
    }

    /// Makes a robot brake and stop. Returns the command's token.
    pub fn hold(&mut self, robot: u32) -> u64 {
        self.push(CommandKind::Hold, CommandRecord { robot, ..CommandRecord::default() })
    }

    /// Ends a hold. Returns the command's token.
    pub fn resume(&mut self, robot: u32) -> u64 {
        self.push(CommandKind::Resume, CommandRecord { robot, ..CommandRecord::default() })
    }

    /// Makes a robot break down. Returns the command's token.
    pub fn break_down(&mut self, robot: u32) -> u64 {
        self.push(CommandKind::Break, CommandRecord { robot, ..CommandRecord::default() })
    }

    /// Repairs a robot that is broken. Returns the command's token.
    pub fn repair(&mut self, robot: u32) -> u64 {
        self.push(CommandKind::Repair, CommandRecord { robot, ..CommandRecord::default() })
    }

    /// Closes an edge, by its id: no robot enters it any more. Returns the command's token.
    pub fn close_edge(&mut self, edge: u32) -> u64 {
        self.push(
            CommandKind::CloseEdge,
            CommandRecord { robot: NO_ROBOT, id: edge, ..CommandRecord::default() },
        )
    }

    /// Opens a closed edge again, by its id. Returns the command's token.
    pub fn open_edge(&mut self, edge: u32) -> u64 {
        self.push(
            CommandKind::OpenEdge,
            CommandRecord { robot: NO_ROBOT, id: edge, ..CommandRecord::default() },
        )
    }

    /// Opens the doors across an edge, by its id, for a robot ([`NO_ROBOT`] for an operator), or
    /// keeps them open. Returns the command's token.
    pub fn request_door(&mut self, robot: u32, edge: u32) -> u64 {
        let record = CommandRecord { robot, id: edge, ..CommandRecord::default() };
        self.push(CommandKind::RequestDoor, record)
    }

    /// Ends the request of doors for a robot. Returns the command's token.
    pub fn release_door(&mut self, robot: u32, edge: u32) -> u64 {
        let record = CommandRecord { robot, id: edge, ..CommandRecord::default() };
        self.push(CommandKind::ReleaseDoor, record)
    }

    /// Calls a lift to the level of a node in its cabin, by the node's id, for a robot
    /// ([`NO_ROBOT`] for an operator), or keeps it there. Returns the command's token.
    pub fn call_lift(&mut self, robot: u32, node: u32) -> u64 {
        let record = CommandRecord { robot, id: node, ..CommandRecord::default() };
        self.push(CommandKind::CallLift, record)
    }

    /// Ends the call of a lift, by a node in its cabin, for a robot. Returns the command's token.
    pub fn release_lift(&mut self, robot: u32, node: u32) -> u64 {
        let record = CommandRecord { robot, id: node, ..CommandRecord::default() };
        self.push(CommandKind::ReleaseLift, record)
    }

    /// Adds a robot on a node, by the node's id. Returns the command's token; the `Spawned` event
    /// has the robot's id.
    pub fn spawn_at_node(&mut self, robot_type: u32, node: u32) -> u64 {
        self.push(
            CommandKind::SpawnAtNode,
            CommandRecord { robot_type, id: node, ..CommandRecord::default() },
        )
    }

    /// Adds a robot on an edge, by the edge's id, `s` metres from its origin. Returns the command's
    /// token.
    pub fn spawn_on_edge(&mut self, robot_type: u32, edge: u32, s: f32) -> u64 {
        self.push(
            CommandKind::SpawnOnEdge,
            CommandRecord { robot_type, id: edge, s, ..CommandRecord::default() },
        )
    }

    /// Removes a robot from the fleet. Returns the command's token.
    pub fn remove(&mut self, robot: u32) -> u64 {
        self.push(CommandKind::Remove, CommandRecord { robot, ..CommandRecord::default() })
    }

    /// Collects commands of another sender, with their tokens and legs as they are: a gateway passes
    /// them on.
    pub fn pass_on(&mut self, records: &[CommandRecord]) {
        self.records.extend_from_slice(records);
    }

    /// The records collected so far.
    pub fn pending(&self) -> &[CommandRecord] {
        &self.records
    }

    /// Discards the collected records.
    pub fn clear(&mut self) {
        self.records.clear();
    }

    /// Sends the collected records, for the next tick. Does nothing if there are none.
    ///
    /// # Errors
    /// [`CommandError`]; the commands are kept, to be sent again or [cleared](Self::clear).
    pub fn send(&mut self) -> Result<(), CommandError> {
        if self.records.is_empty() {
            return Ok(());
        }
        let header = CommandHeader { sender: self.sender_hash };
        let receivers = self.sender.send(header, &self.records).map_err(|error| match error {
            PublishError::MemoryFull { .. } => CommandError::MemoryFull,
            PublishError::Loan { reason, .. } | PublishError::Send { reason, .. } => {
                CommandError::Send { reason }
            }
            other => CommandError::Send { reason: other.to_string() },
        })?;
        if receivers == 0 {
            let fleet = self.fleet.clone();
            return Err(match self.sender.readers() {
                0 => CommandError::NoEngine { fleet },
                _ => CommandError::Full { fleet },
            });
        }
        self.records.clear();
        Ok(())
    }

    fn route(&mut self, kind: CommandKind, robot: u32, legs: &[RouteLeg]) -> u64 {
        let token = self.push(
            kind,
            CommandRecord { robot, legs: legs.len() as u32, ..CommandRecord::default() },
        );
        self.records.extend(legs.iter().map(|leg| CommandRecord {
            token,
            kind: CommandKind::Leg as u32,
            id: leg.edge,
            reverse: leg.reverse.into(),
            released: leg.released.into(),
            ..CommandRecord::default()
        }));
        token
    }

    fn push(&mut self, kind: CommandKind, record: CommandRecord) -> u64 {
        self.last_token += 1;
        self.records.push(CommandRecord { token: self.last_token, kind: kind as u32, ..record });
        self.last_token
    }
}

/// The FNV-1a hash, 64 bits: the same name gives the same tokens in every run.
fn fnv1a(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, &byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
    })
}
