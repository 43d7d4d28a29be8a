//! Marks robots that collide, now or soon.

mod body;
mod bounds;
mod crowd;
mod detector;
#[cfg(test)]
mod detector_tests;
mod footprint;
#[cfg(test)]
mod geometry_tests;
mod heading;
mod ledger;
mod log;
mod meeting;
#[cfg(test)]
mod oracle_tests;
mod pair;
mod path;
mod plugin;
mod prediction;
mod radix;
mod settings;
mod skips;
mod strips;
mod summary;
mod tally;

pub use detector::{Detector, Scene};
pub use log::{HEADER as LOG_HEADER, LogError};
pub use plugin::{COLUMN, Cli, run_from};
pub use settings::{HYSTERESIS, MAX_HORIZON, MAX_MARGIN, Settings, SettingsError};
pub use tally::{Score, Tally};
