//! A fleet among the nodes of ROS 2, over a DDS of its own: no installation of ROS is needed.
//!
//! ```text
//!   frames ──▶ poses, scene, diagnostics ──▶ topics ─┐
//!                                                    ├─▶ link (DDS) ◀──▶ ROS 2
//!   commands, control ◀── desk ◀── goals, services ──┘
//! ```
//!
//! `poses`, `scene` and `diagnostics` publish, on the thread of the plugin. The `desk` takes what
//! others want, on a thread of its own: there it may wait for the engine or the fleet manager.

mod desk;
mod diagnostics;
mod floor;
mod link;
mod map;
mod message;
mod navigation;
mod open_rmf;
mod options;
mod plugin;
mod poses;
mod scene;
mod simulation;
mod snapshot;
mod steering;

pub use options::Cli;
pub use plugin::run_from;
