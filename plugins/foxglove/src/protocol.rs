//! The WebSocket protocol of Foxglove: texts are JSON objects with an `op`, binary messages begin
//! with the byte of theirs.
//!
//! `foxglove.websocket.v1` and `foxglove.sdk.v1` are the same: the second is its name since
//! servers are made with Foxglove's SDK.

mod request;
pub(crate) mod response;
#[cfg(test)]
mod tests;

pub use request::{Parameter, Request, RequestError, ServiceCall, Subscription, parse};

/// The names of the protocol, the newest first.
pub(crate) const SUBPROTOCOLS: [&str; 2] = ["foxglove.sdk.v1", "foxglove.websocket.v1"];
/// The most bytes of a message from a client.
pub(crate) const MOST_BYTES: usize = 64 << 10;
