//! The history of a run so far, in bounded memory: kept by the plugin or the replay that publishes it, and by a reader
//! that has nobody to ask.

pub mod series;
pub mod spots;
