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
mod meeting;
#[cfg(test)]
mod oracle_tests;
mod pair;
mod path;
mod prediction;
mod radix;
mod settings;
mod strips;
mod tally;

pub use detector::{Detector, Scene};
pub use settings::{HYSTERESIS, MAX_HORIZON, MAX_MARGIN, Settings, SettingsError};
pub use tally::{Score, Tally};
