//! Traffic: what happens on each edge, for viewers, exporters and studies.
//!
//! Each frame is counted once ([`tally`]), summed up over the last minute, the last ten minutes and
//! the run ([`periods`]), and published once a simulated second ([`mod@plugin`]). In lockstep the
//! figures repeat bit by bit. Whose routes lead over an edge is asked for meanwhile ([`routes`]),
//! which can't repeat, so not in lockstep. The history of the run is kept for readers that join
//! later. What robots wait for ([`queues`]) is worked out at the end of a run, for studies.

mod history;
pub mod parquet_file;
pub mod periods;
pub mod plugin;
mod queue_observer;
pub mod queues;
pub mod report;
pub mod routes;
pub mod tally;

pub use plugin::{Cli, plugin, run_from};
pub use queue_observer::queue_observer;
