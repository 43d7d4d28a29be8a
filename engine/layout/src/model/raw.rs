//! A graph as a file describes it, before validation: nodes, edges, stations and zones.

use std::collections::BTreeMap;

use glam::DVec2;
use regatta_base::bezier::CubicBezier;
use regatta_base::graph::{Ends, Rotation};

use super::facilities::Cabin;
use super::finding::{Report, Severity, Subject};
use super::spline::Handles;
use super::tags::{BackgroundLine, Orientation, Role, Tags};
use super::value::shorten;
use super::zones::ZoneRule;

/// The content of a file. A field is `None` if its value is missing or has the wrong type. Readers
/// report both.
#[derive(Debug, Default)]
pub(crate) struct RawGraph {
    pub nodes: Vec<RawNode>,
    pub edges: Vec<RawEdge>,
    pub stations: Vec<RawStation>,
    pub zones: Vec<RawZone>,
    pub doors: Vec<RawDoor>,
    pub lifts: Vec<RawLift>,
    /// Lines that are drawn behind the graph, in metres.
    pub background: Vec<BackgroundLine>,
    pub handles: Option<Handles>,
    /// Whether angles are in degrees, and not in radians.
    pub degrees: bool,
    /// Whether the file, or its format, gives the unit of angles. Otherwise they are read as
    /// radians.
    pub is_angle_unit_known: bool,
    /// Whether the graph was made from a layout of another format.
    pub is_imported: bool,
}

/// A node as written in the file: its numbers are finite, but may be out of range.
#[derive(Debug)]
pub(crate) struct RawNode {
    /// The byte offset of its first key.
    pub at: u32,
    pub id: Option<u32>,
    pub x: Option<f64>,
    pub y: Option<f64>,
    pub theta: Option<f64>,
    /// Whether the file gives `theta`.
    pub has_heading: bool,
    /// The heading of robots at the node, if it differs from that of the curve; in the unit of the
    /// file.
    pub body_heading: Option<f64>,
    pub role: Role,
    pub tags: Option<Box<Tags>>,
}

impl RawGraph {
    /// Returns the angles of nodes and edges, in the unit of the file.
    pub fn angles(&self) -> impl Iterator<Item = f64> + '_ {
        let of_nodes =
            self.nodes.iter().filter(|node| node.has_heading).filter_map(|node| node.theta);
        of_nodes.chain(self.edges.iter().filter_map(|edge| edge.orientation.angle()))
    }

    /// Multiplies all lengths by the metres of their unit.
    pub fn scale(&mut self, unit: f64) {
        for node in &mut self.nodes {
            node.x = node.x.map(|x| x * unit);
            node.y = node.y.map(|y| y * unit);
        }
        for edge in &mut self.edges {
            edge.forward = edge.forward.map(|length| length * unit);
            edge.backward = edge.backward.map(|length| length * unit);
            let Some(RawCurve::Cubics(cubics)) = &mut edge.curve else { continue };
            for point in cubics.iter_mut().flat_map(|cubic| &mut cubic.control_points) {
                *point *= unit;
            }
        }
        for station in &mut self.stations {
            station.position = station.position.map(|position| position * unit);
        }
        for point in self.background.iter_mut().flat_map(|line| &mut line.points) {
            *point *= unit;
        }
        for point in self.doors.iter_mut().flat_map(|door| &mut door.line).flatten() {
            *point *= unit;
        }
        for cabin in self.lifts.iter_mut().flat_map(|lift| &mut lift.cabin) {
            (cabin.centre, cabin.size) = (cabin.centre * unit, cabin.size * unit);
        }
    }
}

impl RawNode {
    /// The position, if both of its coordinates are known.
    pub fn position(&self) -> Option<DVec2> {
        Some(DVec2::new(self.x?, self.y?))
    }

    /// Reports a finding about the node; its message begins with the name if there is one.
    pub fn report(&self, severity: Severity, message: &str, report: &mut Report<'_>) {
        let message = with_name(self.tags.as_deref(), message);
        report.add(severity, self.at, Subject::Node(self.id), message);
    }
}

impl RawEdge {
    /// Reports a finding about the edge; its message begins with the name if there is one.
    pub fn report(&self, severity: Severity, message: &str, report: &mut Report<'_>) {
        let message = with_name(self.tags.as_deref(), message);
        report.add(severity, self.at, Subject::Edge(self.id), message);
    }
}

fn with_name(tags: Option<&Tags>, message: &str) -> String {
    match tags.and_then(|tags| tags.name.as_deref()) {
        None => message.to_owned(),
        Some(name) => format!("`{}`: {message}", shorten(name)),
    }
}

/// An edge as written in the file: its numbers are finite, but may be out of range.
#[derive(Clone, Debug)]
pub(crate) struct RawEdge {
    /// The byte offset of its first key.
    pub at: u32,
    pub id: Option<u32>,
    pub origin: Option<u32>,
    pub destination: Option<u32>,
    pub curve: Option<RawCurve>,
    /// `ParamF` in metres, if given.
    pub forward: Option<f64>,
    /// `ParamB` in metres, if given.
    pub backward: Option<f64>,
    pub speed: Option<f64>,
    /// 0 if not given.
    pub reverse_speed: Option<f64>,
    /// Angles are in the unit of the file.
    pub orientation: Orientation,
    pub rotation: Ends<Rotation>,
    pub tags: Option<Box<Tags>>,
}

/// The shape of an edge.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum RawCurve {
    Linear,
    Spline,
    /// At least one, end to end.
    Cubics(Vec<CubicBezier>),
}

/// A station as written in the file.
#[derive(Debug)]
pub(crate) struct RawStation {
    /// The byte offset of its first key.
    pub at: u32,
    pub name: String,
    pub role: Role,
    /// Ids of nodes.
    pub nodes: Vec<u32>,
    pub position: Option<DVec2>,
    pub properties: BTreeMap<Box<str>, Box<str>>,
}

/// A zone with a rule as written in the file. Its members are also all nodes and edges whose tags
/// name it.
#[derive(Debug)]
pub(crate) struct RawZone {
    /// The byte offset of its first key.
    pub at: u32,
    pub name: String,
    pub rule: ZoneRule,
    /// Ids of nodes.
    pub nodes: Vec<u32>,
    /// Ids of edges.
    pub edges: Vec<u32>,
}

/// The times of a door as written in the file, in seconds; `None` for the default.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct RawDoorTimes {
    pub opening: Option<f64>,
    pub closing: Option<f64>,
}

/// A door as written in the file.
#[derive(Debug)]
pub(crate) struct RawDoor {
    /// The byte offset of its first key.
    pub at: u32,
    pub name: String,
    /// Ids of edges.
    pub edges: Vec<u32>,
    /// Its ends, in metres.
    pub line: Option<[DVec2; 2]>,
    pub times: RawDoorTimes,
}

/// A lift as written in the file.
#[derive(Debug)]
pub(crate) struct RawLift {
    /// The byte offset of its first key.
    pub at: u32,
    pub name: String,
    /// Ids of the nodes in the cabin, from the lowest level to the highest.
    pub nodes: Vec<u32>,
    pub cabin: Option<Cabin>,
    pub door_times: RawDoorTimes,
    /// Seconds from a level to the next.
    pub level_secs: Option<f64>,
    /// The largest number of robots in it.
    pub capacity: Option<u32>,
    /// The name of the level where it stands at the beginning.
    pub home: Option<String>,
}
