//! A fleet manager: takes transport orders and steers the robots of any fleet through the contract
//! alone.
//!
//! | module | |
//! |---|---|
//! | [`mod@plugin`] | the plugin: frames in, commands and the order log out |
//! | [`roads`] | the legs of a world, the conflicts between them, places to stop |
//! | [`claims`] | the parts of the roads that are reserved for one robot each |
//! | [`traffic`] | the traffic as planners see it |
//! | [`planner`] | planners: routes and precedence of robots |
//! | [`density`] | a limit on the number of robots under way |
//! | [`steering`] | sends robots to nodes so that they never touch |
//! | [`facilities`] | requests of doors and lifts |
//! | [`charging`] | assigns robots to chargers |
//! | [`manager`] | gives orders to robots, and steers them |
//! | `regatta_orders` | transport orders: a crate of its own, in `orders/` |

pub mod charging;
pub mod claims;
mod columns;
pub mod density;
pub mod facilities;
pub mod manager;
#[cfg(test)]
mod model;
mod order_log;
pub mod planner;
pub mod plugin;
mod rehearsal;
pub mod roads;
mod run_figures;
pub mod steering;
pub mod traffic;
mod work;

pub use plugin::{Cli, PlannerKind, plugin};
#[cfg(feature = "shared-memory")]
pub use plugin::{run_from, run_with};
