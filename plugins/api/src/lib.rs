//! The contract between everything that writes a fleet into shared memory and everything that reads it.
//!
//! A *producer* (the engine, a replay, a UDP source) publishes [`frame`]s, the [`world`] and
//! [`event`]s, and takes [`order`]s and [`control`] requests. A *reader* is a [`Plugin`] started with
//! [`run`], or any program that opens a [`Subscriber`](subscribe::Subscriber) itself.

pub mod column;
pub mod control;
pub mod event;
pub mod frame;
pub mod order;
pub mod world;
