//! The life of a process in a fleet: joining, running a plugin, ending, and the health of shared
//! memory.

#[cfg(feature = "shared-memory")]
pub(crate) mod domain;
pub mod finishing;
pub mod hangup;
#[cfg(feature = "shared-memory")]
pub mod health;
pub mod join;
#[cfg(feature = "shared-memory")]
pub mod log;
#[cfg(feature = "shared-memory")]
mod management;
#[cfg(all(feature = "shared-memory", unix))]
mod neighbours;
#[cfg(feature = "shared-memory")]
pub(crate) mod open_files;
pub mod options;
pub mod plugin;
pub mod rate;
#[cfg(feature = "shared-memory")]
pub mod run;
pub mod runner;
#[cfg(feature = "shared-memory")]
pub mod scheduling;
#[cfg(feature = "shared-memory")]
mod silence;
#[cfg(feature = "shared-memory")]
pub mod termination;
pub mod usage;
