//! Checks of route graphs: validation, warnings, repairs, and the differences between two graphs.

mod body_heading;
mod coincident;
pub mod diff;
mod facilities;
pub(crate) mod fix;
pub(crate) mod lint;
pub(crate) mod units;
pub(crate) mod validate;
mod zones;
