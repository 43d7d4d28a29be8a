//! The reader's side of the world.

use super::error::{OpenError, ReadError};
use super::receive::Newest;
use super::services;
use crate::process::join::Participant;
use crate::records::frame::Line;
use crate::records::name::FleetName;
use crate::records::world::{World, WorldHeader};

/// Reads a fleet's route graph and robot types.
///
/// ```
/// use regatta_plugin::world::{RobotTypeRecord, WorldData};
/// use regatta_plugin::{ProducerPorts, Result, WorldReader};
///
/// # fn main() -> Result {
/// # let fleet = format!("doc-world-{}", std::process::id()).parse()?;
/// let mut producer = ProducerPorts::create(&fleet, 2)?;
/// let robot_types = vec![RobotTypeRecord::new("tug", 1.2, 0.8)];
/// producer.publish_world(&WorldData { robot_types, ..WorldData::default() })?;
/// let mut worlds = WorldReader::open(&fleet)?;
/// # producer.update();
/// let world = worlds.latest()?.expect("a world");
/// assert_eq!(world.robot_types()[0].name(), "tug");
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct WorldReader {
    worlds: Newest<Line, WorldHeader>,
}

impl WorldReader {
    /// Opens the world of a fleet.
    ///
    /// # Errors
    /// As [`Subscriber::open`](crate::Subscriber::open).
    pub fn open(fleet: &FleetName) -> Result<Self, OpenError> {
        Self::open_on(&Participant::join(fleet, "reader")?)
    }

    /// Opens the world for a process that has joined the fleet.
    ///
    /// # Errors
    /// As [`Subscriber::open`](crate::Subscriber::open).
    pub fn open_on(participant: &Participant) -> Result<Self, OpenError> {
        Ok(Self { worlds: Newest::open(&services::WORLD, participant)? })
    }

    /// Returns the newest world, if there is one that this hasn't returned yet.
    ///
    /// # Errors
    /// [`ReadError`] if the connection to the producer is broken, or the world contradicts its
    /// header.
    pub fn latest(&mut self) -> Result<Option<World<'_>>, ReadError> {
        if self.worlds.take_newest()? { self.current() } else { Ok(None) }
    }

    /// The world that [`latest`](Self::latest) returned last.
    ///
    /// # Errors
    /// [`ReadError::Malformed`] if the world contradicts its header.
    pub fn current(&self) -> Result<Option<World<'_>>, ReadError> {
        let Some((header, lines)) = self.worlds.held() else { return Ok(None) };
        match World::split(header, lines) {
            Some(world) => Ok(Some(world)),
            None => Err(ReadError::Malformed { what: "the world", lines: lines.len() }),
        }
    }
}
