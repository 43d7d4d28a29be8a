//! An independent judge of a run: it reads frames, the world, events and the task log, and shares
//! no code with the fleet manager, the collision plugin or the engine.
//!
//! [`Judge`] is pure: it gets what a fleet publishes, and returns a [`Report`]. The plugin feeds it
//! live; `regatta validate` feeds it with a recording. Each rule has a module: `contacts`, `graph`,
//! `motion` and `tasks`. `site` computes curves and arc lengths of its own from the world. The
//! tolerances are constants at the top of each, and `docs/validator.md` lists them.
//!
//! A fault that lasts counts once, in the frame in which it begins.

mod contacts;
mod findings;
mod graph;
mod judge;
mod motion;
mod options;
mod plugin;
mod report;
mod row;
mod site;
mod stands;
mod tasks;

pub use findings::{Finding, Kind};
pub use judge::{Judge, Settings};
pub use options::{JudgeError, JudgeOptions};
pub use plugin::{Cli, plugin, run_from};
pub use report::{KindReport, Report};
