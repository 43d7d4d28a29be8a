//! A layout as a file of another system describes it, with that file's ids: what every reader in `format` makes.
//!
//! [`Layout::into_raw`] gives nodes and edges numbers, so that they pass the same validation as our own files.

use std::collections::BTreeMap;

use glam::DVec2;

use super::bezier::CubicBezier;
use super::finding::{Report, Subject};
use super::item::{RawCurve, RawEdge, RawNode, RawStation};
use super::path::Path;
use super::tags::{Orientation, Role, Rotation, Tags};
use super::value::shorten;
use super::yaml::RawGraph;

/// Everything that a reader understands of a file. Numbers need not be in range, nor ids unique or known.
#[derive(Debug, Default)]
pub(super) struct Layout {
    pub nodes: Vec<LayoutNode>,
    pub edges: Vec<LayoutEdge>,
    pub stations: Vec<LayoutStation>,
    /// Lines that are drawn behind the graph, in metres: walls, racks.
    pub background: Vec<Vec<DVec2>>,
}

/// A node.
#[derive(Debug, Default)]
pub(super) struct LayoutNode {
    /// The byte offset in the file, for messages.
    pub at: u32,
    /// The file's id, unique among nodes.
    pub id: String,
    /// Metres; x to the east, y to the north.
    pub position: DVec2,
    /// Radians; `None` if the file doesn't say, or allows any.
    pub heading: Option<f64>,
    pub role: Role,
    pub tags: Tags,
}

/// A directed edge.
#[derive(Debug, Default)]
pub(super) struct LayoutEdge {
    /// The byte offset in the file, for messages.
    pub at: u32,
    /// The file's id, unique among edges.
    pub id: String,
    /// The ids of nodes.
    pub origin: String,
    pub destination: String,
    pub shape: Shape,
    /// Metres per second from origin to destination; `None` if the file doesn't say.
    pub speed: Option<f64>,
    /// Metres per second in reverse gear from destination to origin; `None` if that isn't allowed.
    pub reverse_speed: Option<f64>,
    pub orientation: Orientation,
    pub rotation: [Rotation; 2],
    pub tags: Tags,
}

/// The shape of an edge.
#[derive(Debug, Default)]
pub(super) enum Shape {
    /// The straight segment between its nodes.
    #[default]
    Straight,
    /// Cubics end to end, at least one, which should start and end at its nodes.
    Cubics(Vec<CubicBezier>),
}

/// A place where robots do something.
#[derive(Debug, Default)]
pub(super) struct LayoutStation {
    /// The byte offset in the file, for messages.
    pub at: u32,
    /// The name, unique among stations.
    pub name: String,
    pub role: Role,
    /// The ids of nodes.
    pub nodes: Vec<String>,
    /// Metres.
    pub position: Option<DVec2>,
    pub properties: BTreeMap<Box<str>, Box<str>>,
}

/// The speed in metres per second on edges for which a file gives none.
pub(super) const DEFAULT_SPEED: f64 = 1.0;

impl Layout {
    /// Numbers nodes and edges: by their ids if all of these are numbers, else from 1 in the order of the file, and the
    /// ids become names.
    pub fn into_raw(self, report: &mut Report<'_>) -> RawGraph {
        let node_ids = Numbering::new(self.nodes.iter().map(|node| (node.at, node.id.as_str())), "node", report);
        let edge_ids = Numbering::new(self.edges.iter().map(|edge| (edge.at, edge.id.as_str())), "edge", report);
        warn_of_unknown_speeds(&self.edges, report);
        let has_free = self.nodes.iter().any(|node| node.heading.is_none());
        let headings = if has_free { free_headings(&self) } else { BTreeMap::new() };
        let heading = |node: &LayoutNode| node.heading.or(headings.get(&node.id).copied()).unwrap_or(0.0);
        let headings: Vec<f64> = self.nodes.iter().map(heading).collect();
        let nodes = (0..).zip(self.nodes).zip(headings);
        let nodes = nodes.map(|((index, node), heading)| raw_node(node, heading, node_ids.number(index))).collect();
        let by_id = &node_ids.by_id;
        let edges =
            (0..).zip(self.edges).map(|(index, edge)| raw_edge(edge, edge_ids.number(index), by_id, report)).collect();
        let stations = self.stations.into_iter().map(|station| raw_station(station, by_id, report)).collect();
        RawGraph { nodes, edges, stations, background: self.background, is_imported: true, ..RawGraph::default() }
    }
}

/// The numbers that stand for the ids of a file.
struct Numbering {
    /// By the file's id.
    by_id: BTreeMap<String, u32>,
    /// By index; `None` if they are counted from 1.
    numbers: Option<Vec<u32>>,
}

impl Numbering {
    fn new<'id>(ids: impl Iterator<Item = (u32, &'id str)> + Clone, kind: &str, report: &mut Report<'_>) -> Self {
        let number = |id: &str| id.parse::<u32>().ok().filter(|number| number.to_string() == id);
        let numbers: Option<Vec<u32>> = ids.clone().map(|(_, id)| number(id)).collect();
        let mut by_id = BTreeMap::new();
        for (index, (at, id)) in ids.enumerate() {
            let number = numbers.as_ref().map_or(index as u32 + 1, |numbers| numbers[index]);
            if by_id.insert(id.to_owned(), number).is_some() && numbers.is_none() {
                report.error(
                    at,
                    Subject::File,
                    format!("{kind} `{}` is given twice: give each a unique id", shorten(id)),
                );
            }
        }
        Self { by_id, numbers }
    }

    fn number(&self, index: usize) -> Number {
        match &self.numbers {
            Some(numbers) => Number { number: numbers[index], is_id: true },
            None => Number { number: index as u32 + 1, is_id: false },
        }
    }
}

/// A number of a node or an edge.
#[derive(Clone, Copy)]
struct Number {
    number: u32,
    /// Whether the file has this number as its id; otherwise the id becomes the name.
    is_id: bool,
}

/// Returns tags that have the file's id as their name, if that isn't the number. A name besides the id becomes a property.
fn tags_with_id(mut tags: Tags, id: &str, number: Number) -> Option<Box<Tags>> {
    if !number.is_id
        && let Some(name) = tags.name.replace(id.into()).filter(|name| **name != *id)
    {
        tags.set("name", &name);
    }
    tags.boxed()
}

/// Returns, by id, headings for nodes that have none: robots stand as on the first edge that leaves the node, else as on
/// the first that ends there.
fn free_headings(layout: &Layout) -> BTreeMap<String, f64> {
    let positions: BTreeMap<_, _> = layout.nodes.iter().map(|node| (node.id.as_str(), node.position)).collect();
    let tangents = |edge: &LayoutEdge| -> Option<[DVec2; 2]> {
        let straight =
            || Some(CubicBezier::straight(*positions.get(&*edge.origin)?, *positions.get(&*edge.destination)?));
        let path = match &edge.shape {
            Shape::Straight => straight()?.into(),
            Shape::Cubics(cubics) => Path::from_cubics(cubics)?,
        };
        Some([path.start_tangent(), path.end_tangent()])
    };
    let mut headings = BTreeMap::new();
    let known: Vec<_> = layout.edges.iter().filter_map(|edge| Some((edge, tangents(edge)?))).collect();
    let departures = known.iter().map(|(edge, [start, _])| (&edge.origin, edge.orientation, start));
    let arrivals = known.iter().map(|(edge, [_, end])| (&edge.destination, edge.orientation, end));
    for (node, orientation, tangent) in departures.chain(arrivals) {
        headings.entry(node.clone()).or_insert_with(|| orientation.heading(tangent.to_angle()));
    }
    headings
}

fn raw_node(node: LayoutNode, heading: f64, number: Number) -> RawNode {
    RawNode {
        at: node.at,
        id: Some(number.number),
        x: Some(node.position.x),
        y: Some(node.position.y),
        theta: Some(heading),
        role: node.role,
        tags: tags_with_id(node.tags, &node.id, number),
    }
}

fn raw_edge(edge: LayoutEdge, number: Number, nodes: &BTreeMap<String, u32>, report: &mut Report<'_>) -> RawEdge {
    let mut end = |id: &str, which: &str| {
        let found = nodes.get(id).copied();
        if found.is_none() {
            let (name, node) = (shorten(&edge.id), shorten(id));
            let message = format!("edge `{name}` {which} node `{node}`, which doesn't exist: add it or correct the id");
            report.error(edge.at, Subject::File, message);
        }
        found
    };
    RawEdge {
        at: edge.at,
        id: Some(number.number),
        origin: end(&edge.origin, "starts at"),
        destination: end(&edge.destination, "ends at"),
        curve: Some(match edge.shape {
            Shape::Straight => RawCurve::Linear,
            Shape::Cubics(cubics) => RawCurve::Cubics(cubics),
        }),
        forward: None,
        backward: None,
        velocity_forward: Some(edge.speed.unwrap_or(DEFAULT_SPEED)),
        velocity_backwards: Some(edge.reverse_speed.unwrap_or(0.0)),
        orientation: edge.orientation,
        rotation: edge.rotation,
        tags: tags_with_id(edge.tags, &edge.id, number),
    }
}

fn raw_station(station: LayoutStation, nodes: &BTreeMap<String, u32>, report: &mut Report<'_>) -> RawStation {
    for id in station.nodes.iter().filter(|id| !nodes.contains_key(*id)) {
        let (name, node) = (shorten(&station.name), shorten(id));
        let message = format!("station `{name}` names node `{node}`, which doesn't exist: ignored");
        report.warning(station.at, Subject::File, message);
    }
    RawStation {
        at: station.at,
        nodes: station.nodes.iter().filter_map(|id| nodes.get(id).copied()).collect(),
        name: station.name,
        role: station.role,
        position: station.position,
        properties: station.properties,
    }
}

fn warn_of_unknown_speeds(edges: &[LayoutEdge], report: &mut Report<'_>) {
    let mut unknown = edges.iter().filter(|edge| edge.speed.is_none());
    let Some(first) = unknown.next() else { return };
    let others = unknown.count();
    let who =
        if others == 0 { format!("edge `{}` has", shorten(&first.id)) } else { format!("{} edges have", others + 1) };
    let message = format!("{who} no speed limit: {DEFAULT_SPEED} m/s is used; robot types limit it further");
    report.warning(first.at, Subject::File, message);
}
