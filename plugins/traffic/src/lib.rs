//! Traffic: the figures of each edge, for viewers, exporters and studies.
//!
//! Each frame is counted once ([`tally`]), summed up over the last minute, the last ten minutes and
//! the run ([`periods`]), and published once a simulated second, if a process reads the figures
//! ([`mod@plugin`]). In lockstep the figures repeat bit by bit. The routes over each edge
//! ([`routes`]) are requested meanwhile, except in lockstep, as that can't repeat. The history of
//! the run is kept for readers that join later. The causes of queues ([`queues`]) are computed at
//! the end of a run, for studies.

mod history;
pub mod parquet_file;
pub mod periods;
pub mod plugin;
pub mod queues;
pub mod report;
pub mod routes;
pub mod tally;

pub use plugin::{Cli, TrafficPlugin, plugin, run_from};
pub use queues::QueueObserver;
pub use report::Report;
