//! A fleet manager: takes transport orders and steers the robots of any fleet through the contract alone.
//!
//! | module | |
//! |---|---|
