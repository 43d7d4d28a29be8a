//! The metadata of a feature: keys that Nav2 or our writer define, and all other keys as
//! properties.
//!
//! Lists and maps are kept as JSON. Our writer turns the JSON into lists and maps again.

use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::PI;

use serde_json::Value;

use super::REVERSE_OF;
use super::feature::{Feature, number};
use crate::model::tags::{Orientation, Role, Tags};
use crate::model::value::shorten;
use crate::read::file::Ignored;

/// The largest number of bytes of a list or map that is kept as a property.
const MAX_JSON: usize = 10_000;

/// The keys of angles.
const ANGLES: [&str; 5] = ["theta", "yaw", "orientation", "heading_offset", "heading"];

/// The values of keys that Nav2 or our writer define.
#[derive(Debug, Default)]
pub(super) struct Special {
    /// Radians.
    pub heading: Option<f64>,
    pub role: Role,
    /// Metres per second.
    pub speed: Option<f64>,
    /// A speed that isn't a number from 0, as text.
    pub wrong_speed: Option<String>,
    /// The keys of angles that can't be used, each with its value as text.
    pub wrong_angles: BTreeMap<&'static str, String>,
    pub orientation: Orientation,
    pub reverse_of: Option<String>,
}

impl Special {
    /// Returns the heading on the map that the key `heading` gives, if it does.
    pub fn map_heading(&self) -> Option<f64> {
        match self.orientation {
            Orientation::Fixed(heading) => Some(heading),
            Orientation::Tangential | Orientation::Offset(_) => None,
        }
    }
}

/// Returns the tags of a feature, and the special values of its metadata. `known` are properties
/// that are read elsewhere.
pub(super) fn read(feature: &Feature, known: &[&str], ignored: &mut Ignored) -> (Tags, Special) {
    let (mut tags, mut special) = (Tags::default(), Special::default());
    let metadata = feature.properties.get("metadata").and_then(Value::as_object);
    let mut taken = BTreeSet::new();
    for (key, value) in metadata.into_iter().flatten() {
        if take(key, value, &mut tags, &mut special) {
            taken.insert(key.as_str());
        }
    }
    // Other programs write the same keys beside `metadata`.
    for (key, value) in &feature.properties {
        if known.contains(&key.as_str()) || (key == "metadata" && metadata.is_some()) {
            continue;
        }
        if taken.contains(key.as_str()) || !take(key, value, &mut tags, &mut special) {
            keep(key, value, feature, &mut tags, ignored);
        }
    }
    for (key, value) in metadata.into_iter().flatten() {
        if !taken.contains(key.as_str()) {
            keep(key, value, feature, &mut tags, ignored);
        }
    }
    (tags, special)
}

fn keep(key: &str, value: &Value, feature: &Feature, tags: &mut Tags, ignored: &mut Ignored) {
    match text(value).or_else(|| {
        Some(value.to_string()).filter(|json| json.len() <= MAX_JSON && !value.is_null())
    }) {
        // A key of the metadata may also be that of a property.
        Some(text) if tags.properties.contains_key(key) => {
            tags.set(&format!("metadata.{key}"), &text)
        }
        Some(text) => tags.set(key, &text),
        None if value.is_null() => {}
        None => ignored.add_named(feature.at, format!("large key `{}` of a feature", shorten(key))),
    }
}

/// Takes a value whose key Nav2 or our writer define. Returns whether it is such a key.
fn take(key: &str, value: &Value, tags: &mut Tags, special: &mut Special) -> bool {
    match key {
        "name" | "level" | "class" => {
            let Some(text) = value.as_str().filter(|text| !text.is_empty()) else { return false };
            *(match key {
                "name" => &mut tags.name,
                "level" => &mut tags.level,
                _ => &mut tags.zone,
            }) = Some(text.into());
        }
        "role" => match value.as_str().and_then(|text| text.parse().ok()) {
            Some(role) => special.role = role,
            None => return false,
        },
        "abs_speed_limit" => match number(value) {
            Some(speed) if speed > 0.0 => special.speed = Some(speed),
            // 0 is no limit.
            Some(0.0) => return false,
            _ => {
                let plain = text(value).unwrap_or_else(|| value.to_string());
                special.wrong_speed = Some(plain).filter(|_| !value.is_null());
                return false;
            }
        },
        "theta" | "yaw" | "orientation" | "heading_offset" | "heading" => {
            return take_angle(key, value, special);
        }
        REVERSE_OF => match text(value) {
            Some(id) => special.reverse_of = Some(id),
            None => return false,
        },
        _ => return false,
    }
    true
}

/// Takes an angle. Returns whether it is one; notes it otherwise.
fn take_angle(key: &str, value: &Value, special: &mut Special) -> bool {
    let Some(known) = ANGLES.into_iter().find(|known| *known == key) else { return false };
    let Some(angle) = angle(value) else {
        if !value.is_null() {
            let plain = text(value).unwrap_or_else(|| value.to_string());
            special.wrong_angles.insert(known, plain);
        }
        return false;
    };
    match known {
        "heading_offset" => special.orientation = Orientation::Offset(angle),
        "heading" => special.orientation = Orientation::Fixed(angle),
        _ => special.heading = Some(angle),
    }
    true
}

/// Returns the angle in radians of a number, also one in quotation marks, or of a quaternion. A
/// number beyond a full turn isn't an angle.
fn angle(value: &Value) -> Option<f64> {
    if let Some(angle) = number(value) {
        return (angle.abs() <= 2.0 * PI).then_some(angle);
    }
    let [x, y, z, w] = ["x", "y", "z", "w"].map(|name| value.get(name).and_then(Value::as_f64));
    let (x, y, z, w) = (x.unwrap_or(0.0), y.unwrap_or(0.0), z?, w?);
    let yaw = (2.0 * (w * z + x * y)).atan2(1.0 - 2.0 * (y * y + z * z));
    yaw.is_finite().then_some(yaw)
}

/// Returns a plain value as text.
pub(super) fn text(value: &Value) -> Option<String> {
    match value {
        Value::String(text) => Some(text.clone()),
        Value::Number(number) => Some(number.to_string()),
        Value::Bool(flag) => Some(flag.to_string()),
        _ => None,
    }
}
