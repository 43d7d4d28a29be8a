//! Marks robots that collide, now or soon.

mod body;
mod bounds;
mod crowd;
mod detector;
mod footprint;
mod heading;
mod ledger;
mod meeting;
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
