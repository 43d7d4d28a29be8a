//! A fleet manager: takes transport orders and steers the robots of any fleet through the contract alone.
//!
//! | module | |
//! |---|---|
//! | [`tasks`] | transport orders: where they come from, which robot gets them |

pub mod tasks;
