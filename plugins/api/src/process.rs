//! The life of a process in a fleet: joining, running a plugin, giving orders, writing rows to a
//! file, ending, the history of a run, and the health of shared memory.

pub mod csv_file;
pub mod dispatch;
pub(crate) mod domain;
pub mod health;
pub mod history;
pub mod join;
pub mod log;
mod management;
pub mod plugin;
pub mod rate;
pub mod run;
pub mod scheduling;
mod silence;
pub mod termination;
pub mod usage;
pub mod way;
