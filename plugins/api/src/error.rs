//! Errors: one closed enum per operation, and [`Error`], the one that plugins return.

use core::fmt;

use crate::fleet_name::{ColumnName, FleetName, NameError};
use crate::frame::CONTRACT_VERSION;

/// What a plugin's functions return: `Result` alone is `Result<(), Error>`.
pub type Result<T = (), E = Error> = core::result::Result<T, E>;

/// Any error, as one line: the message, then each cause after a colon.
///
/// Every error type turns into it with `?`. `fn main() -> regatta_plugin::Result` prints it as
/// `Error: …`, without quotes or a backtrace, and exits with code 1.
pub struct Error(Box<dyn core::error::Error + Send + Sync>);

impl Error {
    /// An error that says `message`: what went wrong, where, and what to do about it.
    pub fn new(message: impl fmt::Display) -> Self {
        Self(message.to_string().into())
    }

    /// The error behind this one, to look at or to downcast.
    pub fn get_ref(&self) -> &(dyn core::error::Error + Send + Sync + 'static) {
        &*self.0
    }
}

impl<E: core::error::Error + Send + Sync + 'static> From<E> for Error {
    fn from(error: E) -> Self {
        Self(error.into())
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.0)?;
        let mut cause = self.0.source();
        while let Some(error) = cause {
            write!(f, ": {error}")?;
            cause = error.source();
        }
        Ok(())
    }
}

/// The same as `Display`: this is what `main` prints.
impl fmt::Debug for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

/// Why a fleet's services can't be opened.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum OpenError {
    /// A process of another contract version holds the service.
    #[error(
        "fleet '{fleet}' speaks contract version {theirs}, this program speaks version {CONTRACT_VERSION} \
         ({service}); build both from the same release, or use another fleet name"
    )]
    OtherVersion {
        /// The fleet.
        fleet: FleetName,
        /// The service that was looked at.
        service: String,
        /// The version found, or what stands in its place.
        theirs: String,
    },
    /// Another producer of the fleet is alive.
    #[error(
        "fleet '{fleet}' is already running: {owner} publishes it; stop that one, or choose another name with --fleet"
    )]
    AlreadyRunning {
        /// The fleet.
        fleet: FleetName,
        /// Its producer: executable and process id.
        owner: String,
    },
    /// Another plugin publishes a column of that name.
    #[error(
        "column '{column}' of fleet '{fleet}' is already published by {owner}; stop that one, or choose another name"
    )]
    ColumnTaken {
        /// The fleet.
        fleet: FleetName,
        /// The column.
        column: ColumnName,
        /// Its publisher: executable and process id.
        owner: String,
    },
    /// Another plugin publishes the fleet's contacts.
    #[error("contacts of fleet '{fleet}' are already published by {owner}; stop that one first")]
    ContactsTaken {
        /// The fleet.
        fleet: FleetName,
        /// Their publisher: executable and process id.
        owner: String,
    },
    /// All places at a service are taken.
    #[error(
        "{service} has all of its {limit} places taken; stop a reader, or run `regatta doctor --clean` if some have died"
    )]
    Full {
        /// The service.
        service: String,
        /// How many there may be.
        limit: usize,
    },
    /// iceoryx2 can't do it.
    #[error("can't open {what} in shared memory ({reason}); `regatta doctor` says what is wrong with it")]
    SharedMemory {
        /// What was to be opened.
        what: String,
        /// iceoryx2's reason.
        reason: String,
    },
}

/// Why something can't be published.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PublishError {
    /// There is no chunk for it.
    #[error("no shared memory for {what} ({reason}); `regatta doctor` shows how much there is")]
    Loan {
        /// What was to be published.
        what: &'static str,
        /// iceoryx2's reason.
        reason: String,
    },
    /// It can't be delivered.
    #[error("can't publish {what} ({reason})")]
    Send {
        /// What was to be published.
        what: &'static str,
        /// iceoryx2's reason.
        reason: String,
    },
    /// The column can't be opened.
    #[error(transparent)]
    Open(#[from] OpenError),
    /// The column's name is none.
    #[error(transparent)]
    Name(#[from] NameError),
    /// Its values are not one per robot.
    #[error("a column of {values} values doesn't fit a frame of {robots} robots; it needs one value per robot")]
    ColumnLength {
        /// Values given.
        values: usize,
        /// Robots in the frame.
        robots: usize,
    },
}

/// Why something can't be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ReadError {
    /// iceoryx2 can't deliver it.
    #[error("can't read {what} ({reason}); is its producer still alive? `regatta doctor` says")]
    Receive {
        /// What was to be read.
        what: &'static str,
        /// iceoryx2's reason.
        reason: String,
    },
    /// The producer sent something that contradicts its own header.
    #[error("{what} of {lines} lines is too short for what its header says; its producer is at fault")]
    Malformed {
        /// What was read.
        what: &'static str,
        /// Its length in [`Line`](crate::frame::Line)s.
        lines: usize,
    },
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, thiserror::Error)]
    #[error("outer")]
    struct Outer(#[source] std::io::Error);

    #[test]
    fn an_error_prints_as_one_line_with_its_causes() {
        let error = Error::from(Outer(std::io::Error::other("inner")));
        assert_eq!(format!("{error:?}"), "outer: inner");
        assert_eq!(format!("{:?}", Error::new("plain")), "plain");
    }
}
