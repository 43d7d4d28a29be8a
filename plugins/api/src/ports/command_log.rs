//! The reader's side of the command log, for recorders. (Commands themselves go to the producer
//! alone: a second reader that stops would fill the senders' buffers.)

use super::error::OpenError;
use super::receive::{TickReader, TickRecords};
use super::services;
use crate::process::join::Participant;
use crate::records::command::CommandRecord;
use crate::records::command_log::CommandLogHeader;

/// The commands of one tick, refused ones too, in the order in which they were applied.
pub type CommandLog<'sample> = TickRecords<'sample, CommandLogHeader, CommandRecord>;

/// Reads the commands that a fleet's producer applied, as an [`EventReader`](crate::EventReader)
/// reads events.
pub type CommandLogReader = TickReader<CommandLogHeader, CommandRecord>;

impl CommandLogReader {
    /// Opens the command log of a fleet, whether or not it has a producer yet.
    ///
    /// # Errors
    /// As [`Subscriber::open`](crate::Subscriber::open).
    pub fn open_on(participant: &Participant) -> Result<Self, OpenError> {
        Self::of(&services::COMMAND_LOG, participant)
    }
}
