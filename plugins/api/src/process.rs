//! The life of a process in a fleet: joining, running a plugin, ending, and the health of shared
//! memory.

pub(crate) mod domain;
pub mod health;
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
