//! Ranges of numbers that the text of the standard has and its schemas lack.

use serde_json::Value;

use super::finding::{Notes, quoted};
use super::rule::Rule;

/// The largest number of the type uint32.
const U32: f64 = u32::MAX as f64;
/// A half turn in radians, as a vehicle may round it.
const HALF_TURN: f64 = std::f64::consts::PI + 1e-5;
/// The fields whose objects have any content: that of the layout, of vendors or of actions.
const FREE: [&str; 4] = ["actionParameters", "errorReferences", "infoReferences", "vehicleConfig"];
/// The deepest level of a message at which numbers are looked for.
const DEEPEST: usize = 16;

/// The range of a number.
struct Range {
    /// The field of the object, or of the list of objects, that has the number; none for the
    /// message itself.
    owner: &'static str,
    field: &'static str,
    least: f64,
    most: f64,
}

const fn range(owner: &'static str, field: &'static str, least: f64, most: f64) -> Range {
    Range { owner, field, least, most }
}

const fn at_least(owner: &'static str, field: &'static str, least: f64) -> Range {
    range(owner, field, least, f64::INFINITY)
}

/// Ranges of all versions; names of 2.x and 3.0 differ. Speeds of a vehicle have a sign, and
/// vendors write decelerations with either sign.
const RANGES: &[Range] = &[
    range("", "headerId", 0.0, U32),
    range("", "orderUpdateId", 0.0, U32),
    range("", "lastNodeSequenceId", 0.0, U32),
    at_least("", "distanceSinceLastNode", 0.0),
    range("nodes", "sequenceId", 0.0, U32),
    range("edges", "sequenceId", 0.0, U32),
    range("nodeStates", "sequenceId", 0.0, U32),
    range("edgeStates", "sequenceId", 0.0, U32),
    at_least("edges", "maxSpeed", 0.0),
    at_least("edges", "maximumSpeed", 0.0),
    at_least("edges", "maxRotationSpeed", 0.0),
    at_least("edges", "maximumRotationSpeed", 0.0),
    at_least("edges", "length", 0.0),
    range("nodePosition", "theta", -HALF_TURN, HALF_TURN),
    at_least("nodePosition", "allowedDeviationXY", 0.0),
    at_least("nodePosition", "allowedDeviationXy", 0.0),
    range("nodePosition", "allowedDeviationTheta", 0.0, HALF_TURN),
    at_least("trajectory", "degree", 1.0),
    at_least("controlPoints", "weight", 0.0),
    range("agvPosition", "theta", -HALF_TURN, HALF_TURN),
    at_least("agvPosition", "deviationRange", 0.0),
    range("batteryState", "batteryCharge", 0.0, 100.0),
    range("batteryState", "batteryHealth", 0.0, 100.0),
    range("batteryState", "reach", 0.0, U32),
    at_least("loads", "weight", 0.0),
    at_least("loadDimensions", "length", 0.0),
    at_least("loadDimensions", "width", 0.0),
    at_least("loadDimensions", "height", 0.0),
    at_least("physicalParameters", "speedMin", 0.0),
    at_least("physicalParameters", "speedMax", 0.0),
    at_least("physicalParameters", "accelerationMax", 0.0),
    at_least("physicalParameters", "heightMin", 0.0),
    at_least("physicalParameters", "heightMax", 0.0),
    at_least("physicalParameters", "minimumHeight", 0.0),
    at_least("physicalParameters", "maximumHeight", 0.0),
    at_least("physicalParameters", "length", 0.0),
    at_least("physicalParameters", "width", 0.0),
    at_least("loadSets", "maxWeight", 0.0),
    at_least("loadSets", "pickTime", 0.0),
    at_least("loadSets", "dropTime", 0.0),
    at_least("timing", "minOrderInterval", 0.0),
    at_least("timing", "minStateInterval", 0.0),
    at_least("timing", "defaultStateInterval", 0.0),
    at_least("timing", "visualizationInterval", 0.0),
];

/// Adds the numbers of a message that are out of their ranges and that the schema accepts.
pub(super) fn judge(content: &Value, notes: &mut Notes<'_>) {
    look(content, "", &mut String::new(), 0, notes);
}

fn look(value: &Value, owner: &str, place: &mut String, depth: usize, notes: &mut Notes<'_>) {
    if depth > DEEPEST {
        return;
    }
    let length = place.len();
    match value {
        Value::Object(fields) => {
            for (name, field) in fields.iter().filter(|(name, _)| !FREE.contains(&&***name)) {
                place.push('/');
                place.push_str(name);
                match field.as_f64() {
                    Some(number) => judge_number(owner, name, number, place, notes),
                    None => look(field, name, place, depth + 1, notes),
                }
                place.truncate(length);
            }
        }
        Value::Array(items) => {
            for (index, item) in items.iter().enumerate() {
                place.push('/');
                place.push_str(&index.to_string());
                look(item, owner, place, depth + 1, notes);
                place.truncate(length);
            }
        }
        _ => {}
    }
}

fn judge_number(owner: &str, field: &str, number: f64, place: &str, notes: &mut Notes<'_>) {
    let found = RANGES.iter().find(|range| (range.owner, range.field) == (owner, field));
    let Some(Range { least, most, .. }) = found else { return };
    if number < *least {
        add(place, number, &format!("at least {least}"), notes);
    } else if number > *most {
        add(place, number, &format!("at most {most}"), notes);
    }
}

/// Adds a number that is out of its range, unless that is told already.
pub(super) fn add(
    place: &str,
    number: impl core::fmt::Display,
    bound: &str,
    notes: &mut Notes<'_>,
) {
    let about = format!("{} is ", quoted(place));
    let mut told = notes.findings.iter().filter(|one| one.rule == Rule::ValueRange);
    if !told.any(|one| one.message.starts_with(&about)) {
        notes.add(Rule::ValueRange, format!("{about}{number}, not {bound}"));
    }
}
