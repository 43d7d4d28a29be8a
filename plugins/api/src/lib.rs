//! The contract between everything that writes a fleet into shared memory and everything that reads it.
//!
//! A *producer* (the engine, a replay, a UDP source) publishes [`frame`]s, the [`world`] and
//! [`event`]s, and takes [`order`]s and [`control`] requests. A *reader* is a [`Plugin`] started with
//! [`run`], or any program that opens a [`Subscriber`] itself.

pub mod column;
pub mod control;
mod error;
pub mod event;
mod fleet_name;
pub mod frame;
pub mod inbox;
pub mod lockstep;
pub mod order;
mod participant;
pub mod publish;
pub mod qos;
pub mod subscribe;
mod termination;
pub mod world;

pub use error::{Error, OpenError, PublishError, ReadError, Result};
pub use fleet_name::{ColumnName, FleetName, MAX_NAME_BYTES, NameError};
pub use frame::Frame;
pub use participant::{Participant, set_verbosity};
pub use subscribe::{Subscriber, WorldReader};
pub use termination::Termination;
pub use world::World;
