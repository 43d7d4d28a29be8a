//! The contract between everything that writes a fleet into shared memory and everything that reads it.
//!
//! A *producer* (the engine, a replay, a UDP source) publishes [`frame`]s, the [`world`] and
//! [`event`]s, and takes [`order`]s and [`control`] requests. An engine tells [`route`]s, too. A *reader* is a [`Plugin`] started with
//! [`run`], or any program that opens a [`Subscriber`] itself.

/// Writes a line to standard error, as `eprintln!` does, but goes on if nobody can read it any more: a plugin whose
/// terminal or log was closed is still of use to its fleet.
#[macro_export]
macro_rules! tell {
    ($($line:tt)*) => {{
        use ::std::io::Write as _;
        let _ = ::std::writeln!(::std::io::stderr(), $($line)*);
    }};
}

mod ask;
pub mod column;
pub mod contact;
mod contact_ports;
pub mod control;
mod control_client;
mod error;
pub mod event;
mod event_reader;
mod fleet_name;
pub mod frame;
mod frame_loan;
mod frame_view;
pub mod health;
pub mod inbox;
pub mod lockstep;
pub mod order;
pub mod order_log;
mod order_sender;
mod participant;
mod plugin;
pub mod publish;
pub mod qos;
pub mod route;
mod route_ports;
mod run;
pub mod subscribe;
mod termination;
mod wake;
pub mod world;

/// The plugins' README holds a whole plugin: it compiles.
#[cfg(doctest)]
#[doc = include_str!("../../README.md")]
struct Readme;

pub use column::{ColumnPublisher, ColumnReader, ColumnValues, column_names};
pub use contact::{ContactEventReader, ContactPublisher, ContactReader};
pub use control_client::{Control, ControlError, TIMEOUT as CONTROL_TIMEOUT};
pub use error::{Error, OpenError, PublishError, ReadError, Result};
pub use event_reader::{EventReader, Events};
pub use fleet_name::{ColumnName, FleetName, MAX_NAME_BYTES, NameError};
pub use frame::Frame;
pub use order_log::OrderLogReader;
pub use order_sender::{OrderError, Orders};
pub use participant::{Participant, set_verbosity};
pub use plugin::{Plugin, Rate, RateError};
pub use route_ports::{RouteClient, RouteError, RouteServer};
pub use run::{NAME_VARIABLE, Options, run, run_from};
pub use subscribe::{Subscriber, WorldReader};
pub use termination::{PARENT_VARIABLE, Termination};
pub use world::World;
