//! Actions: what a vehicle does besides driving.

use serde::{Deserialize, Serialize};

use super::Message;
use super::header::{Header, Topic, Version};

/// An action of a node, of an edge, or one that is to be carried out at once.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Action {
    /// The kind of action. The schema of 2.0 calls it `actionName` in instant actions.
    #[serde(alias = "actionName")]
    pub action_type: String,
    /// Tells this action from all others.
    pub action_id: String,
    /// A text for people.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub action_descriptor: Option<String>,
    /// The actions, and the driving, that may go on beside it.
    #[serde(default)]
    pub blocking_type: BlockingType,
    /// The parameters.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub action_parameters: Vec<ActionParameter>,
    /// Whether the action may be tried again when it has failed; 3.0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub retriable: Option<bool>,
}

impl Action {
    /// The value of a parameter.
    pub fn parameter(&self, key: &str) -> Option<&serde_json::Value> {
        let found = self.action_parameters.iter().find(|parameter| parameter.key == key);
        found.map(|parameter| &parameter.value)
    }

    /// The value of a parameter that is a text.
    pub fn text(&self, key: &str) -> Option<&str> {
        self.parameter(key).and_then(serde_json::Value::as_str)
    }

    /// The value of a parameter that is a number.
    pub fn number(&self, key: &str) -> Option<f64> {
        self.parameter(key).and_then(serde_json::Value::as_f64)
    }
}

/// A parameter of an action.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ActionParameter {
    /// The name.
    pub key: String,
    /// The value, of any type.
    pub value: serde_json::Value,
}

/// The activities that may go on beside an action.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum BlockingType {
    /// Driving and other actions.
    #[default]
    None,
    /// Other actions, but not driving.
    Soft,
    /// Driving, but no other action; 3.0.
    Single,
    /// Nothing.
    Hard,
}

impl BlockingType {
    /// Whether the vehicle may not drive while such an action is to be carried out.
    pub const fn stops_driving(self) -> bool {
        matches!(self, Self::Soft | Self::Hard)
    }

    /// Whether no other action may run beside it.
    pub const fn is_alone(self) -> bool {
        matches!(self, Self::Single | Self::Hard)
    }
}

/// The message with actions to be carried out at once.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct InstantActions {
    /// The header.
    #[serde(flatten)]
    pub header: Header,
    /// The actions. 1.1 calls them `instantActions`, and so do some masters of 2.0.
    #[serde(alias = "instantActions")]
    pub actions: Vec<Action>,
}

impl Message for InstantActions {
    const TOPIC: Topic = Topic::InstantActions;

    fn adapt(&mut self, version: Version) {
        self.actions.iter_mut().for_each(|action| action.adapt(version));
    }
}

/// The message with actions to be carried out at once as 1.1 spells it, and some vehicles of 2.0.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct OldInstantActions {
    /// The header.
    #[serde(flatten)]
    pub header: Header,
    /// The actions.
    pub instant_actions: Vec<Action>,
}

impl Message for OldInstantActions {
    const TOPIC: Topic = Topic::InstantActions;

    fn adapt(&mut self, version: Version) {
        self.instant_actions.iter_mut().for_each(|action| action.adapt(version));
    }
}

impl Action {
    /// Expresses the action as a version can.
    pub(super) fn adapt(&mut self, version: Version) {
        if version == Version::V3_0 {
            return;
        }
        self.retriable = None;
        if self.blocking_type == BlockingType::Single {
            self.blocking_type = BlockingType::Hard;
        }
    }
}

/// The state of an action.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct ActionState {
    /// The action's id.
    pub action_id: String,
    /// Its kind.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub action_type: Option<String>,
    /// Its text for people.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub action_descriptor: Option<String>,
    /// Its progress.
    pub action_status: ActionStatus,
    /// A text about its result.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub action_result: Option<String>,
}

/// The progress of an action.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum ActionStatus {
    /// Its node isn't reached yet, or its edge isn't entered yet.
    Waiting,
    /// It is prepared.
    Initializing,
    /// It is under way.
    Running,
    /// It is interrupted by a pause; 3.0.
    Paused,
    /// It has failed, and may be tried again; 3.0.
    Retriable,
    /// It is done.
    Finished,
    /// It has failed.
    Failed,
}

impl ActionStatus {
    /// Whether the action has ended.
    pub const fn is_over(self) -> bool {
        matches!(self, Self::Finished | Self::Failed)
    }

    /// The status as a version can tell it: the schemas of 2.x know neither pauses nor retries.
    pub(super) const fn adapted(self, version: Version) -> Self {
        match (self, version) {
            (Self::Paused | Self::Retriable, Version::V2_0 | Version::V2_1) => Self::Running,
            (status, _) => status,
        }
    }
}
