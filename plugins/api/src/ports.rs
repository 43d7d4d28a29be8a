//! Ports: the senders and the receivers of records.
//!
//! Four generic ports do the work, and the others only give them names and types: [`slices`] sends
//! slices of records, [`receive`] takes the newest sample or all of them in order, and [`ask`] has
//! both sides of request-response services. [`services`] has the name and the quality of each
//! service.
//!
//! Every port is opened on a [`Participant`](crate::Participant): the member of a fleet.

mod ask;
pub mod closures;
pub mod columns;
pub mod command_log;
pub mod commands;
pub mod contacts;
pub mod control;
pub mod error;
pub mod events;
pub mod facilities;
mod frame_loan;
pub mod frames;
pub mod history;
mod inbox;
#[cfg(feature = "shared-memory")]
pub mod lockstep;
pub mod manager;
pub mod orders;
pub mod ownership;
pub mod producer;
mod receive;
pub mod recording;
pub mod routes;
#[cfg_attr(
    not(feature = "shared-memory"),
    allow(dead_code, reason = "local fleets take no memory for readers that may come")
)]
pub mod services;
mod slices;
pub mod traffic;
pub mod work;
pub mod worlds;
