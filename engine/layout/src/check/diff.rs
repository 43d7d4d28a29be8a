//! The differences between two route graphs, by the names or ids of their nodes, edges and
//! stations.

mod background;

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

use glam::DVec2;
use regatta_base::bezier::CubicBezier;
use regatta_base::graph::{Ends, Rotation};

use crate::model::angle::normalize_angle;
use crate::model::facilities::{Door, DoorTimes, Lift};
use crate::model::path::Path;
use crate::model::route_graph::{Edge, Node, RouteGraph};
use crate::model::tags::{Orientation, Station, Tags};
use crate::model::value::shorten;
use crate::model::zones::{Zone, ZoneRule};

/// The distance in metres, and the angle in radians, up to which poses count as equal.
const TOLERANCE: f64 = 1e-6;

/// The least distance in metres that is told in metres.
const LEAST_IN_METRES: f64 = 0.01;

/// The least angle in degrees that is told with two decimals.
const LEAST_IN_HUNDREDTHS: f64 = 0.1;

/// The number of intervals of each cubic between the points at which two paths are compared.
const SAMPLES: u32 = 16;

/// A difference between two graphs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference {
    /// The kind.
    pub kind: DifferenceKind,
    /// `node A`, `edge 12`, `station dock` or `background`.
    pub subject: String,
    /// The changes in words; empty unless the kind is [`DifferenceKind::Changed`].
    pub changes: Vec<String>,
}

/// The kind of a [`Difference`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DifferenceKind {
    /// Only the first graph has it.
    Removed,
    /// Only the second graph has it.
    Added,
    /// Both graphs have it, with differences.
    Changed,
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.kind {
            DifferenceKind::Removed => write!(f, "- {}", self.subject),
            DifferenceKind::Added => write!(f, "+ {}", self.subject),
            DifferenceKind::Changed => write!(f, "~ {}: {}", self.subject, self.changes.join(", ")),
        }
    }
}

/// Returns the differences from the first graph to the second: nodes, then edges, stations, zones,
/// doors and lifts, each by name or id, and the lines of the background.
///
/// ```
/// use regatta_layout::check::diff::diff;
/// use regatta_layout::{ReadOptions, parse};
///
/// let text = "id,x,y\nA,0,0\nB,10,0\n\nfrom,to,speed\nA,B,1\n";
/// let (first, _) = parse(text, "first.csv", &ReadOptions::default())?;
/// let (second, _) = parse(&text.replace("B,10", "B,12"), "second.csv", &ReadOptions::default())?;
/// let differences: Vec<String> = diff(&first, &second).iter().map(ToString::to_string).collect();
/// assert_eq!(differences[0], "~ node B: moved by 2.000 m");
/// # Ok::<(), regatta_layout::GraphError>(())
/// ```
pub fn diff(first: &RouteGraph, second: &RouteGraph) -> Vec<Difference> {
    let sides = Sides { first, second };
    let mut found =
        compare("node", first.nodes(), second.nodes(), node_key, |a, b| sides.node_changes(a, b));
    found.extend(compare("edge", first.edges(), second.edges(), edge_key, |a, b| {
        sides.edge_changes(a, b)
    }));
    found.extend(compare("station", first.stations(), second.stations(), station_key, |a, b| {
        sides.station_changes(a, b)
    }));
    found.extend(compare("zone", first.zones(), second.zones(), zone_key, |a, b| {
        sides.zone_changes(a, b)
    }));
    found.extend(compare("door", first.doors(), second.doors(), door_key, |a, b| {
        sides.door_changes(a, b)
    }));
    found.extend(compare("lift", first.lifts(), second.lifts(), lift_key, |a, b| {
        sides.lift_changes(a, b)
    }));
    found.extend(background::difference(first, second));
    found
}

fn compare<T>(
    noun: &str,
    first: &[T],
    second: &[T],
    key: impl Fn(&T) -> String,
    changes: impl Fn(&T, &T) -> Vec<String>,
) -> Vec<Difference> {
    let first: BTreeMap<String, &T> = first.iter().map(|item| (key(item), item)).collect();
    let second: BTreeMap<String, &T> = second.iter().map(|item| (key(item), item)).collect();
    let mut found = Vec::new();
    for (name, item) in &first {
        let (kind, changes) = match second.get(name) {
            None => (DifferenceKind::Removed, Vec::new()),
            Some(other) => (DifferenceKind::Changed, changes(item, other)),
        };
        if kind == DifferenceKind::Removed || !changes.is_empty() {
            found.push(Difference { kind, subject: format!("{noun} {name}"), changes });
        }
    }
    for name in second.keys().filter(|name| !first.contains_key(*name)) {
        let (kind, subject) = (DifferenceKind::Added, format!("{noun} {name}"));
        found.push(Difference { kind, subject, changes: Vec::new() });
    }
    found
}

fn node_key(node: &Node) -> String {
    node.name().map_or_else(|| node.id.to_string(), str::to_owned)
}

fn edge_key(edge: &Edge) -> String {
    edge.name().map_or_else(|| edge.id.to_string(), str::to_owned)
}

fn station_key(station: &Station) -> String {
    station.name.clone()
}

fn zone_key(zone: &Zone) -> String {
    zone.name.to_string()
}

fn door_key(door: &Door) -> String {
    door.name.to_string()
}

fn lift_key(lift: &Lift) -> String {
    lift.name.to_string()
}

/// Formats a distance, given in metres and above [`TOLERANCE`], with digits that tell it.
fn length(metres: f64) -> String {
    match metres < LEAST_IN_METRES {
        true => format!("{:.3} mm", metres * 1000.0),
        false => format!("{metres:.3} m"),
    }
}

/// Formats an angle, given in radians and above [`TOLERANCE`], with digits that tell it.
fn angle(radians: f64) -> String {
    let degrees = radians.to_degrees();
    let digits = if degrees < LEAST_IN_HUNDREDTHS { 5 } else { 2 };
    format!("{degrees:.digits$}°")
}

/// Adds a change of a time in seconds.
fn add_secs(changes: &mut Vec<String>, what: &str, from: f64, to: f64) {
    if from != to {
        changes.push(format!("{what} {from} → {to} s"));
    }
}

fn door_time_changes(a: DoorTimes, b: DoorTimes) -> Vec<String> {
    let mut changes = Vec::new();
    add_secs(&mut changes, "opening", a.opening_secs, b.opening_secs);
    add_secs(&mut changes, "closing", a.closing_secs, b.closing_secs);
    changes
}

fn rule(rule: ZoneRule) -> String {
    match rule {
        ZoneRule::Capacity(robots) => format!("capacity {robots}"),
        ZoneRule::SameDirection => "same direction".to_owned(),
    }
}

struct Sides<'g> {
    first: &'g RouteGraph,
    second: &'g RouteGraph,
}

impl Sides<'_> {
    fn node_changes(&self, a: &Node, b: &Node) -> Vec<String> {
        let distance =
            (a.position + self.first.origin()).distance(b.position + self.second.origin());
        let turn = normalize_angle(b.theta - a.theta).abs();
        let mut changes = Vec::new();
        if distance > TOLERANCE {
            changes.push(format!("moved by {}", length(distance)));
        }
        if turn > TOLERANCE {
            changes.push(format!("turned by {}", angle(turn)));
        }
        if a.role != b.role {
            changes.push(format!("role {} → {}", a.role.name(), b.role.name()));
        }
        changes.extend(tag_changes(a.tags.as_deref(), b.tags.as_deref()));
        changes
    }

    fn edge_changes(&self, a: &Edge, b: &Edge) -> Vec<String> {
        let mut changes = Vec::new();
        let (from, to) = (described_ends(self.first, a), described_ends(self.second, b));
        if from != to {
            changes.push(format!("{from} → {to}"));
        }
        let distance = self.path_distance(a, b);
        if distance > TOLERANCE {
            changes.push(format!("path differs by {}", length(distance)));
        }
        if a.speed != b.speed {
            changes.push(format!("speed {} → {} m/s", a.speed, b.speed));
        }
        if a.reverse_speed != b.reverse_speed {
            let [from, to] = [a, b].map(|edge| match edge.reverse_speed {
                None => "none".to_owned(),
                Some(speed) => format!("{speed} m/s"),
            });
            changes.push(format!("reverse speed {from} → {to}"));
        }
        if a.orientation != b.orientation {
            let [from, to] = [a, b].map(|edge| described(edge.orientation));
            changes.push(format!("orientation {from} → {to}"));
        }
        if a.rotation != b.rotation {
            let [from, to] = [a, b].map(|edge| described_rotation(edge.rotation));
            changes.push(format!("rotation at its ends {from} → {to}"));
        }
        changes.extend(tag_changes(a.tags.as_deref(), b.tags.as_deref()));
        changes
    }

    fn zone_changes(&self, a: &Zone, b: &Zone) -> Vec<String> {
        let members = |graph: &RouteGraph, zone: &Zone| {
            let nodes = zone.nodes.iter().map(|node| node_key(graph.node(*node)));
            let edges = zone.edges.iter().map(|edge| edge_key(graph.edge(*edge)));
            [nodes.collect::<BTreeSet<_>>(), edges.collect()]
        };
        let mut changes = Vec::new();
        if a.rule != b.rule {
            changes.push(format!("{} → {}", rule(a.rule), rule(b.rule)));
        }
        if members(self.first, a) != members(self.second, b) {
            changes.push("other nodes or edges".to_owned());
        }
        changes
    }

    fn door_changes(&self, a: &Door, b: &Door) -> Vec<String> {
        let edges = |graph: &RouteGraph, door: &Door| {
            door.edges.iter().map(|edge| edge_key(graph.edge(*edge))).collect::<BTreeSet<_>>()
        };
        let mut changes = door_time_changes(a.times, b.times);
        if edges(self.first, a) != edges(self.second, b) {
            changes.push("other edges".to_owned());
        }
        let origins = self.second.origin() - self.first.origin();
        let line = b.line.map(|line| line.map(|point| point + origins));
        let has_moved = match (a.line, line) {
            (Some(from), Some(to)) => (0..2).any(|end| from[end].distance(to[end]) > TOLERANCE),
            (from, to) => from != to,
        };
        if has_moved {
            changes.push("moved".to_owned());
        }
        changes
    }

    fn lift_changes(&self, a: &Lift, b: &Lift) -> Vec<String> {
        let levels = |graph: &RouteGraph, lift: &Lift| {
            let names = lift.levels.iter().map(|level| {
                let nodes = level.nodes.iter().map(|node| node_key(graph.node(*node)));
                (level.name.clone(), nodes.collect::<BTreeSet<_>>())
            });
            names.collect::<Vec<_>>()
        };
        let mut changes = door_time_changes(a.door_times, b.door_times);
        add_secs(&mut changes, "time per level", a.level_secs, b.level_secs);
        if a.capacity != b.capacity {
            changes.push(format!("capacity {} → {}", a.capacity, b.capacity));
        }
        let [from, to] = [a, b].map(|lift| lift.levels.get(lift.home).map(|level| &*level.name));
        if from != to {
            let [from, to] = [from, to].map(Option::unwrap_or_default);
            changes.push(format!("home {from} → {to}"));
        }
        let [from, to] = [a, b].map(|lift| lift.cabin.as_ref().map(|cabin| cabin.size));
        if from != to {
            changes.push("size of the cabin".to_owned());
        }
        if levels(self.first, a) != levels(self.second, b) {
            changes.push("other levels or nodes".to_owned());
        }
        changes
    }

    fn station_changes(&self, a: &Station, b: &Station) -> Vec<String> {
        let mut changes = Vec::new();
        if a.role != b.role {
            changes.push(format!("role {} → {}", a.role.name(), b.role.name()));
        }
        let from = a.nodes.iter().map(|&node| node_key(self.first.node(node)));
        let to = b.nodes.iter().map(|&node| node_key(self.second.node(node)));
        if !from.eq(to) {
            changes.push("other nodes".to_owned());
        }
        let from = a.position.map(|position| position + self.first.origin());
        let to = b.position.map(|position| position + self.second.origin());
        let has_moved = match (from, to) {
            (Some(from), Some(to)) => from.distance(to) > TOLERANCE,
            _ => from != to,
        };
        if has_moved {
            changes.push("moved".to_owned());
        }
        changes
    }

    /// Returns the distance of two paths: the largest distance of a point of one path from the
    /// other path, of their starts, or of their ends.
    fn path_distance(&self, a: &Edge, b: &Edge) -> f64 {
        let shift = self.second.origin() - self.first.origin();
        let b = b.path.map(|point| point + shift);
        let ends = a.path.start().distance(b.start()).max(a.path.end().distance(b.end()));
        ends.max(farthest(&a.path, &b)).max(farthest(&b, &a.path))
    }
}

fn described_ends(graph: &RouteGraph, edge: &Edge) -> String {
    let [from, to] = [edge.origin, edge.destination].map(|node| node_key(graph.node(node)));
    format!("{from} to {to}")
}

/// Returns the largest distance of points of a path from another path.
fn farthest(path: &Path, other: &Path) -> f64 {
    let points = path.cubics().flat_map(|cubic| samples().map(|at| cubic.position(at)));
    points.map(|point| distance(other, point)).fold(0.0, f64::max)
}

/// Returns the distance of a point from a path, found by Newton's method from the nearest sample
/// of each cubic.
fn distance(path: &Path, point: DVec2) -> f64 {
    path.cubics().map(|cubic| cubic_distance(cubic, point)).fold(f64::INFINITY, f64::min)
}

fn cubic_distance(cubic: &CubicBezier, point: DVec2) -> f64 {
    let gap = |at: f64| cubic.position(at).distance(point);
    let start = samples().min_by(|a, b| gap(*a).total_cmp(&gap(*b))).unwrap_or(0.0);
    gap((0..8).fold(start, |nearest, _| cubic.nearer(nearest, point)))
}

/// Returns the parameters at which cubics are compared.
fn samples() -> impl Iterator<Item = f64> {
    (0..=SAMPLES).map(|index| f64::from(index) / f64::from(SAMPLES))
}

fn described(orientation: Orientation) -> String {
    match orientation {
        Orientation::Tangential => "tangential".to_owned(),
        Orientation::Offset(angle) => format!("{:.2}° to the tangent", angle.to_degrees()),
        Orientation::Fixed(heading) => format!("{:.2}° on the map", heading.to_degrees()),
    }
}

fn described_rotation(rotation: Ends<Rotation>) -> String {
    format!("{} and {}", rotation.origin.name(), rotation.destination.name())
}

/// Returns the names and properties that differ.
fn tag_changes(a: Option<&Tags>, b: Option<&Tags>) -> Vec<String> {
    let (a, b) = (a.map(texts).unwrap_or_default(), b.map(texts).unwrap_or_default());
    let keys: BTreeSet<_> = a.keys().chain(b.keys()).collect();
    let mut changes = Vec::new();
    for key in keys {
        let (from, to) = (a.get(key), b.get(key));
        if from != to {
            let [from, to] = [from, to].map(|text| text.map_or("none".to_owned(), |t| shorten(t)));
            changes.push(format!("{key} {from} → {to}"));
        }
    }
    changes
}

fn texts(tags: &Tags) -> BTreeMap<String, &str> {
    let named = [("name", &tags.name), ("level", &tags.level), ("zone", &tags.zone)];
    let named =
        named.into_iter().filter_map(|(key, text)| Some((key.to_owned(), text.as_deref()?)));
    let properties =
        tags.properties.iter().map(|(key, text)| (format!("property `{key}`"), &**text));
    named.chain(properties).collect()
}

#[cfg(test)]
mod tests;
