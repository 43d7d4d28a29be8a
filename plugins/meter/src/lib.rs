//! Meter: the finished orders of a fleet over time, for studies.
//!
//! It reads only the contract: frames, and the order log of the fleet manager. So it measures any
//! manager in the same way. Orders and effort are kept by period of ten simulated seconds
//! ([`meter`]), so that the warm-up can be cut off. In lockstep the figures repeat bit by bit.

pub mod meter;
pub mod orders;
pub mod plugin;
pub mod time;

pub use meter::Figures;
#[cfg(feature = "shared-memory")]
pub use plugin::run_from;
pub use plugin::{Cli, Metering, plugin};
pub use regatta_plugin::activity::{Activity, Ground};
