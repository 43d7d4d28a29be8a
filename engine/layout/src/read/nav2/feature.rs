//! A feature of GeoJSON: properties and a geometry.

use std::collections::BTreeMap;

use glam::DVec2;
use serde::Deserialize;
use serde_json::{Map, Value};

use crate::model::value::shorten;
use crate::read::file::Ignored;

/// A point or a line.
#[derive(Debug)]
pub(super) struct Feature {
    /// The byte offset in the file.
    pub at: u32,
    pub properties: Map<String, Value>,
    pub geometry: Geometry,
}

#[derive(Debug)]
pub(super) enum Geometry {
    /// `None` if its coordinates can't be used.
    Point(Option<DVec2>),
    /// All points of a line, or of several lines end to end; often none.
    Line(Vec<DVec2>),
}

#[derive(Deserialize)]
struct RawFeature {
    #[serde(default)]
    properties: Option<Map<String, Value>>,
    #[serde(default)]
    geometry: Option<RawGeometry>,
    /// `type`, and unknown keys.
    #[serde(flatten)]
    rest: BTreeMap<String, Value>,
}

#[derive(Deserialize)]
struct RawGeometry {
    #[serde(rename = "type")]
    kind: String,
    #[serde(default)]
    coordinates: Value,
    /// Unknown keys.
    #[serde(flatten)]
    rest: BTreeMap<String, Value>,
}

impl Feature {
    /// Parses a feature; `None` if it is neither a point nor a line.
    pub fn parse(text: &str, at: u32, ignored: &mut Ignored) -> Result<Option<Self>, String> {
        let feature: RawFeature = serde_json::from_str(text).map_err(|error| error.to_string())?;
        ignore(&feature.rest, "a feature", at, ignored);
        let properties = feature.properties;
        let Some(RawGeometry { kind, coordinates, rest }) = feature.geometry else {
            ignored.add(at, "feature without a geometry");
            return Ok(None);
        };
        ignore(&rest, "a geometry", at, ignored);
        let mut points = Vec::new();
        let collected = collect(&coordinates, &mut points, &mut |kind| ignored.add(at, kind));
        let geometry = match (kind.as_str(), collected, points.as_slice()) {
            ("Point", Ok(()), [point]) => Geometry::Point(Some(*point)),
            ("Point", ..) => Geometry::Point(None),
            (_, Err(error), _) => return Err(error),
            ("LineString" | "MultiLineString", ..) => Geometry::Line(points),
            _ => {
                ignored.add(at, format!("feature with the geometry {}", shorten(&kind)));
                return Ok(None);
            }
        };
        Ok(Some(Self { at, properties: properties.unwrap_or_default(), geometry }))
    }

    /// Returns an id, which may be a whole number or a text.
    pub fn id(&self, key: &str) -> Option<String> {
        match self.properties.get(key)? {
            Value::String(text) => Some(text.trim().to_owned()).filter(|text| !text.is_empty()),
            // Spreadsheets write 7.0.
            Value::Number(number) => match number.as_f64() {
                Some(value) if value.fract() == 0.0 && value.abs() < 1e15 => {
                    Some(format!("{value:.0}"))
                }
                _ => Some(number.to_string()),
            },
            _ => None,
        }
    }
}

/// Counts unknown keys, unless their values are empty. The type has no more information than the
/// geometry.
fn ignore(rest: &BTreeMap<String, Value>, owner: &str, at: u32, ignored: &mut Ignored) {
    for (key, _) in rest.iter().filter(|(key, value)| *key != "type" && !value.is_null()) {
        ignored.add_key(at, key, owner);
    }
}

/// Adds all positions in nested lists, and counts their other content. Real files nest the
/// coordinates of a LineString like those of a MultiLineString.
fn collect(
    coordinates: &Value,
    points: &mut Vec<DVec2>,
    ignore: &mut dyn FnMut(&str),
) -> Result<(), String> {
    let Value::Array(list) = coordinates else {
        return if coordinates.is_null() {
            Ok(())
        } else {
            Err("its coordinates aren't a list".to_owned())
        };
    };
    if let [x, y, more @ ..] = list.as_slice()
        && let (Some(x), Some(y)) = (number(x), number(y))
    {
        points.push(DVec2::new(x, y));
        if more.iter().any(|more| number(more) != Some(0.0)) {
            ignore("third coordinate of a position");
        }
        return Ok(());
    }
    list.iter().try_for_each(|inner| collect(inner, points, ignore))
}

/// Returns a number, even if it is written as text.
pub(super) fn number(value: &Value) -> Option<f64> {
    value.as_f64().or_else(|| value.as_str()?.trim().parse().ok().filter(|x: &f64| x.is_finite()))
}
