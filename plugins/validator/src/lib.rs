//! An independent judge of a run: it reads frames, the world, events and the order log, and shares
//! no code with the fleet manager, the collision plugin or the engine.
//!
//! [`Judge`] is pure: it takes the messages of a fleet, and returns a [`Report`]. The plugin feeds
//! it live; `regatta validate` feeds it with a recording. The rules are in `contacts`, `graph`,
//! `motion`, `orders`, `progress` and `zones`; their tolerances are constants at the top of each,
//! which `docs/validator.md` lists. `world_model` computes curves and arc lengths of its own.
//!
//! A fault that lasts counts once, in the frame in which it begins.

mod contacts;
mod findings;
mod graph;
mod judge;
mod motion;
mod numbers;
mod options;
mod orders;
mod plugin;
mod progress;
mod report;
mod stands;
mod world_model;
mod zones;

pub use findings::{Finding, Kind};
pub use judge::{Judge, Settings};
pub use options::{JudgeError, JudgeOptions};
#[cfg(feature = "shared-memory")]
pub use plugin::run_from;
pub use plugin::{Cli, Validator, plugin};
pub use report::{KindReport, Report};
