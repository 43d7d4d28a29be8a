//! Validates the content of a file: returns a [`RouteGraph`], or reports every error.

use std::collections::BTreeMap;

use glam::DVec2;
use regatta_base::bezier::CubicBezier;
use regatta_base::graph::NodeIndex;

use super::angles::warn_of_degrees;
use super::body_heading;
use super::facilities::{check_doors, check_lifts};
use super::zones::check_zones;
use crate::model::angle::normalize_angle;
use crate::model::finding::{Report, Severity, Subject};
use crate::model::path::Path;
use crate::model::raw::{RawCurve, RawEdge, RawGraph, RawNode, RawStation};
use crate::model::route_graph::{Edge, Node, RouteGraph};
use crate::model::spline::{HandleLengths, Handles, spline};
use crate::model::tags::{BackgroundLine, Orientation, Station};
use crate::model::value::{plural, shorten};

/// The largest |x| or |y| in metres. Beyond it, the `f32` poses in frames are coarser than half a
/// millimetre.
pub const MAX_COORDINATE: f64 = 8000.0;

/// The largest extent in metres, which leaves room to round the origin.
pub const MAX_EXTENT: f64 = 2.0 * MAX_COORDINATE - 1000.0;

/// Of so many nodes, at most one may be far from the others as its position is wrong.
const MAX_OUTLIERS: usize = 3;

/// The largest speed in metres per second.
pub const MAX_SPEED: f64 = 50.0;

/// The least length of an edge in metres.
pub const MIN_LENGTH: f64 = 0.001;

/// The distance in metres below which the end of a curve counts as at its node: a tenth of the
/// error of a pose.
pub(crate) const MAX_GAP: f64 = 1e-4;

/// The largest accepted angle in the file's unit: a hundred turns in degrees.
const MAX_ANGLE: f64 = 36_000.0;

/// Returns the graph if every number and every reference in `raw` is valid, with nodes and edges in
/// the order of `raw`.
pub(crate) fn validate(
    raw: &RawGraph,
    handles: Handles,
    report: &mut Report<'_>,
) -> Option<RouteGraph> {
    reject_empty(raw, report);
    let origin = origin(raw);
    let by_id = index_nodes(raw, report);
    let nodes: Vec<Option<Node>> = raw
        .nodes
        .iter()
        .map(|node| NodeCheck { node, report }.check(origin, raw.degrees))
        .collect();
    warn_of_degrees(raw, report);
    reject_duplicate_edges(raw, report);
    let mut edges: Vec<Option<Edge>> = raw
        .edges
        .iter()
        .map(|edge| {
            let names = if raw.is_imported { SPEEDS } else { OWN_SPEEDS };
            let check = EdgeCheck { edge, origin, degrees: raw.degrees, names, report };
            check.check(&by_id, &nodes, handles)
        })
        .collect();
    if report.has_errors() {
        return None;
    }
    body_heading::orient(raw, &mut edges, report);
    let nodes = nodes.into_iter().collect::<Option<_>>()?;
    let stations = check_stations(&raw.stations, &by_id, origin, report)?;
    let background = background(&raw.background, origin, report);
    let graph = RouteGraph::from_valid_parts(nodes, edges.into_iter().collect::<Option<_>>()?);
    let zones = check_zones(&raw.zones, &graph, report)?;
    let doors = check_doors(&raw.doors, &graph, origin, report);
    let lifts = check_lifts(raw, &graph, origin, report);
    let graph = graph.with_origin(origin).with_surroundings(stations, background).with_zones(zones);
    (!report.has_errors()).then(|| graph.with_facilities(doors, lifts))
}

/// Returns (0, 0), or the middle of the nodes in whole kilometres if some are too far from (0, 0)
/// for precise poses.
fn origin(raw: &RawGraph) -> DVec2 {
    let positions = raw.nodes.iter().filter_map(|node| Some(DVec2::new(node.x?, node.y?)));
    let (min, max) = positions
        .fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(min, max), at| (min.min(at), max.max(at)));
    let farthest = min.abs().max(max.abs()).max_element();
    let extent = (max - min).max_element();
    if farthest <= MAX_COORDINATE || !farthest.is_finite() {
        return DVec2::ZERO;
    }
    if extent > MAX_EXTENT {
        return origin_of_most(raw).unwrap_or(DVec2::ZERO);
    }
    in_kilometres((min + max) / 2.0)
}

/// Returns the origin of the nodes without a few whose positions are wrong, if there are such.
fn origin_of_most(raw: &RawGraph) -> Option<DVec2> {
    let mut x: Vec<f64> = raw.nodes.iter().filter_map(|node| node.x).collect();
    let mut y: Vec<f64> = raw.nodes.iter().filter_map(|node| node.y).collect();
    x.sort_by(f64::total_cmp);
    y.sort_by(f64::total_cmp);
    let middle = in_kilometres(DVec2::new(*x.get(x.len() / 2)?, *y.get(y.len() / 2)?));
    let far = raw.nodes.iter().filter(|node| is_outlier(node, middle)).count();
    (middle != DVec2::ZERO && MAX_OUTLIERS * far <= raw.nodes.len()).then_some(middle)
}

fn is_outlier(node: &RawNode, middle: DVec2) -> bool {
    let (Some(x), Some(y)) = (node.x, node.y) else { return false };
    (DVec2::new(x, y) - middle).abs().max_element() > MAX_COORDINATE
}

/// Rounds a position to whole kilometres.
fn in_kilometres(position: DVec2) -> DVec2 {
    (position / 1000.0).round() * 1000.0
}

/// Returns the lines of the background that are near enough to be drawn, and reports the others.
fn background(
    raw: &[BackgroundLine],
    origin: DVec2,
    report: &mut Report<'_>,
) -> Vec<BackgroundLine> {
    let lines = raw.iter().map(|line| BackgroundLine {
        points: line.points.iter().map(|point| *point - origin).collect(),
        level: line.level.clone(),
    });
    let near = lines.filter(|line| line.points.iter().all(|point| is_near(*point)));
    let near: Vec<_> = near.collect();
    let far = plural(raw.len() - near.len(), "line");
    if near.len() < raw.len() {
        let message = format!(
            "{far} of the background beyond ±{MAX_EXTENT} m: not drawn; check that the unit is \
             metres"
        );
        report.file_warning(0, message);
    }
    near
}

fn is_near(point: DVec2) -> bool {
    point.abs().max_element() <= MAX_EXTENT
}

fn check_stations(
    raw: &[RawStation],
    by_id: &BTreeMap<u32, NodeIndex>,
    origin: DVec2,
    report: &mut Report<'_>,
) -> Option<Vec<Station>> {
    let mut names = BTreeMap::new();
    let mut stations = Vec::with_capacity(raw.len());
    for station in raw {
        if let Some(first) = names.insert(station.name.as_str(), station.at) {
            let message = format!(
                "station `{}` is also in line {}: give each a unique name",
                shorten(&station.name),
                report.line(first)
            );
            report.error(station.at, Subject::File, message);
        }
        for id in station.nodes.iter().filter(|id| !by_id.contains_key(id)) {
            let message = format!(
                "station `{}` names node {id}, which doesn't exist: add the node or correct the id",
                shorten(&station.name)
            );
            report.error(station.at, Subject::File, message);
        }
        stations.push(Station {
            name: station.name.clone(),
            role: station.role,
            nodes: station.nodes.iter().filter_map(|id| by_id.get(id).copied()).collect(),
            position: station.position.map(|position| position - origin),
            properties: station.properties.clone(),
        });
    }
    (!report.has_errors()).then_some(stations)
}

fn reject_empty(raw: &RawGraph, report: &mut Report<'_>) {
    // A reader that finds no content reports the reason itself.
    if report.has_errors() {
        return;
    }
    let message = match (raw.nodes.is_empty(), raw.edges.is_empty(), raw.is_imported) {
        (false, false, _) => return,
        (true, _, true) => {
            "the layout has no nodes: there is nothing to drive on; check that this is the right \
             file"
        }
        (false, true, true) => "the layout has no edges: add connections between its nodes",
        (true, true, false) => "has no nodes and no edges: list them under Vertices and Edges",
        (true, false, false) => "has no nodes: list them under Vertices",
        (false, true, false) => "has no edges: list them under Edges",
    };
    report.error(0, Subject::File, message);
}

fn index_nodes(raw: &RawGraph, report: &mut Report<'_>) -> BTreeMap<u32, NodeIndex> {
    let mut by_id = BTreeMap::new();
    for (index, node) in (0..).zip(&raw.nodes) {
        let Some(id) = node.id else { continue };
        if let Some(NodeIndex(first)) = by_id.insert(id, NodeIndex(index)) {
            duplicate(report, Subject::Node(Some(id)), node.at, raw.nodes[first as usize].at);
        }
    }
    by_id
}

fn reject_duplicate_edges(raw: &RawGraph, report: &mut Report<'_>) {
    let mut offsets = BTreeMap::new();
    for edge in &raw.edges {
        let Some(id) = edge.id else { continue };
        if let Some(first) = offsets.insert(id, edge.at) {
            duplicate(report, Subject::Edge(Some(id)), edge.at, first);
        }
    }
}

fn duplicate(report: &mut Report<'_>, subject: Subject, at: u32, first: u32) {
    let message = format!(
        "the {} in line {} has the same Id: give each a unique Id",
        subject.kind(),
        report.line(first)
    );
    report.error(at, subject, message);
}

struct NodeCheck<'a, 'r, 'text> {
    node: &'a RawNode,
    report: &'r mut Report<'text>,
}

impl NodeCheck<'_, '_, '_> {
    fn check(mut self, origin: DVec2, degrees: bool) -> Option<Node> {
        let raw = self.node;
        self.coordinate("X", raw.x, origin.x);
        self.coordinate("Y", raw.y, origin.y);
        if let Some(angle) = raw.body_heading.filter(|angle| angle.abs() > MAX_ANGLE) {
            self.error(&format!(
                "ThetaHolonomic is {angle}: give a heading in radians, or `AngleUnit: deg`"
            ));
        }
        let theta = raw.theta?;
        if theta.abs() > MAX_ANGLE {
            self.error(&format!(
                "Theta is {theta}: give a heading in radians, or `AngleUnit: deg`"
            ));
            return None;
        }
        Some(Node {
            id: raw.id?,
            position: DVec2::new(raw.x?, raw.y?) - origin,
            theta: to_radians(theta, degrees),
            has_heading: raw.has_heading,
            role: raw.role,
            tags: raw.tags.clone(),
        })
    }

    fn coordinate(&mut self, name: &str, value: Option<f64>, origin: f64) {
        let Some(value) = value.filter(|value| (value - origin).abs() > MAX_COORDINATE) else {
            return;
        };
        let message = match origin == 0.0 {
            true => format!(
                "{name} is {value} m, beyond ±{MAX_COORDINATE} m, and the graph is wider than \
                 {MAX_EXTENT} m, the range in which poses are precise: check that the unit is \
                 metres, or split the graph"
            ),
            false => format!(
                "{name} is {value} m, more than {MAX_COORDINATE} m from {origin} m, where most \
                 nodes are: correct the node's position, or remove the node"
            ),
        };
        self.error(&message);
    }

    fn error(&mut self, message: &str) {
        self.node.report(Severity::Error, message, self.report);
    }
}

/// Converts an angle of the file to radians in (-π, π].
pub(super) fn to_radians(angle: f64, degrees: bool) -> f64 {
    normalize_angle(if degrees { angle.to_radians() } else { angle })
}

struct EdgeCheck<'a, 'r, 'text> {
    edge: &'a RawEdge,
    /// Of the graph, in metres.
    origin: DVec2,
    /// Whether angles are in degrees.
    degrees: bool,
    /// The names in messages of its speed and its speed in reverse gear.
    names: [&'static str; 2],
    report: &'r mut Report<'text>,
}

const SPEEDS: [&str; 2] = ["its speed", "its speed in reverse gear"];
const OWN_SPEEDS: [&str; 2] = ["VelocityForward", "VelocityBackwards"];

impl EdgeCheck<'_, '_, '_> {
    fn check(
        mut self,
        by_id: &BTreeMap<u32, NodeIndex>,
        nodes: &[Option<Node>],
        handles: Handles,
    ) -> Option<Edge> {
        let edge = self.edge;
        let origin = self.node(by_id, edge.origin, "Origin_ID");
        let destination = self.node(by_id, edge.destination, "Destination_ID");
        let speed = self.forward_speed();
        let reverse_speed = self.backward_speed();
        let forward = self.handle_length(edge.forward, "ParamF");
        let backward = self.handle_length(edge.backward, "ParamB");
        let orientation = self.orientation();
        let (origin, destination) = (origin?, destination?);
        if origin == destination {
            self.error("starts and ends at the same node: give it two different nodes");
            return None;
        }
        let (from, to) =
            (nodes[origin.0 as usize].as_ref()?, nodes[destination.0 as usize].as_ref()?);
        let path = match edge.curve.as_ref()? {
            RawCurve::Linear => CubicBezier::straight(from.position, to.position).into(),
            RawCurve::Spline => {
                spline(from, to, HandleLengths { forward: forward?, backward: backward? }, handles)
                    .into()
            }
            RawCurve::Cubics(cubics) => self.connected(from, to, cubics)?,
        };
        let path = self.path(from, to, path)?;
        Some(Edge {
            id: edge.id?,
            origin,
            destination,
            path,
            speed: speed?,
            reverse_speed: reverse_speed?,
            orientation: orientation?,
            rotation: edge.rotation,
            tags: edge.tags.clone(),
        })
    }

    fn node(
        &mut self,
        by_id: &BTreeMap<u32, NodeIndex>,
        id: Option<u32>,
        key: &str,
    ) -> Option<NodeIndex> {
        let found = by_id.get(&id?).copied();
        if found.is_none() {
            self.error(&format!(
                "{key} is {}, but no node has that Id: add the node or correct the id",
                id?
            ));
        }
        found
    }

    fn orientation(&mut self) -> Option<Orientation> {
        let orientation = self.edge.orientation;
        if let Some(angle) = orientation.angle().filter(|angle| angle.abs() > MAX_ANGLE) {
            self.error(&format!("its heading is {angle}: give it in radians, or `AngleUnit: deg`"));
            return None;
        }
        match orientation.map(|angle| to_radians(angle, self.degrees)) {
            Orientation::Offset(0.0) => Some(Orientation::Tangential),
            orientation => Some(orientation),
        }
    }

    fn forward_speed(&mut self) -> Option<f64> {
        let speed = self.edge.speed?;
        if speed > 0.0 && speed <= MAX_SPEED {
            return Some(speed);
        }
        self.error(&format!(
            "{} is {speed} m/s: it must be above 0 and at most {MAX_SPEED} m/s",
            self.names[0]
        ));
        None
    }

    fn backward_speed(&mut self) -> Option<Option<f64>> {
        let speed = self.edge.reverse_speed?;
        if (0.0..=MAX_SPEED).contains(&speed) {
            return Some((speed > 0.0).then_some(speed));
        }
        self.error(&format!(
            "{} is {speed} m/s: it must be 0 (not driven in reverse) or up to {MAX_SPEED} m/s",
            self.names[1]
        ));
        None
    }

    /// Joins the cubics of a file. Straight segments fill the gaps between the cubics and the
    /// nodes.
    fn connected(&mut self, from: &Node, to: &Node, cubics: &[CubicBezier]) -> Option<Path> {
        let mut joined: Vec<CubicBezier> = Vec::with_capacity(cubics.len());
        let mut at = from.position;
        for cubic in cubics {
            let mut control_points = cubic.control_points.map(|point| point - self.origin);
            self.close_gap(at, &mut control_points[0], &mut joined);
            at = control_points[3];
            joined.push(CubicBezier { control_points });
        }
        let mut end = to.position;
        self.close_gap(at, &mut end, &mut joined);
        if let Some(last) = joined.last_mut() {
            last.control_points[3] = to.position;
        }
        let path = Path::from_cubics(&joined);
        if path.is_none() {
            self.error("has no control points: give at least four");
        }
        path
    }

    /// Moves the start of a curve to the end of the previous curve, or adds a straight segment if
    /// the gap is too large.
    fn close_gap(&mut self, from: DVec2, to: &mut DVec2, joined: &mut Vec<CubicBezier>) {
        let gap = from.distance(*to);
        if gap <= MAX_GAP {
            *to = from;
            return;
        }
        joined.push(CubicBezier::straight(from, *to));
        let message = format!(
            "its curve has a gap of {gap:.3} m, or doesn't begin or end at its node: a straight \
             segment is added"
        );
        self.edge.report(Severity::Warning, &message, self.report);
    }

    fn path(&mut self, from: &Node, to: &Node, path: Path) -> Option<Path> {
        if path
            .control_points()
            .any(|point| !point.is_finite() || point.abs().max_element() > MAX_COORDINATE)
        {
            let hint = if path.single().is_some() { ": shorten ParamF and ParamB" } else { "" };
            self.error(&format!("its control points extend beyond ±{MAX_COORDINATE} m{hint}"));
            return None;
        }
        if from.position.distance(to.position) < MIN_LENGTH && path.length() < MIN_LENGTH {
            self.error("has no length: its nodes are at the same position; make them one node");
            return None;
        }
        Some(path)
    }

    fn handle_length(&mut self, length: Option<f64>, name: &str) -> Option<f64> {
        let length = length?;
        if (0.0..=2.0 * MAX_COORDINATE).contains(&length) {
            return Some(length);
        }
        self.error(&format!("{name} is {length}: it must be 0 to {} m", 2.0 * MAX_COORDINATE));
        None
    }

    fn error(&mut self, message: &str) {
        self.edge.report(Severity::Error, message, self.report);
    }
}
