//! The figures of a fleet: for Prometheus, as CSV, and live in a terminal.
//!
//! Frames, the column `collision`, contacts and the fleet's processes are folded into a
//! [`Snapshot`](snapshot::Snapshot). The exporter's page, a row of the CSV file and the screen of `regatta top` are
//! three views of it.

pub mod census;
pub mod collisions;
pub mod exporter;
pub mod fold;
pub mod histogram;
pub mod page;
pub mod processes;
mod request;
pub mod rhythm;
pub mod row;
pub mod server;
pub mod sheet;
pub mod snapshot;
#[cfg(test)]
mod testing;
pub mod top;

pub use exporter::run_from;
