//! Shows a fleet on another host, and steers it from there, over zenoh.
//!
//! ```text
//!  host of the engine                                     another host
//!  fleet F ──▶ send ══ frames, world, events, columns ══▶ receive ──▶ fleet G
//!          ◀──      ◀═ commands, control ════════════════         ◀──
//! ```
//!
//! `send` is a reader of the fleet: it costs the engine nothing, however slow the network is.
//! `receive` is a producer of the contract, so that all readers work with the copy. [`wire`] has
//! the messages between the two; it compiles without zenoh.

pub mod wire;

#[cfg(feature = "zenoh")]
mod figures;
#[cfg(feature = "zenoh")]
mod grievances;
#[cfg(feature = "zenoh")]
mod link;
#[cfg(feature = "zenoh")]
mod options;
#[cfg(feature = "zenoh")]
mod receive;
#[cfg(feature = "zenoh")]
mod send;

#[cfg(feature = "zenoh")]
pub use link::LinkError;
#[cfg(feature = "zenoh")]
pub use options::{LinkArgs, MirrorCommand, ReceiveArgs, SendArgs};

/// Runs a subcommand until Ctrl-C.
///
/// # Errors
/// If the network's configuration is invalid, an address can't be listened on, the fleet to write
/// has a producer already, or shared memory fails.
#[cfg(feature = "zenoh")]
pub fn run(command: &MirrorCommand) -> regatta_plugin::Result {
    match command {
        MirrorCommand::Send(args) => send::run(args),
        MirrorCommand::Receive(args) => receive::run(args),
    }
}
