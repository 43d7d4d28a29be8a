//! Planners: which way robots go, and who goes first.

mod congestion;
mod route;

pub use self::congestion::Congestion;
pub use self::route::{Router, Search};
