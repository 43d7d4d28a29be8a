//! Checks of route graphs: validation, warnings, repairs, and the differences between two graphs.

pub(crate) mod angles;
mod body_heading;
mod coincident;
mod copies;
pub mod diff;
mod facilities;
pub(crate) mod fix;
mod gaps;
pub(crate) mod lint;
pub(crate) mod units;
pub(crate) mod validate;
mod zones;
