//! The state of a vehicle.

use serde::{Deserialize, Serialize};

use super::Message;
use super::action::ActionState;
use super::header::{Header, Topic, Version};
use super::order::{NodePosition, Trajectory};

/// The state of a vehicle.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct State {
    /// The header.
    #[serde(flatten)]
    pub header: Header,
    /// The current order, or the last one; empty if there was none.
    pub order_id: String,
    /// The last update of it.
    pub order_update_id: u32,
    /// The zone set in use; 2.x.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub zone_set_id: Option<String>,
    /// The last node that was reached; empty if it isn't known.
    pub last_node_id: String,
    /// Its place in the order.
    pub last_node_sequence_id: u32,
    /// The nodes that are still to be reached.
    pub node_states: Vec<NodeState>,
    /// The edges that are still to be driven.
    pub edge_states: Vec<EdgeState>,
    /// The position.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mobile_robot_position: Option<Position>,
    /// The velocity.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub velocity: Option<Velocity>,
    /// The loads that it carries.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub loads: Option<Vec<Load>>,
    /// Whether it drives.
    pub driving: bool,
    /// Whether it is paused.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub paused: Option<bool>,
    /// Whether it comes to the end of its base.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub new_base_request: Option<bool>,
    /// Metres since the last node.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub distance_since_last_node: Option<f64>,
    /// The actions of the order, and in 2.x those that were to be carried out at once.
    pub action_states: Vec<ActionState>,
    /// The actions that were to be carried out at once; 3.0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub instant_action_states: Option<Vec<ActionState>>,
    /// Its battery.
    pub power_supply: PowerSupply,
    /// The party that controls it.
    pub operating_mode: OperatingMode,
    /// Its errors.
    pub errors: Vec<Error>,
    /// Other information.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub information: Option<Vec<Info>>,
    /// Its safety devices.
    pub safety_state: SafetyState,
}

/// A node that is still to be reached.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct NodeState {
    /// The node.
    pub node_id: String,
    /// Its place in the order.
    pub sequence_id: u32,
    /// A text for people.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub node_descriptor: Option<String>,
    /// Whether it belongs to the base.
    pub released: bool,
    /// Its position.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub node_position: Option<NodePosition>,
}

/// An edge that is still to be driven.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct EdgeState {
    /// The edge.
    pub edge_id: String,
    /// Its place in the order.
    pub sequence_id: u32,
    /// A text for people.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub edge_descriptor: Option<String>,
    /// Whether it belongs to the base.
    pub released: bool,
    /// Its path.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub trajectory: Option<Trajectory>,
}

/// The position of a vehicle.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Position {
    /// Metres.
    pub x: f64,
    /// Metres.
    pub y: f64,
    /// Radians in [-π, π].
    pub theta: f64,
    /// The map.
    pub map_id: String,
    /// Whether the position is known.
    pub localized: bool,
    /// The quality of the localization, in [0, 1].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub localization_score: Option<f64>,
    /// Metres by which it may be wrong.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub deviation_range: Option<f64>,
}

/// The velocity of a vehicle, in its own coordinates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Velocity {
    /// Metres per second forward.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub vx: Option<f64>,
    /// Metres per second to the left.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub vy: Option<f64>,
    /// Radians per second counter-clockwise.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub omega: Option<f64>,
}

/// A load of a vehicle.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Load {
    /// Tells the load from others.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub load_id: Option<String>,
    /// The kind of load.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub load_type: Option<String>,
    /// The place on the vehicle.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub load_position: Option<String>,
    /// Kilograms.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub weight: Option<f64>,
}

/// The battery of a vehicle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct PowerSupply {
    /// Per cent.
    pub state_of_charge: f64,
    /// Whether it is being charged.
    pub charging: bool,
}

/// The party that controls a vehicle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum OperatingMode {
    /// Nobody: it is starting; 3.0.
    Startup,
    /// The master.
    #[default]
    Automatic,
    /// The master, but a person sets the speed.
    #[serde(rename = "SEMIAUTOMATIC")]
    SemiAutomatic,
    /// A person, for a while: it keeps its order; 3.0.
    Intervened,
    /// A person.
    Manual,
    /// A technician.
    Service,
    /// A person who teaches it.
    TeachIn,
}

/// An error of a vehicle, or of a message that it was sent.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Error {
    /// The type, of those of the standard or another one.
    pub error_type: String,
    /// The fields that it is about.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub error_references: Vec<Reference>,
    /// A text for people.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error_description: Option<String>,
    /// The remedy, for people; from 2.1 on.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error_hint: Option<String>,
    /// Its severity.
    pub error_level: ErrorLevel,
}

impl Error {
    /// The value of the field with a name that it is about.
    pub fn reference(&self, key: &str) -> Option<&str> {
        let found = self.error_references.iter().find(|it| it.reference_key == key)?;
        Some(&found.reference_value)
    }
}

/// A field that an error or an information is about.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Reference {
    /// The name of a field.
    pub reference_key: String,
    /// Its value.
    pub reference_value: String,
}

impl Reference {
    /// Creates a reference.
    pub fn new(key: &str, value: impl ToString) -> Self {
        Self { reference_key: key.to_owned(), reference_value: value.to_string() }
    }
}

/// The severity of an error. 2.x knows the first and the last level.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum ErrorLevel {
    /// It needs no attention: the vehicle goes on, and takes orders.
    Warning,
    /// It needs attention: the vehicle goes on, and takes orders.
    Urgent,
    /// The vehicle can't go on with its order, but takes others.
    Critical,
    /// The vehicle needs a person.
    Fatal,
}

/// Other information.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Info {
    /// The type.
    pub info_type: String,
    /// The fields that it is about.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub info_references: Vec<Reference>,
    /// A text for people.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub info_descriptor: Option<String>,
    /// For whom it is.
    pub info_level: InfoLevel,
}

/// For whom an information is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum InfoLevel {
    /// For those who look for errors.
    Debug,
    /// For those who watch.
    Info,
}

/// The safety devices of a vehicle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct SafetyState {
    /// Its emergency stop.
    pub active_emergency_stop: EmergencyStop,
    /// Whether something is in its protective field.
    pub field_violation: bool,
}

/// An emergency stop, by how it ends.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum EmergencyStop {
    /// By itself; 2.x.
    #[serde(rename = "AUTOACK")]
    AutoAcknowledged,
    /// At the vehicle.
    Manual,
    /// From elsewhere.
    Remote,
    /// There is none.
    #[default]
    None,
}

impl Message for State {
    const TOPIC: Topic = Topic::State;

    fn adapt(&mut self, version: Version) {
        if version == Version::V3_0 {
            self.adapt_to_3();
        } else {
            self.adapt_to_2(version);
        }
    }
}

impl State {
    fn adapt_to_3(&mut self) {
        self.zone_set_id = None;
        self.instant_action_states.get_or_insert_default();
        if self.safety_state.active_emergency_stop == EmergencyStop::AutoAcknowledged {
            self.safety_state.active_emergency_stop = EmergencyStop::Manual;
        }
    }

    /// In 2.x all actions are in one list, and errors have two levels.
    fn adapt_to_2(&mut self, version: Version) {
        self.action_states.extend(self.instant_action_states.take().unwrap_or_default());
        for state in &mut self.action_states {
            state.action_status = state.action_status.adapted(version);
        }
        for error in &mut self.errors {
            error.error_level = error.error_level.adapted();
            if version == Version::V2_0 {
                error.error_hint = None;
            }
        }
        for edge in &mut self.edge_states {
            edge.trajectory.iter_mut().for_each(Trajectory::complete);
        }
        if version == Version::V2_0 {
            self.node_states.iter_mut().for_each(NodeState::adapt_to_2_0);
        }
        self.operating_mode = match self.operating_mode {
            OperatingMode::Startup | OperatingMode::Intervened => OperatingMode::Manual,
            mode => mode,
        };
    }
}

impl NodeState {
    /// The schema of 2.0 wants a heading in each position.
    fn adapt_to_2_0(&mut self) {
        self.node_position.take_if(|position| position.theta.is_none());
    }
}

impl ErrorLevel {
    /// The level of 2.x.
    const fn adapted(self) -> Self {
        match self {
            Self::Warning | Self::Urgent => Self::Warning,
            Self::Critical | Self::Fatal => Self::Fatal,
        }
    }
}
