//! Writes a graph for Nav2's Route Server.

use glam::DVec2;
use regatta_base::bezier::CubicBezier;
use regatta_base::graph::Ends;
use serde::Serialize;
use serde_json::{Map, Value, json};

use super::{Losses, segments};
use crate::model::format::Written;
use crate::model::path::Path;
use crate::model::route_graph::{Edge, Node, RouteGraph};
use crate::model::tags::{Orientation, Role, Tags};
use crate::read::nav2::REVERSE_OF;

/// The largest distance in metres between a curve and its written line.
const TOLERANCE: f64 = 0.01;

#[derive(Serialize)]
struct Feature {
    r#type: &'static str,
    properties: Properties,
    geometry: Geometry,
}

#[derive(Default, Serialize)]
struct Properties {
    id: u32,
    #[serde(skip_serializing_if = "Option::is_none")]
    frame: Option<Value>,
    /// The name beside that of the metadata.
    #[serde(skip_serializing_if = "Option::is_none")]
    name: Option<Value>,
    #[serde(skip_serializing_if = "Option::is_none")]
    startid: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    endid: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    cost: Option<Value>,
    #[serde(skip_serializing_if = "Option::is_none")]
    overridable: Option<Value>,
    #[serde(skip_serializing_if = "Map::is_empty")]
    metadata: Map<String, Value>,
    #[serde(skip_serializing_if = "Option::is_none")]
    operations: Option<Value>,
}

#[derive(Serialize)]
#[serde(tag = "type", content = "coordinates")]
enum Geometry {
    Point([f64; 2]),
    LineString(Vec<[f64; 2]>),
    MultiLineString([Vec<[f64; 2]>; 1]),
}

/// Writes a graph as GeoJSON: all nodes, then all edges, then those that are driven in reverse
/// gear.
#[must_use]
pub fn write(graph: &RouteGraph) -> Written {
    let nodes = graph.nodes().iter().map(|node| self::node(graph, node));
    let edges = graph.edges().iter().map(|edge| self::edge(graph, edge));
    let last = graph.edges().iter().map(|edge| edge.id).max().unwrap_or_default();
    // Reverse edges get the numbers after the largest id of an edge, and smaller numbers only if
    // these run out.
    let numbers = (last.wrapping_add(1)..=u32::MAX)
        .chain(0..=last)
        .filter(|id| graph.edge_by_id(*id).is_none());
    let driven_back = graph.edges().iter().filter_map(|edge| Some((edge, edge.reverse_speed?)));
    let back = driven_back.zip(numbers).map(|((edge, speed), id)| reverse(graph, edge, speed, id));
    let features: Vec<String> = nodes
        .chain(edges)
        .chain(back)
        .filter_map(|feature| serde_json::to_string(&feature).ok())
        .collect();
    let head = r#""type": "FeatureCollection", "name": "graph","#;
    let crs = r#""crs": {"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::3857"}},"#;
    let text = format!("{{\n{head}\n{crs}\n\"features\": [\n{}\n]\n}}\n", features.join(",\n"));
    Written { text, losses: losses(graph).into_lines() }
}

fn node(graph: &RouteGraph, node: &Node) -> Feature {
    let mut properties = properties(node.id, node.tags.as_deref());
    properties.frame.get_or_insert_with(|| json!("map"));
    if node.has_heading {
        properties.metadata.insert("theta".to_owned(), json!(node.theta));
    }
    if node.role != Role::None {
        properties.metadata.insert("role".to_owned(), json!(node.role.name()));
    }
    Feature {
        r#type: "Feature",
        properties,
        geometry: Geometry::Point((graph.origin() + node.position).into()),
    }
}

fn edge(graph: &RouteGraph, edge: &Edge) -> Feature {
    let mut properties = properties(edge.id, edge.tags.as_deref());
    properties.startid = Some(graph.node(edge.origin).id);
    properties.endid = Some(graph.node(edge.destination).id);
    properties.cost =
        properties.cost.filter(Value::is_number).or_else(|| Some(json!(edge.path.length())));
    set_drive(&mut properties.metadata, edge.speed, edge.orientation);
    let mut points = vec![(graph.origin() + edge.path.start()).into()];
    for cubic in edge.path.cubics() {
        let segments = line_segments(cubic);
        points.extend((1..=segments).map(|index| -> [f64; 2] {
            (graph.origin() + cubic.position(f64::from(index) / f64::from(segments))).into()
        }));
    }
    let geometry = if is_straight(&edge.path) {
        Geometry::LineString(points)
    } else {
        Geometry::MultiLineString([points])
    };
    Feature { r#type: "Feature", properties, geometry }
}

/// Returns an edge in reverse gear as a separate edge, from its destination to its origin.
fn reverse(graph: &RouteGraph, edge: &Edge, speed: f64, id: u32) -> Feature {
    let mut feature = self::edge(graph, edge);
    let properties = &mut feature.properties;
    std::mem::swap(&mut properties.startid, &mut properties.endid);
    properties.id = id;
    properties.metadata.insert(REVERSE_OF.to_owned(), json!(edge.id));
    properties.metadata.remove("heading_offset");
    set_drive(&mut properties.metadata, speed, edge.orientation.reversed());
    match &mut feature.geometry {
        Geometry::LineString(points) | Geometry::MultiLineString([points]) => points.reverse(),
        Geometry::Point(_) => {}
    }
    feature
}

fn set_drive(metadata: &mut Map<String, Value>, speed: f64, orientation: Orientation) {
    metadata.insert("abs_speed_limit".to_owned(), json!(speed));
    let (key, angle) = match orientation {
        Orientation::Tangential => return,
        Orientation::Offset(angle) => ("heading_offset", angle),
        Orientation::Fixed(angle) => ("heading", angle),
    };
    metadata.insert(key.to_owned(), json!(angle));
}

/// Returns the properties of a feature with its tags. Properties that Nav2 reads outside of the
/// metadata are written there.
fn properties(id: u32, tags: Option<&Tags>) -> Properties {
    let mut properties = Properties { id, ..Properties::default() };
    let Some(tags) = tags else { return properties };
    for (key, text) in &tags.properties {
        let value = value(text);
        match &**key {
            "frame" => properties.frame = Some(json!(text)),
            "name" => properties.name = Some(json!(text)),
            "cost" if value.is_number() => properties.cost = Some(value),
            "overridable" if value.is_boolean() => properties.overridable = Some(value),
            "operations" if value.is_object() || value.is_array() => {
                properties.operations = Some(value)
            }
            key => drop(properties.metadata.insert(key.to_owned(), value)),
        }
    }
    for (key, tag) in [("name", &tags.name), ("level", &tags.level), ("class", &tags.zone)] {
        properties.metadata.extend(tag.as_ref().map(|tag| (key.to_owned(), json!(tag))));
    }
    properties
}

/// Returns a text as a number, truth value, list or map, if that is read back as the same text;
/// otherwise returns the text.
fn value(text: &str) -> Value {
    let value = serde_json::from_str(text).unwrap_or(Value::Null);
    let written = value.to_string();
    if written == text && !matches!(value, Value::Null | Value::String(_)) {
        value
    } else {
        json!(text)
    }
}

/// Whether a path is one straight segment.
fn is_straight(path: &Path) -> bool {
    path.single().is_some_and(|cubic| line_segments(cubic) == 1)
}

/// Returns the number of segments that approximate a cubic within the tolerance; 1 for a straight
/// cubic.
fn line_segments(cubic: &CubicBezier) -> u32 {
    let [start, first, second, end] = cubic.control_points;
    let chord = end - start;
    let is_on_chord = [first, second].into_iter().all(|handle| {
        let along = (handle - start).dot(chord);
        let off = (handle - start).perp_dot(chord).abs();
        (0.0..=chord.length_squared()).contains(&along) && off <= 1e-6 * chord.length()
    });
    if is_on_chord { 1 } else { segments(cubic, TOLERANCE).max(2) }
}

/// Counts the parts of the graph that the Route Server doesn't use.
fn losses(graph: &RouteGraph) -> Losses {
    let mut losses = Losses::default();
    for edge in graph.edges() {
        losses.add_if(
            !is_straight(&edge.path),
            "edges are curved: Nav2 drives straight between their nodes; the true shape is the \
             geometry, for display only",
        );
        losses.add_if(
            edge.reverse_speed.is_some(),
            "edges allow reverse gear: written as second edges, which Nav2 drives forwards unless \
             its controller reverses",
        );
        losses.add_if(
            edge.orientation != Orientation::Tangential,
            "edges prescribe a heading: it is in the metadata, which Nav2 doesn't use",
        );
        losses.add_if(
            edge.rotation != Ends::default(),
            "edges prescribe how robots turn at their ends: this format doesn't",
        );
    }
    losses.add_many(
        graph.nodes().iter().filter(|node| node.has_heading).count(),
        "nodes have a heading: it is in the metadata, which Nav2 doesn't use",
    );
    losses.add_many(graph.stations().len(), "stations: this format has none");
    losses.add_many(graph.background().len(), "lines of the background: this format has none");
    losses.add_many(graph.zones().len(), "zones with a rule: only their names are kept");
    losses.add_many(graph.doors().len(), "doors: only their names are kept");
    losses.add_many(graph.lifts().len(), "lifts: only their edges are kept");
    losses.add_if(
        graph.origin() != DVec2::ZERO,
        "offset of the graph on the map: Nav2 stores positions in single precision, too coarse for \
         coordinates as large",
    );
    losses
}
