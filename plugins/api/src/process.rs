//! The life of a process in a fleet: joining, running a plugin, ending, and the health of shared memory.

pub mod health;
pub mod join;
pub mod plugin;
pub mod rate;
pub mod run;
mod silence;
pub mod termination;
pub mod usage;
