//! Checks of route graphs: validation, warnings, repairs, and the differences between two graphs.

mod body_heading;
pub mod diff;
pub(crate) mod fix;
pub(crate) mod lint;
pub(crate) mod validate;
mod zones;
