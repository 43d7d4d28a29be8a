//! The edges of the file: one for each edge of the graph, and one for each reverse gear.

use std::collections::BTreeSet;

use glam::DVec2;
use regatta_base::graph::{Ends, NodeIndex, Rotation};
use serde_json::{Value, json};

use super::properties::{Kind, Properties};
use super::{Object, Writer, for_each_type, is_straight, level, point};
use crate::model::path::Path;
use crate::model::route_graph::{Edge, RouteGraph};
use crate::model::tags::Orientation;

/// The largest distance in metres of control points from those of a straight segment.
const STRAIGHT: f64 = 1e-9;

/// An edge of the file: an edge of the graph in one gear.
struct Directed<'p> {
    id: String,
    ends: Ends<NodeIndex>,
    path: &'p Path,
    /// Metres per second.
    speed: f64,
    orientation: Orientation,
    /// The rotations at its start and its end.
    rotation: Ends<Rotation>,
}

impl<'a> Writer<'a> {
    /// Writes all edges: first those of the graph, then their reverse gears.
    pub fn edges(&mut self) {
        let graph = self.graph;
        for (index, edge) in graph.edges().iter().enumerate() {
            let directed = Directed {
                id: self.names.edges.ids[index].clone(),
                ends: Ends { origin: edge.origin, destination: edge.destination },
                path: &edge.path,
                speed: edge.speed,
                orientation: edge.orientation,
                rotation: edge.rotation,
            };
            let properties = self.edge(edge, &directed);
            properties.count_losses("edges", &mut self.losses);
            self.count_level(edge);
        }
        for (index, edge) in graph.edges().iter().enumerate() {
            let Some(speed) = edge.reverse_speed else { continue };
            let directed = Directed {
                id: self.names.reverse(index),
                ends: Ends { origin: edge.destination, destination: edge.origin },
                path: &edge.path.reversed(),
                speed,
                orientation: edge.orientation.reversed(),
                rotation: Ends {
                    origin: edge.rotation.destination,
                    destination: edge.rotation.origin,
                },
            };
            self.edge(edge, &directed);
            self.losses.add(
                "edges can be driven in reverse gear: written as further edges, which are read as \
                 such",
            );
        }
    }

    /// Writes an edge. Returns the remaining properties.
    fn edge(&mut self, edge: &'a Edge, directed: &Directed<'_>) -> Properties<'a> {
        let mut properties = Properties::new(edge.tags.as_deref());
        let types = properties.vehicle_types();
        let mut object = Object::new();
        object.insert("edgeId".into(), directed.id.as_str().into());
        if let Some(name) = properties.name(self.names.edges.are_names, edge.name()) {
            object.insert("edgeName".into(), name.into());
        }
        properties.move_to(&mut object, "edgeDescription", Kind::Text);
        for (key, node) in
            [("startNodeId", directed.ends.origin), ("endNodeId", directed.ends.destination)]
        {
            object.insert(key.into(), self.names.nodes.ids[node.0 as usize].as_str().into());
        }
        let shared = shared(directed, self.graph.origin(), &mut properties);
        object.insert("vehicleTypeEdgeProperties".into(), for_each_type(&types, &shared));
        let level = level(self.graph.node(directed.ends.origin));
        self.sheets.entry(level).or_default().edges.push(object);
        properties
    }

    fn count_level(&mut self, edge: &Edge) {
        let own = edge.tags.as_ref().and_then(|tags| tags.level.as_deref());
        if own.is_some() && own != level(self.graph.node(edge.origin)) {
            self.losses.add(
                "edges are on another level than the node where they start: written on the level \
                 of that node",
            );
        }
    }
}

/// Returns the properties for any vehicle type.
fn shared(directed: &Directed<'_>, origin: DVec2, properties: &mut Properties<'_>) -> Object {
    let (kind, angle) = match directed.orientation {
        Orientation::Tangential => ("TANGENTIAL", 0.0),
        Orientation::Offset(angle) => ("TANGENTIAL", angle),
        Orientation::Fixed(angle) => ("GLOBAL", angle),
    };
    let mut object = Object::new();
    object.insert("orientationType".into(), kind.into());
    object.insert("vehicleOrientation".into(), angle.into());
    // Robots keep the heading of the edge, unless its file allows rotation.
    object.insert("rotationAllowed".into(), false.into());
    object.insert("maxSpeed".into(), directed.speed.into());
    for (key, rotation) in [
        ("rotationAtStartNodeAllowed", directed.rotation.origin),
        ("rotationAtEndNodeAllowed", directed.rotation.destination),
    ] {
        if let Some(name) = rotation_name(rotation) {
            object.insert(key.into(), name.into());
        }
    }
    object.insert("trajectory".into(), trajectory(directed.path, origin));
    let kept = [
        ("rotationAllowed", Kind::Boolean),
        ("rotationAtStartNodeAllowed", Kind::Rotation),
        ("rotationAtEndNodeAllowed", Kind::Rotation),
        ("maxRotationSpeed", Kind::Number),
        ("minHeight", Kind::Number),
        ("maxHeight", Kind::Number),
        ("loadRestriction", Kind::LoadRestriction),
        ("reentryAllowed", Kind::Boolean),
    ];
    for (key, kind) in kept {
        properties.move_to(&mut object, key, kind);
    }
    if let Some(actions) = properties.actions() {
        object.insert("actions".into(), actions);
    }
    object
}

/// Returns LIF's name of a rotation; `None` for LIF's default.
fn rotation_name(rotation: Rotation) -> Option<&'static str> {
    match rotation {
        Rotation::Shorter => None,
        Rotation::CounterClockwise => Some("CCW"),
        Rotation::Clockwise => Some("CW"),
        Rotation::None => Some("NONE"),
    }
}

/// Returns a NURBS curve of degree 3 with an inner knot of multiplicity 3 at each joint; of degree
/// 1 for a straight segment.
fn trajectory(path: &Path, origin: DVec2) -> Value {
    if path.single().is_some_and(|cubic| is_straight(cubic, STRAIGHT)) {
        let points = [path.start(), path.end()].map(|position| point(origin + position));
        return json!({"degree": 1, "knotVector": [0.0, 0.0, 1.0, 1.0], "controlPoints": points});
    }
    let count = path.cubic_count();
    let joints = (0..=count).flat_map(|joint| [joint as f64 / count as f64; 3]);
    let knots: Vec<f64> = std::iter::once(0.0).chain(joints).chain([1.0]).collect();
    let others = path.cubics().flat_map(|cubic| cubic.control_points.into_iter().skip(1));
    let points = std::iter::once(path.start()).chain(others);
    let points: Vec<Value> = points.map(|position| point(origin + position)).collect();
    json!({"degree": 3, "knotVector": knots, "controlPoints": points})
}

/// The ids of a file.
pub(super) struct Names {
    pub nodes: List,
    pub edges: List,
    /// All ids of edges, those of reverse gear included.
    used: BTreeSet<String>,
    /// A number above the ids of all edges.
    next: u64,
}

/// The ids of the nodes or of the edges.
pub(super) struct List {
    pub ids: Vec<String>,
    /// Whether the ids are names. Otherwise they are numbers.
    pub are_names: bool,
}

impl Names {
    /// Uses the names of nodes as ids if they are unique. They are the ids of the file that was
    /// read.
    pub fn new(graph: &RouteGraph) -> Self {
        let nodes = List::new(graph.nodes().iter().map(|node| (node.id, node.name())));
        let edges = List::new(graph.edges().iter().map(|edge| (edge.id, edge.name())));
        let used = edges.ids.iter().cloned().collect();
        let next = graph.edges().iter().map(|edge| u64::from(edge.id) + 1).max().unwrap_or(1);
        Self { nodes, edges, used, next }
    }

    /// Returns an id for the reverse gear of an edge. It is a number if all other ids are numbers.
    pub fn reverse(&mut self, index: usize) -> String {
        let id = if self.edges.are_names {
            let mut id = format!("{}-reverse", self.edges.ids[index]);
            while self.used.contains(&id) {
                id.push('_');
            }
            id
        } else {
            self.next += 1;
            (self.next - 1).to_string()
        };
        self.used.insert(id.clone());
        id
    }
}

impl List {
    fn new<'n>(items: impl Iterator<Item = (u32, Option<&'n str>)> + Clone) -> Self {
        let mut used = BTreeSet::new();
        let are_names = items
            .clone()
            .all(|(_, name)| name.is_some_and(|name| !name.is_empty() && used.insert(name)));
        let ids = items.map(|(number, name)| match name {
            Some(name) if are_names => name.to_owned(),
            _ => number.to_string(),
        });
        Self { ids: ids.collect(), are_names }
    }
}
