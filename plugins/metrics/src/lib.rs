//! Metrics of a fleet: for Prometheus, as CSV, and live in a terminal.
//!
//! Frames, the column `collision`, contacts, the column `activity`, the order log, the traffic on
//! edges and the fleet's processes are aggregated into a [`Snapshot`](snapshot::Snapshot). The
//! exporter's page, a row of the CSV file and the screen of `regatta top` are three views of it.

pub mod aggregator;
mod collisions;
mod durations;
pub mod exporter;
pub mod exposition;
mod fleet;
mod jams;
mod orders;
pub mod page;
pub mod processes;
mod rhythm;
mod row;
pub mod server;
pub mod snapshot;
mod state_counts;
#[cfg(test)]
mod testing;
pub mod top;
mod work;

pub use exporter::run_from;
