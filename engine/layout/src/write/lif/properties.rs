//! The properties of nodes, edges and stations for which LIF has keys, such as those of a LIF file
//! that was read.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::{Losses, Object};
use crate::model::tags::{OTHER_VEHICLE_TYPES, Tags, VEHICLE_TYPES};

/// The vehicle type of nodes and edges without one.
const VEHICLE_TYPE: &str = "robot";

/// The largest number of vehicle types of a node or an edge. Each gets a copy of the properties.
const MAX_TYPES: usize = 100;

/// The type of a value in the schema.
#[derive(Clone, Copy, Debug)]
pub(super) enum Kind {
    Text,
    Number,
    NotNegative,
    Boolean,
    /// `NONE`, `CCW`, `CW` or `BOTH`.
    Rotation,
    LoadRestriction,
}

/// The properties that aren't written yet.
pub(super) struct Properties<'a> {
    rest: BTreeMap<&'a str, &'a str>,
    zone: Option<&'a str>,
}

#[derive(Deserialize, Serialize)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
struct Action {
    action_type: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    action_description: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    requirement_type: Option<Requirement>,
    blocking_type: Blocking,
    #[serde(skip_serializing_if = "Option::is_none")]
    action_parameters: Option<Vec<Parameter>>,
}

#[derive(Deserialize, Serialize)]
#[serde(rename_all = "UPPERCASE")]
enum Requirement {
    Required,
    Conditional,
    Optional,
}

#[derive(Deserialize, Serialize)]
#[serde(rename_all = "UPPERCASE")]
enum Blocking {
    None,
    Soft,
    Hard,
}

#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct Parameter {
    key: String,
    value: String,
}

#[derive(Deserialize, Serialize)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
struct LoadRestriction {
    unloaded: bool,
    loaded: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    load_set_names: Option<Vec<String>>,
}

impl<'a> Properties<'a> {
    pub fn new(tags: Option<&'a Tags>) -> Self {
        let mut properties = tags
            .map_or(Self { rest: BTreeMap::new(), zone: None }, |tags| Self::of(&tags.properties));
        properties.zone = tags.and_then(|tags| tags.zone.as_deref());
        properties
    }

    pub fn of(map: &'a BTreeMap<Box<str>, Box<str>>) -> Self {
        Self { rest: map.iter().map(|(key, value)| (&**key, &**value)).collect(), zone: None }
    }

    pub fn get(&self, key: &str) -> Option<&'a str> {
        self.rest.get(key).copied()
    }

    /// Takes the vehicle types out; at least one.
    pub fn vehicle_types(&mut self) -> Vec<&'a str> {
        let mut types: Vec<&str> =
            self.get(VEHICLE_TYPES).into_iter().flat_map(|types| types.split(", ")).collect();
        types.sort_unstable();
        types.dedup();
        // Otherwise the property counts as lost.
        if types.len() <= MAX_TYPES {
            self.rest.remove(VEHICLE_TYPES);
        }
        types.truncate(MAX_TYPES);
        if types.is_empty() { vec![VEHICLE_TYPE] } else { types }
    }

    /// Returns the display name: a property if names are ids, otherwise the name.
    pub fn name(&mut self, are_ids: bool, name: Option<&'a str>) -> Option<&'a str> {
        if are_ids { self.rest.remove("name") } else { name }
    }

    /// Takes the actions out if they are valid.
    pub fn actions(&mut self) -> Option<Value> {
        let actions: Vec<Action> = serde_json::from_str(self.get("actions")?).ok()?;
        self.rest.remove("actions");
        Some(json!(actions))
    }

    /// Moves a property into an object, if its value is valid there.
    pub fn move_to(&mut self, object: &mut Object, key: &'static str, kind: Kind) {
        if let Some(value) = self.get(key).and_then(|text| value(text, kind)) {
            self.rest.remove(key);
            object.insert(key.to_owned(), value);
        }
    }

    /// Counts the remaining properties as lost. `kind` is a plural.
    pub fn count_losses(mut self, kind: &str, losses: &mut Losses) {
        if self.rest.remove(OTHER_VEHICLE_TYPES).is_some() {
            losses.add(format!("{kind} have other properties for other vehicle types: not kept"));
        }
        for key in self.rest.into_keys() {
            losses.add(format!("{kind} have a property `{key}` that isn't valid in LIF"));
        }
        if self.zone.is_some() {
            losses.add(format!("{kind} have a zone: LIF has none"));
        }
    }
}

fn value(text: &str, kind: Kind) -> Option<Value> {
    let number = text.trim().parse::<f64>().ok().filter(|number| number.is_finite());
    match kind {
        Kind::Text => Some(text.into()),
        Kind::Number => number.map(Value::from),
        Kind::NotNegative => number.filter(|number| *number >= 0.0).map(Value::from),
        Kind::Boolean => text.trim().to_ascii_lowercase().parse::<bool>().ok().map(Value::from),
        Kind::Rotation => ["NONE", "CCW", "CW", "BOTH"].contains(&text).then(|| text.into()),
        Kind::LoadRestriction => Some(json!(serde_json::from_str::<LoadRestriction>(text).ok()?)),
    }
}
