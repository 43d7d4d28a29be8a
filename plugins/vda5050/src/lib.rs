//! Robots of a fleet as vehicles of the interface VDA 5050, on an MQTT broker.
//!
//! ```text
//!   master ◀── broker ◀──▶ client ◀──▶ vehicle ──▶ commands ──▶ engine
//!                                            ◀── frames, events ──
//! ```
//!
//! [`message`] has the messages of all versions, for anyone who reads or writes them. [`vehicle`]
//! is a vehicle as the standard has it, without connections and clocks. [`map`] knows the layout by
//! the ids of orders. The plugin puts them together. [`judge`] and [`meter`] watch anyone's
//! traffic.
//! [`master`] steers others' vehicles.

pub mod broker;
mod client;
pub mod disturb;
mod factsheet;
pub mod judge;
pub mod map;
pub mod master;
pub mod message;
pub mod meter;
mod options;
mod plugin;
mod server;
pub mod vehicle;

pub use options::Cli;
pub use plugin::run_from;
