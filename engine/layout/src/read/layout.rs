//! A layout as a file of another system describes it, with that file's ids. Every reader of another
//! format makes one.
//!
//! [`Layout::into_raw`] gives nodes and edges numbers, so that they pass the same validation as our
//! own files.

mod joined;
mod numbering;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;

use glam::DVec2;
use regatta_base::bezier::CubicBezier;
use regatta_base::graph::{Ends, Rotation};

use self::numbering::{Index, Number, Numbering};
use crate::model::facilities::Cabin;
use crate::model::finding::Report;
use crate::model::path::Path;
use crate::model::raw::{
    RawCurve, RawDoor, RawDoorTimes, RawEdge, RawGraph, RawLift, RawNode, RawStation, RawZone,
};
use crate::model::tags::{BackgroundLine, NAME, Orientation, Role, Tags};
use crate::model::value::shorten;
use crate::model::zones::ZoneRule;

/// The content of a file that a reader understands. Numbers may be out of range, and ids may be
/// repeated or unknown.
#[derive(Debug, Default)]
pub(crate) struct Layout {
    pub nodes: Vec<LayoutNode>,
    pub edges: Vec<LayoutEdge>,
    pub stations: Vec<LayoutStation>,
    pub zones: Vec<LayoutZone>,
    pub doors: Vec<LayoutDoor>,
    pub lifts: Vec<LayoutLift>,
    /// Lines that are drawn behind the graph, in metres: walls, racks.
    pub background: Vec<BackgroundLine>,
    /// Whether angles that are read as radians may be degrees.
    pub has_doubtful_angles: bool,
}

/// A node.
#[derive(Debug, Default)]
pub(crate) struct LayoutNode {
    /// The byte offset in the file, for messages.
    pub at: u32,
    /// The file's id, unique among nodes.
    pub id: String,
    /// Metres; x to the east, y to the north. `None` if the file has none that can be used, which
    /// the reader has reported as an error: so references to the node are no errors of their own.
    pub position: Option<DVec2>,
    /// Radians; `None` if the file gives no heading, or allows any.
    pub heading: Option<f64>,
    pub role: Role,
    pub tags: Tags,
}

/// A directed edge.
#[derive(Debug, Default)]
pub(crate) struct LayoutEdge {
    /// The byte offset in the file, for messages.
    pub at: u32,
    /// The file's id, unique among edges.
    pub id: String,
    /// The ids of nodes.
    pub origin: String,
    pub destination: String,
    pub shape: Shape,
    /// Metres per second from origin to destination; `None` if the file gives no speed.
    pub speed: Option<f64>,
    /// Metres per second in reverse gear from destination to origin; `None` if that isn't allowed.
    pub reverse_speed: Option<f64>,
    pub orientation: Orientation,
    pub rotation: Ends<Rotation>,
    pub tags: Tags,
}

/// The shape of an edge.
#[derive(Debug, Default)]
pub(crate) enum Shape {
    /// The straight segment between its nodes.
    #[default]
    Straight,
    /// Cubics end to end, at least one, which should start and end at its nodes.
    Cubics(Vec<CubicBezier>),
}

/// A place where robots pick, drop, charge or park.
#[derive(Debug, Default)]
pub(crate) struct LayoutStation {
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

/// A zone with a rule. Its members are also all nodes and edges whose tags name it.
#[derive(Debug)]
pub(crate) struct LayoutZone {
    /// The byte offset in the file, for messages.
    pub at: u32,
    /// The name, unique among zones.
    pub name: String,
    pub rule: ZoneRule,
    /// Indices of nodes.
    pub nodes: Vec<usize>,
    /// Indices of edges.
    pub edges: Vec<usize>,
}

/// A door.
#[derive(Debug)]
pub(crate) struct LayoutDoor {
    /// The byte offset in the file, for messages.
    pub at: u32,
    /// The name, unique among doors.
    pub name: String,
    /// Indices of edges.
    pub edges: Vec<usize>,
    /// Its ends, in metres.
    pub line: Option<[DVec2; 2]>,
    pub times: RawDoorTimes,
}

/// A lift.
#[derive(Debug)]
pub(crate) struct LayoutLift {
    /// The byte offset in the file, for messages.
    pub at: u32,
    /// The name, unique among lifts.
    pub name: String,
    /// Indices of the nodes in the cabin, from the lowest level to the highest.
    pub nodes: Vec<usize>,
    /// Angles are in radians.
    pub cabin: Option<Cabin>,
    pub door_times: RawDoorTimes,
    /// Seconds from a level to the next.
    pub level_secs: Option<f64>,
    /// The name of the level where it stands at the beginning.
    pub home: Option<String>,
}

/// The speed in metres per second of edges without a speed in the file.
pub(crate) const DEFAULT_SPEED: f64 = 1.0;

impl Layout {
    /// Numbers nodes and edges. If all ids are numbers, they are kept. Otherwise nodes and edges
    /// are numbered from 1 in the order of the file, and the ids become names. Nodes at one place
    /// that an edge without length joins become one.
    pub fn into_raw(mut self, report: &mut Report<'_>) -> RawGraph {
        let node_ids = Numbering::new(
            self.nodes.iter().map(|node| (node.at, node.id.as_str())),
            "node",
            report,
        );
        let edge_ids = Numbering::new(
            self.edges.iter().map(|edge| (edge.at, edge.id.as_str())),
            "edge",
            report,
        );
        let (mut ends, mut stations) = self.resolve(&node_ids);
        self.report_unknown(&ends, &stations, report);
        let kept = joined::join(&mut self, &mut ends, &mut stations, report);
        let edges_kept = self.edges.iter().zip(&kept.edges).filter(|(_, is_kept)| **is_kept);
        warn_of_unknown_speeds(edges_kept.map(|(edge, _)| edge), report);
        let headings = self.headings(&ends);
        let nodes = self.nodes.into_iter().zip(&headings).enumerate();
        let nodes = nodes
            .filter(|(index, _)| kept.nodes[*index])
            .map(|(index, (node, &heading))| raw_node(node, heading, node_ids.number(index)));
        let edges = self.edges.into_iter().zip(ends).enumerate();
        let edges = edges
            .filter(|(index, _)| kept.edges[*index])
            .map(|(index, (edge, ends))| raw_edge(edge, edge_ids.number(index), ends, &node_ids));
        let stations = self.stations.into_iter().zip(stations);
        let stations = stations.map(|(station, nodes)| raw_station(station, &nodes, &node_ids));
        let zones = self.zones.into_iter().map(|zone| RawZone {
            at: zone.at,
            name: zone.name,
            rule: zone.rule,
            nodes: zone.nodes.iter().map(|&index| node_ids.number(index).number).collect(),
            edges: zone.edges.iter().map(|&index| edge_ids.number(index).number).collect(),
        });
        let doors = self.doors.into_iter().map(|door| RawDoor {
            at: door.at,
            name: door.name,
            edges: door.edges.iter().map(|&index| edge_ids.number(index).number).collect(),
            line: door.line,
            times: door.times,
        });
        let lifts = self.lifts.into_iter().map(|lift| RawLift {
            at: lift.at,
            name: lift.name,
            nodes: lift.nodes.iter().map(|&index| node_ids.number(index).number).collect(),
            cabin: lift.cabin,
            door_times: lift.door_times,
            level_secs: lift.level_secs,
            capacity: None,
            home: lift.home,
        });
        RawGraph {
            nodes: nodes.collect(),
            edges: edges.collect(),
            stations: stations.collect(),
            zones: zones.collect(),
            doors: doors.collect(),
            lifts: lifts.collect(),
            background: self.background,
            is_angle_unit_known: !self.has_doubtful_angles,
            is_imported: true,
            ..RawGraph::default()
        }
    }

    /// Reports the references of edges and stations to nodes that don't exist.
    fn report_unknown(
        &self,
        ends: &[EndIndices],
        stations: &[Vec<Option<usize>>],
        report: &mut Report<'_>,
    ) {
        if ends.iter().flatten().any(Option::is_none) {
            self.report_unknown_ends(ends, report);
        }
        for (station, nodes) in self.stations.iter().zip(stations) {
            report_unknown_nodes(station, nodes, report);
        }
    }

    /// Reports the ends of edges that no node has.
    fn report_unknown_ends(&self, ends: &[EndIndices], report: &mut Report<'_>) {
        let mut named: BTreeMap<&str, usize> = BTreeMap::new();
        for name in self.nodes.iter().filter_map(|node| node.tags.name.as_deref()) {
            *named.entry(name).or_default() += 1;
        }
        for (edge, ends) in self.edges.iter().zip(ends) {
            let ids = [(&edge.origin, "starts at"), (&edge.destination, "ends at")];
            for (_, (id, which)) in ends.iter().zip(ids).filter(|(index, _)| index.is_none()) {
                let fault = match named.get(id.as_str()) {
                    None | Some(1) => "which doesn't exist: add it or correct the id",
                    Some(_) => "a name that several nodes have: give the id of one",
                };
                let (name, node) = (shorten(&edge.id), shorten(id));
                report.file_error(edge.at, format!("edge `{name}` {which} node `{node}`, {fault}"));
            }
        }
    }

    /// Returns the nodes at the ends of each edge and those of each station, by index; `None` for
    /// those that don't exist.
    fn resolve(&self, numbering: &Numbering) -> (Vec<EndIndices>, Vec<Vec<Option<usize>>>) {
        let index = Index::new(&self.nodes, numbering);
        let ends = self
            .edges
            .iter()
            .map(|edge| [&edge.origin, &edge.destination].map(|id| index.find(id)));
        let stations = self
            .stations
            .iter()
            .map(|station| station.nodes.iter().map(|id| index.find(id)).collect());
        (ends.collect(), stations.collect())
    }

    /// Returns the headings of all nodes. A node without a heading in the file gets that of the
    /// first edge that starts there, or else of the first edge that ends there.
    fn headings(&self, ends: &[EndIndices]) -> Vec<f64> {
        let mut headings: Vec<Option<f64>> = self.nodes.iter().map(|node| node.heading).collect();
        for which in [0, 1] {
            for (edge, ends) in self.edges.iter().zip(ends) {
                let &[Some(origin), Some(destination)] = ends else { continue };
                let heading = &mut headings[[origin, destination][which]];
                if heading.is_none() {
                    let [from, to] = [origin, destination].map(|node| self.nodes[node].position);
                    let tangents =
                        from.zip(to).and_then(|(from, to)| edge.shape.tangents([from, to]));
                    *heading = tangents
                        .map(|tangents| edge.orientation.heading(tangents[which].to_angle()));
                }
            }
        }
        headings.into_iter().map(Option::unwrap_or_default).collect()
    }
}

/// The indices of the nodes at an edge's origin and destination; `None` if they don't exist.
type EndIndices = [Option<usize>; 2];

impl Shape {
    /// Returns the shape in the opposite direction.
    pub fn reversed(&self) -> Self {
        match self {
            Self::Straight => Self::Straight,
            Self::Cubics(cubics) => {
                Self::Cubics(cubics.iter().rev().map(CubicBezier::reversed).collect())
            }
        }
    }

    /// Returns the tangents at origin and destination, whose positions are given; `None` for a
    /// curve without cubics.
    fn tangents(&self, [origin, destination]: [DVec2; 2]) -> Option<[DVec2; 2]> {
        let path = match self {
            Self::Straight => CubicBezier::straight(origin, destination).into(),
            Self::Cubics(cubics) => Path::from_cubics(cubics)?,
        };
        Some([path.start_tangent(), path.end_tangent()])
    }
}

/// Returns tags with the file's id as their name, unless the id is the number. Another name becomes
/// a property, by which nodes are found, too.
fn tags_with_id(mut tags: Tags, id: &str, number: Number) -> Option<Box<Tags>> {
    if !number.is_id
        && let Some(name) = tags.name.replace(id.into()).filter(|name| **name != *id)
    {
        tags.set(NAME, &name);
    }
    tags.boxed()
}

fn raw_node(node: LayoutNode, heading: f64, number: Number) -> RawNode {
    RawNode {
        at: node.at,
        id: Some(number.number),
        x: node.position.map(|position| position.x),
        y: node.position.map(|position| position.y),
        theta: Some(heading),
        has_heading: node.heading.is_some(),
        body_heading: None,
        role: node.role,
        tags: tags_with_id(node.tags, &node.id, number),
    }
}

fn raw_edge(edge: LayoutEdge, number: Number, ends: EndIndices, nodes: &Numbering) -> RawEdge {
    let [origin, destination] = ends.map(|index| index.map(|index| nodes.number(index).number));
    RawEdge {
        at: edge.at,
        id: Some(number.number),
        origin,
        destination,
        curve: Some(match edge.shape {
            Shape::Straight => RawCurve::Linear,
            Shape::Cubics(cubics) => RawCurve::Cubics(cubics),
        }),
        forward: None,
        backward: None,
        speed: Some(edge.speed.unwrap_or(DEFAULT_SPEED)),
        reverse_speed: Some(edge.reverse_speed.unwrap_or(0.0)),
        orientation: edge.orientation,
        rotation: edge.rotation,
        tags: tags_with_id(edge.tags, &edge.id, number),
    }
}

fn report_unknown_nodes(
    station: &LayoutStation,
    indices: &[Option<usize>],
    report: &mut Report<'_>,
) {
    for (id, _) in station.nodes.iter().zip(indices).filter(|(_, index)| index.is_none()) {
        let (name, node) = (shorten(&station.name), shorten(id));
        let message = format!("station `{name}` names node `{node}`, which doesn't exist: ignored");
        report.file_warning(station.at, message);
    }
}

fn raw_station(station: LayoutStation, indices: &[Option<usize>], nodes: &Numbering) -> RawStation {
    RawStation {
        at: station.at,
        nodes: indices.iter().flatten().map(|&index| nodes.number(index).number).collect(),
        name: station.name,
        role: station.role,
        position: station.position,
        properties: station.properties,
    }
}

fn warn_of_unknown_speeds<'a>(
    edges: impl Iterator<Item = &'a LayoutEdge>,
    report: &mut Report<'_>,
) {
    // A speed may be missing because it is wrong, which has been reported.
    if report.has_errors() {
        return;
    }
    let mut unknown = edges.filter(|edge| edge.speed.is_none());
    let Some(first) = unknown.next() else { return };
    let others = unknown.count();
    let who = if others == 0 {
        format!("edge `{}` has", shorten(&first.id))
    } else {
        format!("{} edges have", others + 1)
    };
    let message =
        format!("{who} no speed limit: {DEFAULT_SPEED} m/s is used; robot types limit it further");
    report.assumption(first.at, message);
}
