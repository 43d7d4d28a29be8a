//! The factsheet: the properties of a vehicle. The fields that are objects without content here are
//! required by the schemas.

use serde::{Deserialize, Serialize};

use super::Message;
use super::action::BlockingType;
use super::header::{Header, Topic, Version};

/// The properties of a vehicle.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Factsheet {
    /// The header.
    #[serde(flatten)]
    pub header: Header,
    /// The kind of vehicle.
    pub type_specification: TypeSpecification,
    /// Its size and its limits.
    pub physical_parameters: PhysicalParameters,
    /// The limits of messages.
    pub protocol_limits: ProtocolLimits,
    /// Its features.
    pub protocol_features: ProtocolFeatures,
    /// Its shape.
    pub mobile_robot_geometry: Geometry,
    /// Its loads.
    pub load_specification: LoadSpecification,
}

/// The kind of a vehicle.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct TypeSpecification {
    /// The name of the series.
    pub series_name: String,
    /// A text about it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub series_description: Option<String>,
    /// `DIFF`, `OMNI`, `THREEWHEEL`, or in 3.0 others.
    pub mobile_robot_kinematics: String,
    /// `FORKLIFT`, `CONVEYOR`, `TUGGER`, `CARRIER`, or in 3.0 others.
    pub mobile_robot_class: String,
    /// Kilograms.
    pub maximum_load_mass: f64,
    /// `NATURAL`, `REFLECTOR`, `RFID`, `DMC`, `SPOT`, `GRID`, or in 3.0 others.
    pub localization_types: Vec<String>,
    /// `PHYSICAL_LINE_GUIDED`, `VIRTUAL_LINE_GUIDED`, `AUTONOMOUS`, or in 3.0 others.
    pub navigation_types: Vec<String>,
}

/// The size and the limits of a vehicle: metres, seconds, radians.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
#[expect(missing_docs, reason = "the names say it")]
pub struct PhysicalParameters {
    pub minimum_speed: f64,
    pub maximum_speed: f64,
    /// 3.0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub maximum_angular_speed: Option<f64>,
    pub maximum_acceleration: f64,
    pub maximum_deceleration: f64,
    pub minimum_height: f64,
    pub maximum_height: f64,
    pub width: f64,
    pub length: f64,
}

/// The limits of messages.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct ProtocolLimits {
    /// Limits of texts; without one here.
    pub maximum_string_lengths: Empty,
    /// Limits of lists; without one here.
    pub maximum_array_lengths: Empty,
    /// Limits of times.
    pub timing: Timing,
}

/// An object without fields that are known here.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Empty {}

/// Limits of times, in seconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Timing {
    /// The least time between two orders.
    pub minimum_order_interval: f64,
    /// The least time between two states.
    pub minimum_state_interval: f64,
    /// The time between two states without an event.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub default_state_interval: Option<f64>,
    /// The time between two positions.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub visualization_interval: Option<f64>,
}

/// The features of a vehicle.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct ProtocolFeatures {
    /// Optional fields that it knows; none are listed here.
    pub optional_parameters: Vec<Empty>,
    /// Its actions.
    pub mobile_robot_actions: Vec<SupportedAction>,
}

/// An action that a vehicle can carry out.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct SupportedAction {
    /// The kind of action.
    pub action_type: String,
    /// The parts of messages in which it may stand.
    pub action_scopes: Vec<ActionScope>,
    /// The blocking types that it may have; in 3.0, the schema of 2.1 has another form.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub blocking_types: Option<Vec<BlockingType>>,
    /// Whether it can be paused; 3.0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pause_allowed: Option<bool>,
    /// Whether it can be cancelled; 3.0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cancel_allowed: Option<bool>,
}

/// A part of a message in which an action may stand.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum ActionScope {
    /// Among those to be carried out at once.
    Instant,
    /// At a node.
    Node,
    /// At an edge.
    Edge,
    /// At a zone; 3.0.
    Zone,
}

/// The shape of a vehicle.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Geometry {}

/// The loads of a vehicle.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct LoadSpecification {
    /// The places for loads.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub load_positions: Vec<String>,
}

impl Message for Factsheet {
    const TOPIC: Topic = Topic::Factsheet;

    fn adapt(&mut self, version: Version) {
        for action in &mut self.protocol_features.mobile_robot_actions {
            if version != Version::V3_0 {
                (action.pause_allowed, action.cancel_allowed) = (None, None);
                action.blocking_types = None;
                action.action_scopes.retain(|scope| *scope != ActionScope::Zone);
            }
        }
        if version != Version::V3_0 {
            self.physical_parameters.maximum_angular_speed = None;
        }
    }
}
