//! The errors of ports: one closed enum per operation.

use core::time::Duration;

#[cfg(feature = "shared-memory")]
use crate::process::domain::DomainError;
use crate::records::frame::CONTRACT_VERSION;
use crate::records::name::{ColumnName, FleetName, NameError};

/// The reason of errors for want of shared memory.
pub(crate) const FULL: &str = "shared memory is full: make /dev/shm larger (`mount -o remount,size=…`, `docker run --shm-size=…`), or free some";

/// The error of opening a fleet's services.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum OpenError {
    /// A process with another contract version has the service open.
    #[error(
        "fleet '{fleet}' uses contract version {theirs}, this program uses version {CONTRACT_VERSION} \
         ({service}); build both from the same release, or use another fleet name"
    )]
    OtherVersion {
        /// The fleet.
        fleet: FleetName,
        /// The service.
        service: String,
        /// The version found, or `unknown`.
        theirs: String,
    },
    /// The name of a column is invalid.
    #[error(transparent)]
    Name(#[from] NameError),
    /// Another producer of the fleet is alive.
    #[error(
        "fleet '{fleet}' is already running: {owner} publishes it; stop that one, or choose \
         another name with --fleet"
    )]
    AlreadyRunning {
        /// The fleet.
        fleet: FleetName,
        /// Its producer: executable and process id.
        owner: String,
    },
    /// Another plugin publishes a column of that name.
    #[error(
        "column '{column}' of fleet '{fleet}' is already published by {owner}; stop that one, or \
         choose another name"
    )]
    ColumnTaken {
        /// The fleet.
        fleet: FleetName,
        /// The column.
        column: ColumnName,
        /// Its publisher: executable and process id.
        owner: String,
    },
    /// Another process publishes a service that has one publisher.
    #[error("{subject} of fleet '{fleet}': already published by {owner}; stop that one first")]
    Taken {
        /// The content of the service, such as `contacts`.
        subject: &'static str,
        /// The fleet.
        fleet: FleetName,
        /// The publisher: executable and process id.
        owner: String,
    },
    /// Another process owns the movement of the fleet.
    #[error(
        "{owner} moves the robots of fleet '{fleet}'; stop it first, or ask it to send a robot \
         with `regatta command send`"
    )]
    Owned {
        /// The fleet.
        fleet: FleetName,
        /// The owner: its name and process id.
        owner: String,
    },
    /// A service has no free place.
    #[error(
        "{service} has all of its {limit} places taken by {holders}; stop one of them, or run `regatta doctor --clean` if \
         some have died"
    )]
    Full {
        /// The service.
        service: String,
        /// The number of places.
        limit: usize,
        /// The processes at the service, by name and number: `3 × hello, viewer`.
        holders: String,
    },
    /// Another process has been opening or closing a service all the time.
    #[error(
        "{service} isn't ready after {seconds} s: another process is opening or closing it; stop \
         that process, and run `regatta doctor --clean`"
    )]
    InFlux {
        /// The service.
        service: String,
        /// The time for which it was waited for, in seconds.
        seconds: u64,
    },
    /// This user has no directory for the files of shared memory.
    #[cfg(feature = "shared-memory")]
    #[error(transparent)]
    Domain(#[from] DomainError),
    /// iceoryx2 failed.
    #[error(
        "can't open {what} in shared memory ({reason}); `regatta doctor` reports what is wrong"
    )]
    SharedMemory {
        /// The service or fleet that was to be opened.
        what: String,
        /// iceoryx2's reason.
        reason: String,
    },
}

/// The error of publishing a sample.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PublishError {
    /// `/dev/shm` is full. Nothing was published, and a later attempt may succeed.
    #[error("can't publish {what}: {FULL}; `regatta doctor` shows how much there is")]
    MemoryFull {
        /// The sample that was to be published.
        what: &'static str,
    },
    /// `/dev/shm` has too little room for samples of this size. Nothing was published, and a later
    /// attempt may succeed.
    #[error(
        "no shared memory for {what} ({:.1} MB are left and {:.1} MB are needed: make /dev/shm larger, by `mount -o \
         remount,size=…` or `docker run --shm-size=…`); `regatta doctor` shows how much there is",
        *available_bytes as f64 * 1e-6,
        *needed_bytes as f64 * 1e-6
    )]
    NoRoom {
        /// The sample that was to be published.
        what: &'static str,
        /// The room that is left.
        available_bytes: u64,
        /// The room that is needed.
        needed_bytes: u64,
    },
    /// Shared memory has no room for the sample.
    #[error("no shared memory for {what} ({reason}); `regatta doctor` shows how much there is")]
    Loan {
        /// The sample that was to be published.
        what: &'static str,
        /// iceoryx2's reason.
        reason: String,
    },
    /// The sample can't be delivered.
    #[error("can't publish {what} ({reason})")]
    Send {
        /// The sample that was to be published.
        what: &'static str,
        /// iceoryx2's reason.
        reason: String,
    },
    /// The column can't be opened.
    #[error(transparent)]
    Open(#[from] OpenError),
    /// The column's name is invalid.
    #[error(transparent)]
    Name(#[from] NameError),
    /// The values of the column are not one per robot.
    #[error(
        "a column of {values} values doesn't fit a frame of {robots} robots; it needs one value \
         per robot"
    )]
    ColumnLength {
        /// The number of values given.
        values: usize,
        /// The number of robots in the frame.
        robots: usize,
    },
}

/// The error of reading a sample.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ReadError {
    /// iceoryx2 can't deliver the sample.
    #[error("can't read {what} ({reason}); run `regatta doctor` to check its producer")]
    Receive {
        /// The sample that was to be read.
        what: &'static str,
        /// iceoryx2's reason.
        reason: String,
    },
    /// The producer sent something that contradicts its own header.
    #[error(
        "{what} is malformed: it has {lines} lines, fewer than its header requires; the fault is \
         its producer's"
    )]
    Malformed {
        /// The sample.
        what: &'static str,
        /// Its length in [`Line`](crate::frame::Line)s.
        lines: usize,
    },
}

/// The error of a request to a server of a fleet that got no answer.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RequestError {
    /// The server ended before it answered.
    #[error("{server} of fleet '{fleet}' ended before it answered")]
    Gone {
        /// The server, such as `the engine`.
        server: &'static str,
        /// The fleet.
        fleet: FleetName,
    },
    /// The server has not answered in time.
    #[error(
        "{server} of fleet '{fleet}' has not answered within {:.1} s; is it stopped or \
         overloaded?",
        timeout.as_secs_f32()
    )]
    Timeout {
        /// The server, such as `the engine`.
        server: &'static str,
        /// The fleet.
        fleet: FleetName,
        /// The time that the client waited.
        timeout: Duration,
    },
    /// iceoryx2 can't deliver the request or the answer.
    #[error(
        "can't reach {server} of fleet '{fleet}' ({reason}); `regatta doctor` reports what is wrong"
    )]
    Connection {
        /// The server, such as `the engine`.
        server: &'static str,
        /// The fleet.
        fleet: FleetName,
        /// iceoryx2's reason.
        reason: String,
    },
}

/// The error of waiting for readers in lockstep.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LockstepError {
    /// Not all readers have finished the tick in time.
    #[error(
        "tick {tick}: no report within {:.1} s from {}; are they running under these names, or \
         waiting for each other (--after)?",
        timeout.as_secs_f32(), missing.join(", ")
    )]
    Timeout {
        /// The tick.
        tick: u64,
        /// The time that the producer waited.
        timeout: Duration,
        /// The names of the readers that haven't reported the tick.
        missing: Vec<String>,
    },
    /// A signal has arrived. The caller checks whether it is to stop, or else waits again.
    #[error("waiting for tick {tick} was interrupted by a signal")]
    Interrupted {
        /// The tick.
        tick: u64,
    },
    /// Reports can't be read.
    #[error(transparent)]
    Read(#[from] ReadError),
}
