//! Validates the content of a file: returns a [`RouteGraph`], or reports every error.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use glam::DVec2;

use super::bezier::CubicBezier;
use super::finding::{Report, Subject};
use super::item::{RawCurve, RawEdge, RawNode};
use super::route_graph::{Edge, Node, NodeIndex, RouteGraph};
use super::spline::{HandleLengths, Handles, normalize_angle, spline};
use super::yaml::RawGraph;

/// The largest |x| or |y| in metres: beyond it the `f32` poses in frames are coarser than half a millimetre.
pub const MAX_COORDINATE: f64 = 8000.0;

/// The largest speed in metres per second.
pub const MAX_SPEED: f64 = 50.0;

/// The least length of an edge in metres.
pub const MIN_LENGTH: f64 = 0.001;

/// The largest accepted angle in the file's unit: a hundred turns in degrees.
const MAX_ANGLE: f64 = 36_000.0;

/// Returns the graph if every number and every reference in `raw` is valid, with nodes and edges in the order of `raw`.
pub(super) fn validate(raw: &RawGraph, handles: Handles, report: &mut Report<'_>) -> Option<RouteGraph> {
    reject_empty(raw, report);
    let by_id = index_nodes(raw, report);
    let nodes: Vec<Option<Node>> = raw.nodes.iter().map(|node| check_node(node, raw.degrees, report)).collect();
    warn_of_degrees(raw, report);
    reject_duplicate_edges(raw, report);
    let edges: Vec<Option<Edge>> =
        raw.edges.iter().map(|edge| EdgeCheck { edge, report }.check(&by_id, &nodes, handles)).collect();
    if report.has_errors() {
        return None;
    }
    let nodes = nodes.into_iter().collect::<Option<_>>()?;
    Some(RouteGraph::from_valid_parts(nodes, edges.into_iter().collect::<Option<_>>()?))
}

fn reject_empty(raw: &RawGraph, report: &mut Report<'_>) {
    if raw.nodes.is_empty() {
        report.error(0, Subject::File, "has no nodes: list them under Vertices");
    }
    if raw.edges.is_empty() {
        report.error(0, Subject::File, "has no edges: list them under Edges");
    }
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
    let message =
        format!("the {} in line {} has the same Id: give each a unique Id", subject.kind(), report.line(first));
    report.error(at, subject, message);
}

fn check_node(raw: &RawNode, degrees: bool, report: &mut Report<'_>) -> Option<Node> {
    let subject = Subject::Node(raw.id);
    for (name, value) in [("X", raw.x), ("Y", raw.y)] {
        if let Some(value) = value.filter(|value| value.abs() > MAX_COORDINATE) {
            let message = format!(
                "{name} is {value} m, beyond ±{MAX_COORDINATE} m, the range in which poses are precise: \
                 shift the map's origin, and check that the unit is metres"
            );
            report.error(raw.at, subject, message);
        }
    }
    let theta = raw.theta?;
    if theta.abs() > MAX_ANGLE {
        report.error(raw.at, subject, format!("Theta is {theta}: give a heading in radians, or `AngleUnit: deg`"));
        return None;
    }
    let theta = normalize_angle(if degrees { theta.to_radians() } else { theta });
    Some(Node { id: raw.id?, position: DVec2::new(raw.x?, raw.y?), theta })
}

/// Warns of headings of more than a full turn in radians, which are probably in degrees.
fn warn_of_degrees(raw: &RawGraph, report: &mut Report<'_>) {
    let suspect = |node: &&RawNode| node.theta.is_some_and(|theta| theta.abs() > 2.0 * PI + 0.01);
    let mut suspects = raw.nodes.iter().filter(suspect);
    let Some(first) = suspects.next().filter(|_| !raw.degrees) else { return };
    let others = match suspects.count() {
        0 => String::new(),
        more => format!(" (and {more} more nodes)"),
    };
    let message = format!(
        "Theta is {}, more than a full turn{others}: if the angles are in degrees, add `AngleUnit: deg` to the file",
        first.theta.unwrap_or_default()
    );
    report.warning(first.at, Subject::Node(first.id), message);
}

struct EdgeCheck<'a, 'r, 'text> {
    edge: &'a RawEdge,
    report: &'r mut Report<'text>,
}

impl EdgeCheck<'_, '_, '_> {
    fn check(mut self, by_id: &BTreeMap<u32, NodeIndex>, nodes: &[Option<Node>], handles: Handles) -> Option<Edge> {
        let edge = self.edge;
        let origin = self.node(by_id, edge.origin, "Origin_ID");
        let destination = self.node(by_id, edge.destination, "Destination_ID");
        let velocity_forward = self.forward_speed();
        let velocity_backwards = self.backward_speed();
        let forward = self.handle_length(edge.forward, "ParamF");
        let backward = self.handle_length(edge.backward, "ParamB");
        let (origin, destination) = (origin?, destination?);
        if origin == destination {
            self.error("starts and ends at the same node: give it two different nodes");
            return None;
        }
        let (from, to) = (nodes[origin.0 as usize].as_ref()?, nodes[destination.0 as usize].as_ref()?);
        let curve = match edge.curve? {
            RawCurve::Linear => CubicBezier::straight(from.position, to.position),
            RawCurve::Spline => spline(from, to, HandleLengths { forward: forward?, backward: backward? }, handles),
        };
        let curve = self.curve(from, to, curve)?;
        Some(Edge {
            id: edge.id?,
            origin,
            destination,
            curve,
            velocity_forward: velocity_forward?,
            velocity_backwards: velocity_backwards?,
        })
    }

    fn node(&mut self, by_id: &BTreeMap<u32, NodeIndex>, id: Option<u32>, key: &str) -> Option<NodeIndex> {
        let found = by_id.get(&id?).copied();
        if found.is_none() {
            self.error(format!("{key} is {}, but no node has that Id: add the node or correct the id", id?));
        }
        found
    }

    fn forward_speed(&mut self) -> Option<f64> {
        let speed = self.edge.velocity_forward?;
        if speed > 0.0 && speed <= MAX_SPEED {
            return Some(speed);
        }
        self.error(format!("VelocityForward is {speed}: it must be above 0 and at most {MAX_SPEED} m/s"));
        None
    }

    fn backward_speed(&mut self) -> Option<Option<f64>> {
        let speed = self.edge.velocity_backwards?;
        if (0.0..=MAX_SPEED).contains(&speed) {
            return Some((speed > 0.0).then_some(speed));
        }
        self.error(format!(
            "VelocityBackwards is {speed}: it must be 0 (not driven in reverse) or up to {MAX_SPEED} m/s"
        ));
        None
    }

    fn curve(&mut self, from: &Node, to: &Node, curve: CubicBezier) -> Option<CubicBezier> {
        if curve.control_points.iter().any(|point| point.abs().max_element() > MAX_COORDINATE) {
            self.error(format!("its handles extend beyond ±{MAX_COORDINATE} m: shorten ParamF and ParamB"));
            return None;
        }
        if from.position.distance(to.position) < MIN_LENGTH && curve.length() < MIN_LENGTH {
            self.error("has no length: its nodes are at the same position");
            return None;
        }
        Some(curve)
    }

    fn handle_length(&mut self, length: Option<f64>, name: &str) -> Option<f64> {
        let length = length?;
        if (0.0..=2.0 * MAX_COORDINATE).contains(&length) {
            return Some(length);
        }
        self.error(format!("{name} is {length}: it must be 0 to {} m", 2.0 * MAX_COORDINATE));
        None
    }

    fn error(&mut self, message: impl Into<String>) {
        self.report.error(self.edge.at, Subject::Edge(self.edge.id), message);
    }
}
