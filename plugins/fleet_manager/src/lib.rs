//! A fleet manager: takes transport orders and steers the robots of any fleet through the contract
//! alone.
//!
//! | module | |
//! |---|---|
//! | [`plugin`] | the plugin: frames in, commands and the order log out |
//! | [`roads`] | the legs of a world, and which stretches get in each other's way |
//! | [`claims`] | which robot alone may be where |
//! | [`traffic`] | what planners see: who is where, and how far a robot could drive |
//! | [`planner`] | which way robots go |
//! | [`density`] | how many robots may be under way |
//! | [`steering`] | sends robots to nodes, without one ever touching another |
//! | [`charging`] | who goes to which charger, and when |
//! | [`manager`] | gives orders to robots, and steers them |
//! | `regatta_orders` | transport orders: a crate of its own, in `orders/` |

pub mod charging;
pub mod claims;
mod columns;
pub mod density;
pub mod manager;
#[cfg(test)]
mod model;
mod order_log;
pub mod planner;
pub mod plugin;
pub mod roads;
mod run_figures;
pub mod steering;
pub mod traffic;

pub use plugin::{Cli, PlannerKind, run_from, run_with};
