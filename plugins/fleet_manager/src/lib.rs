//! A fleet manager: takes transport orders and steers the robots of any fleet through the contract alone.
//!
//! | module | |
//! |---|---|
//! | [`plugin`] | the plugin: frames in, orders and the task log out |
//! | [`roads`] | the legs of a world, and which stretches get in each other's way |
//! | [`claims`] | which robot alone may be where |
//! | [`planner`] | which way robots go |
//! | [`steering`] | sends robots to nodes, without one ever touching another |
//! | [`manager`] | gives tasks to robots, and steers them |
//! | [`tasks`] | transport orders: where they come from, which robot gets them |

pub mod claims;
pub mod manager;
pub mod planner;
pub mod plugin;
pub mod roads;
pub mod steering;
mod task_log;
pub mod tasks;

pub use plugin::{Cli, run_from};
