//! Marks robots that collide, now or soon.
//!
//! For every frame, the [`Detector`] tells for each robot whether it is clear (0), a possible collision (1) or touching
//! another (2). The plugin publishes that as the column `collision`, the pairs as contacts, and what changes as contact
//! events (see [`regatta_plugin::contact`]).
//!
//! # What counts
//!
//! A robot covers its type's rectangle about its pose, or its circle. Two robots
//!
//! - *touch* if their footprints have a point in common;
//! - are a *possible* collision if their footprints are at most the margin apart, or will have a point in common at
//!   some time within the horizon, if both go on as they do.
//!
//! Distances are worked out in `f64` from the frame's `f32`; headings are exact to 2·10⁻⁷.
//!
//! **Going on** means along the edge at the published speed, backwards if it is negative, and beyond the edge's ends
//! along its tangent. A robot that is held stays put; so does one whose speed is 0 or not a number. More than
//! 50 m/s count as that. A robot without an edge, or with one that the world doesn't have, goes straight on along its
//! heading. The edge only says how a robot moves from where it is: a pose beside the edge stays beside it, and a heading
//! that isn't the edge's keeps its angle to it.
//!
//! An edge is driven as a row of chords, which it strays from by at most 2 cm and along each of which it turns by at
//! most 0.2 radians; on each, the heading stays that of the chord. Between the joints of either robot both move straight
//! and without turning, and whether rectangles or circles that do so meet has an exact answer (separating axes over
//! time). No instants are sampled: however small and fast two robots are, none is missed and none comes and goes with
//! the frames' times.
//!
//! **Hysteresis.** A pair comes to a level when the above holds, and leaves it when it no longer holds with 2 cm more:
//! footprints more than 2 cm apart, more than the margin and 2 cm apart, and on the way not even overlapping if both are
//! 1 cm larger on all sides. So no pair flickers at a boundary.
//!
//! **Events.** A pair that touches is possible, too. Each level that a pair comes to has one `began`, and one `ended`
//! when it leaves it: a contact out of nowhere is two events, `possible` and `touching`. A pair ends where it was last
//! seen. When a run begins anew (another run id, or a tick before the last one), everything does.
//!
//! # Who is left out
//!
//! Absent robots; poses that are no numbers, or beyond 10⁶ m or 1000 radians; types whose size is no number, negative or
//! beyond 1000 m. They are clear, and their number is told. Without the column `type`, robots are of the first type;
//! without robot types, 0.9 m × 0.6 m.
//!
//! # What it costs, and when it stops
//!
//! Time grows with the robots and with the pairs that are near (see `strips.rs` and `sweep.rs`). In a pile of everybody
//! those are all pairs, so there are limits: 64 checks, 512 looks and 8 pairs for each robot on average, besides some
//! hundred thousand for any fleet. When one is reached, the frame is done again with the pairs known from before, and 8
//! neighbours of each robot. That is told as `capped`: all pairs in the list are real, but there may be more.

mod body;
mod bounds;
mod checks;
mod chunk;
mod crowd;
mod detector;
#[cfg(test)]
mod detector_tests;
mod footprint;
#[cfg(test)]
mod geometry_tests;
mod grid;
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
mod roads;
mod settings;
mod skips;
mod strips;
mod summary;
mod sweep;
mod tally;
mod way;

pub use detector::{Detector, Scene};
pub use log::{HEADER as LOG_HEADER, LogError};
pub use plugin::{COLUMN, Cli, run_from};
pub use settings::{HYSTERESIS, MAX_HORIZON, MAX_MARGIN, Settings, SettingsError};
pub use tally::{Score, Tally};
