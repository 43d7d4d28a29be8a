//! A fleet live in Foxglove, Lichtblick and other clients of their WebSocket protocol.
//!
//! ```text
//!   frames, world, contacts ──▶ plugin ──▶ hub ──▶ outboxes ──▶ server ◀──▶ clients
//!   control ◀── desk ◀── wishes ◀──────────────────────────────────┘
//! ```
//!
//! The plugin encodes what some client subscribes to, once for all, on its own thread. The server
//! has a thread for all connections, and takes from each client's outbox what that client is ready
//! for. The desk takes the wishes of clients, on a thread where it may wait for the engine.

mod channel;
mod desk;
mod figures;
mod hub;
mod journal;
mod layout;
mod options;
mod outbox;
mod parameters;
mod plugin;
pub mod protocol;
mod server;
mod service;

pub use options::Cli;
pub use plugin::run_from;
