//! The header of each message, the versions of the standard and its topics.

use core::fmt;
use core::str::FromStr;
use std::time::SystemTime;

use serde::{Deserialize, Serialize};

/// A version of the standard.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Version {
    /// 2.0.0, of 2022.
    #[default]
    V2_0,
    /// 2.1.0, of 2025.
    V2_1,
    /// 3.0.0, of 2026.
    V3_0,
}

impl Version {
    /// All versions, oldest first.
    pub const ALL: [Self; 3] = [Self::V2_0, Self::V2_1, Self::V3_0];

    /// The number, as headers have it.
    pub const fn number(self) -> &'static str {
        match self {
            Self::V2_0 => "2.0.0",
            Self::V2_1 => "2.1.0",
            Self::V3_0 => "3.0.0",
        }
    }

    /// The level of the version in topics.
    pub const fn level(self) -> &'static str {
        match self {
            Self::V2_0 | Self::V2_1 => "v2",
            Self::V3_0 => "v3",
        }
    }

    /// The first level of topics that the standard suggests.
    pub const fn interface(self) -> &'static str {
        match self {
            Self::V2_0 | Self::V2_1 => "uagv",
            Self::V3_0 => "vda5050",
        }
    }
}

impl fmt::Display for Version {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.number())
    }
}

impl FromStr for Version {
    type Err = String;

    /// Reads `2.0`, `2.0.0` and the like.
    fn from_str(text: &str) -> Result<Self, String> {
        let versions = Self::ALL.into_iter();
        let mut named =
            versions.filter(|version| [version.number(), &version.number()[..3]].contains(&text));
        named.next().ok_or_else(|| "give 2.0, 2.1 or 3.0".to_owned())
    }
}

/// A topic: the last level of the topics of a vehicle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Topic {
    /// Orders, from the master.
    Order,
    /// Actions to be carried out at once, from the master.
    InstantActions,
    /// The state of the vehicle.
    State,
    /// Its position, more often.
    Visualization,
    /// Its connection to the broker.
    Connection,
    /// Its properties.
    Factsheet,
}

impl Topic {
    /// All topics.
    pub const ALL: [Self; 6] = [
        Self::Order,
        Self::InstantActions,
        Self::State,
        Self::Visualization,
        Self::Connection,
        Self::Factsheet,
    ];

    /// The name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Order => "order",
            Self::InstantActions => "instantActions",
            Self::State => "state",
            Self::Visualization => "visualization",
            Self::Connection => "connection",
            Self::Factsheet => "factsheet",
        }
    }
}

/// The fields that each message begins with.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub struct Header {
    /// Counts the messages of a topic.
    pub header_id: u32,
    /// The time of the message, as [`timestamp`] writes it.
    pub timestamp: String,
    /// The version of the standard.
    pub version: String,
    /// The manufacturer of the vehicle.
    pub manufacturer: String,
    /// The serial number of the vehicle.
    pub serial_number: String,
}

/// Returns a time as messages have it: ISO 8601, UTC, with milliseconds.
pub fn timestamp(time: SystemTime) -> String {
    humantime::format_rfc3339_millis(time).to_string()
}
