//! Planners: which way robots go, and who goes first.

mod congestion;
mod driving_times;
mod route;

pub use self::congestion::{Congestion, CongestionSettings};
pub use self::driving_times::DrivingTimes;
pub use self::route::{Router, Search};
