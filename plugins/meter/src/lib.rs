//! Meter: what a fleet carries over time, for studies.
//!
//! It reads nothing but the contract: the task log of whatever fleet manager writes one, and
//! frames. So it measures any manager in the same way. Orders and effort are kept by period of ten
//! simulated seconds ([`meter`]), so that whoever reads the figures can cut off the warm-up. In
//! lockstep they repeat bit by bit.

pub mod meter;
pub mod orders;
pub mod plugin;

pub use meter::Figures;
pub use plugin::{Cli, plugin, run_from};
