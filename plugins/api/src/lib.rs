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
//!
//! Without the default feature `shared-memory` only the records are there, which any target of Rust
//! compiles, for example `wasm32-unknown-unknown`.

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
#[cfg(feature = "shared-memory")]
pub mod ports;
#[cfg(feature = "shared-memory")]
pub mod process;
#[cfg(feature = "shared-memory")]
pub mod producer;
#[cfg_attr(
    not(feature = "shared-memory"),
    allow(dead_code, unused_imports, reason = "the ports alone write some records")
)]
pub mod records;

/// The plugins' README has a whole plugin: it compiles.
#[cfg(all(doctest, feature = "shared-memory"))]
#[doc = include_str!("../../README.md")]
struct Readme;

pub use error::{Error, Result};
pub use records::contact::Contacts;
pub use records::frame::Frame;
pub use records::name::{ColumnName, FleetName, MAX_NAME_BYTES, NameError};
pub use records::traffic::Traffic;
pub use records::world::World;
pub use records::{
    activity, closure, column, contact, control, event, frame, history, manager, order, order_log,
    recording, route, sequence, task, traffic, world,
};
#[cfg(feature = "shared-memory")]
pub use shared_memory::*;

/// The part of the contract that needs shared memory.
#[cfg(feature = "shared-memory")]
mod shared_memory {
    pub use crate::ports::closures::ClosureReader;
    pub use crate::ports::columns::{ColumnPublisher, ColumnReader, ColumnValues, column_names};
    pub use crate::ports::contacts::{
        ContactEventReader, ContactEvents, ContactPublisher, ContactReader,
    };
    pub use crate::ports::control::{Control, ControlError, TIMEOUT as CONTROL_TIMEOUT};
    pub use crate::ports::error::{OpenError, PublishError, ReadError};
    pub use crate::ports::events::{EventReader, Events};
    pub use crate::ports::frames::Subscriber;
    pub use crate::ports::history::{HistoryPublisher, HistoryReader};
    pub use crate::ports::lockstep::{LockstepError, Reporter};
    pub use crate::ports::manager::{ManagerClient, ManagerError, ManagerServer};
    pub use crate::ports::order_log::{OrderLog, OrderLogReader};
    pub use crate::ports::orders::{OrderError, Orders};
    pub use crate::ports::producer::{FrameLoan, ProducerPorts};
    pub use crate::ports::recording::{RecordingPublisher, RecordingReader, ReplayedRecording};
    pub use crate::ports::routes::{PendingRoute, RouteClient, RouteError, RouteServer};
    pub use crate::ports::services;
    pub use crate::ports::tasks::{TaskPublisher, TaskReader, Tasks};
    pub use crate::ports::traffic::{TrafficPublisher, TrafficReader};
    pub use crate::ports::worlds::WorldReader;
    pub use crate::process::csv_file::{CsvChange, CsvError, CsvFile, RowCounts};
    pub use crate::process::dispatch::{DispatchError, Dispatcher};
    pub use crate::process::domain::{
        DomainError, RUNTIME_DIR_VARIABLE, config as iceoryx2_config,
    };
    pub use crate::process::health;
    pub use crate::process::history::{RunHistory, series::Series, spots::Spots};
    pub use crate::process::join::Participant;
    pub use crate::process::log::set_verbosity;
    pub use crate::process::plugin::Plugin;
    pub use crate::process::rate::{Rate, RateError};
    pub use crate::process::run::{
        AFTER_VARIABLE, LOAD_VARIABLE, NAME_VARIABLE, Options, run, run_from,
    };
    pub use crate::process::scheduling::{Priority, SchedulingError, SchedulingOptions};
    pub use crate::process::termination::{PARENT_VARIABLE, Termination};
    pub use crate::process::usage::usage_line;
    pub use crate::process::way::{WayError, find_node};
    pub use crate::producer::{produce, produce_from};
}
