//! The messages of VDA 5050: one model for all versions, and their encodings as JSON.
//!
//! The structs have the fields of all versions, under the names of 3.0. [`encode`] writes a message
//! as a version spells it; [`decode`] reads a message of any version. `names.rs` has the names that
//! differ. Nothing here knows vehicles, masters or brokers.
//!
//! ```
//! use regatta_vda5050::message::{Connection, ConnectionState, Header, Version, decode, encode};
//!
//! let message = Connection {
//!     header: Header::default(),
//!     connection_state: ConnectionState::ConnectionBroken,
//! };
//! let json = encode(&message, Version::V2_0);
//! assert!(json.ends_with(br#""connectionState":"CONNECTIONBROKEN"}"#));
//! assert_eq!(decode::<Connection>(&json).expect("a message"), message);
//! ```

mod action;
mod decode;
mod encode;
mod factsheet;
mod header;
mod names;
mod order;
mod state;
mod status;
#[cfg(test)]
mod tests;

pub use action::{
    Action, ActionParameter, ActionState, ActionStatus, BlockingType, InstantActions,
    OldInstantActions,
};
pub use decode::{DecodeError, decode};
pub use encode::encode;
pub use factsheet::{
    ActionScope, Factsheet, Geometry, LoadSpecification, PhysicalParameters, ProtocolFeatures,
    ProtocolLimits, SupportedAction, Timing, TypeSpecification,
};
pub use header::{Header, Topic, Version, timestamp};
pub use order::{
    AllowedDeviation, ControlPoint, Corridor, CorridorReference, Edge, Ellipse, LossBehavior, Node,
    NodePosition, Order, OrientationType, Trajectory,
};
pub use state::{
    EdgeState, EmergencyStop, Error, ErrorLevel, Info, InfoLevel, Load, NodeState, OperatingMode,
    Position, PowerSupply, Reference, SafetyState, State, Velocity,
};
pub use status::{Connection, ConnectionState, Visualization};

/// A message of a topic.
pub trait Message: serde::Serialize + serde::de::DeserializeOwned {
    /// The topic on which it is sent.
    const TOPIC: Topic;

    /// Expresses the message as a version can: fields that only other versions have are carried
    /// over to those that it has.
    fn adapt(&mut self, version: Version) {
        let _ = version;
    }
}
