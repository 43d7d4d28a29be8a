//! The small messages of a vehicle: its connection, and its position for those who watch.

use serde::{Deserialize, Serialize};

use super::Message;
use super::header::{Header, Topic, Version};
use super::state::{Position, Velocity};

/// The connection of a vehicle to the broker.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Connection {
    /// The header.
    #[serde(flatten)]
    pub header: Header,
    /// The state of the connection.
    pub connection_state: ConnectionState,
}

/// The state of a connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum ConnectionState {
    /// It is there.
    Online,
    /// The vehicle has ended it.
    Offline,
    /// The vehicle sleeps; 3.0.
    Hibernating,
    /// It was lost.
    ConnectionBroken,
}

impl Message for Connection {
    const TOPIC: Topic = Topic::Connection;

    fn adapt(&mut self, version: Version) {
        let sleeps = self.connection_state == ConnectionState::Hibernating;
        if sleeps && version != Version::V3_0 {
            self.connection_state = ConnectionState::Online;
        }
    }
}

/// The position of a vehicle, for those who watch.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Visualization {
    /// The header.
    #[serde(flatten)]
    pub header: Header,
    /// The number of the last state; 3.0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reference_state_header_id: Option<u32>,
    /// The position.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mobile_robot_position: Option<Position>,
    /// The velocity.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub velocity: Option<Velocity>,
}

impl Message for Visualization {
    const TOPIC: Topic = Topic::Visualization;

    fn adapt(&mut self, version: Version) {
        if version == Version::V3_0 {
            self.reference_state_header_id.get_or_insert_default();
        } else {
            self.reference_state_header_id = None;
        }
    }
}
