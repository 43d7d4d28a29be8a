//! Plain data that crosses processes: what a fleet's services carry, byte for byte.
//!
//! A record has a fixed layout (`#[repr(C)]`, no padding, every bit pattern is a value), no
//! pointers and no ids that mean something on one host only. A change here is a change of the
//! contract: raise [`frame::CONTRACT_VERSION`] and write `plugins/python/regatta/layout.json` again
//! (see `tests/layout.rs`).

pub mod activity;
pub mod closure;
pub mod column;
pub mod contact;
pub mod control;
pub mod event;
pub mod frame;
pub mod history;
pub mod lockstep;
pub mod manager;
pub mod name;
pub mod order;
pub mod order_log;
pub mod recording;
pub mod route;
pub mod sequence;
pub mod task;
mod text;
pub mod traffic;
pub mod world;

pub(crate) use text::{cut, padded, text};
