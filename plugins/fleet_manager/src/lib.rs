//! A fleet manager: takes transport orders and steers the robots of any fleet through the contract alone.
//!
//! | module | |
//! |---|---|
//! | [`roads`] | the legs of a world, and which stretches get in each other's way |
//! | [`claims`] | which robot alone may be where |
//! | [`planner`] | which way robots go |
//! | [`steering`] | sends robots to nodes, without one ever touching another |
//! | [`tasks`] | transport orders: where they come from, which robot gets them |

pub mod claims;
pub mod planner;
pub mod roads;
pub mod steering;
pub mod tasks;
