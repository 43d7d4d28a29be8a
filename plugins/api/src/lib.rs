//! The contract between the processes that write a fleet into shared memory and those that read it.
//!
//! A *producer* (the engine, a replay, a UDP source) publishes [`frame`]s, the [`world`] and
//! [`event`]s, and takes [`order`]s and [`control`] requests. A *reader* is a [`Plugin`] started
//! with [`run`], or any program that opens a [`Subscriber`] itself. A producer of your own is a
//! [`Producer`](producer::Producer) started with [`produce`].
//!
//! | module | |
//! |---|---|
//! | [`records`] | plain data that crosses processes |
//! | [`ports`] | who sends and who takes each record |
//! | [`process`] | joining a fleet, running a plugin, ending, the health of shared memory |
//! | [`producer`] | clock, figures and control for any producer |
//!
//! Imports lead from the records up, through ports and processes, to producers.

/// Writes a line to standard error, as `eprintln!` does, but continues if it can't be read any
/// more: a plugin whose terminal or log was closed still serves its fleet.
#[macro_export]
macro_rules! tell {
    ($($line:tt)*) => {{
        use ::std::io::Write as _;
        let _ = ::std::writeln!(::std::io::stderr(), $($line)*);
    }};
}

mod error;
pub mod ports;
pub mod process;
pub mod producer;
pub mod records;

/// The plugins' README has a whole plugin: it compiles.
#[cfg(doctest)]
#[doc = include_str!("../../README.md")]
struct Readme;

pub use error::{Error, Result};
pub use ports::closures::ClosureReader;
pub use ports::columns::{ColumnPublisher, ColumnReader, ColumnValues, column_names};
pub use ports::contacts::{
    ContactEventReader, ContactEvents, ContactPublisher, ContactReader, Contacts,
};
pub use ports::control::{Control, ControlError, TIMEOUT as CONTROL_TIMEOUT};
pub use ports::error::{OpenError, PublishError, ReadError};
pub use ports::events::{EventReader, Events};
pub use ports::frames::Subscriber;
pub use ports::history::{HistoryPublisher, HistoryReader};
pub use ports::lockstep::{LockstepError, Reporter};
pub use ports::manager::{ManagerClient, ManagerError, ManagerServer};
pub use ports::order_log::{OrderLog, OrderLogReader};
pub use ports::orders::{OrderError, Orders};
pub use ports::producer::{FrameLoan, ProducerPorts};
pub use ports::recording::{RecordingPublisher, RecordingReader, ReplayedRecording};
pub use ports::routes::{PendingRoute, RouteClient, RouteError, RouteServer};
pub use ports::services;
pub use ports::tasks::{TaskPublisher, TaskReader, Tasks};
pub use ports::traffic::{Traffic, TrafficPublisher, TrafficReader};
pub use ports::worlds::WorldReader;
pub use process::domain::{DomainError, RUNTIME_DIR_VARIABLE, config as iceoryx2_config};
pub use process::health;
pub use process::join::Participant;
pub use process::log::set_verbosity;
pub use process::plugin::Plugin;
pub use process::rate::{Rate, RateError};
pub use process::run::{AFTER_VARIABLE, LOAD_VARIABLE, NAME_VARIABLE, Options, run, run_from};
pub use process::scheduling::{Priority, SchedulingError, SchedulingOptions};
pub use process::termination::{PARENT_VARIABLE, Termination, reopen_on_hangup};
pub use process::usage::usage_line;
pub use producer::{produce, produce_from};
pub use records::frame::Frame;
pub use records::name::{ColumnName, FleetName, MAX_NAME_BYTES, NameError};
pub use records::world::World;
pub use records::{
    activity, closure, column, contact, control, event, frame, history, manager, order, order_log,
    recording, route, sequence, task, traffic, world,
};
