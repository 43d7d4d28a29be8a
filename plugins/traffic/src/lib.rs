//! Traffic: what happens on each edge, for viewers, exporters and studies.
//!
//! Each frame is counted once ([`tally`]), summed up over the last minute, the last ten minutes and the run ([`periods`]), and
//! published once a simulated second ([`mod@plugin`]). In lockstep the figures repeat bit by bit. What robots wait for ([`queues`])
//! is worked out at the end of a run, for studies.

pub mod parquet_file;
pub mod periods;
pub mod plugin;
mod queue_observer;
pub mod queues;
pub mod report;
pub mod tally;

pub use plugin::{Cli, plugin, run_from};
pub use queue_observer::queue_observer;
