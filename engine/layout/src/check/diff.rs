//! The differences between two route graphs, by the names or ids of their nodes, edges and
//! stations.

use std::collections::BTreeMap;
use std::fmt;

use glam::DVec2;

use crate::model::path::Path;
use crate::model::route_graph::{Edge, Node, RouteGraph};
use crate::model::tags::{Orientation, Station, Tags};
use crate::model::value::shorten;

/// The distance in metres, and the angle in radians, up to which poses count as equal.
const TOLERANCE: f64 = 1e-6;

/// The number of points of each cubic at which two paths are compared.
const SAMPLES: u32 = 16;

/// A difference between two graphs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference {
    /// What the second graph has, hasn't, or has otherwise.
    pub kind: DifferenceKind,
    /// `node A`, `edge 12` or `station dock`.
    pub subject: String,
    /// What has changed; empty unless the kind is [`DifferenceKind::Changed`].
    pub changes: Vec<String>,
}

/// The kind of a [`Difference`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DifferenceKind {
    /// Only the first graph has it.
    Removed,
    /// Only the second graph has it.
    Added,
    /// Both have it, but not the same.
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

/// Returns what differs from the first graph to the second: nodes, then edges, then stations, each
/// by name or id.
pub fn diff(first: &RouteGraph, second: &RouteGraph) -> Vec<Difference> {
    let sides = Sides { first, second };
    let mut found =
        compare("node", first.nodes(), second.nodes(), node_key, |a, b| sides.node_changes(a, b));
    found.extend(compare("edge", first.edges(), second.edges(), edge_key, |a, b| {
        sides.edge_changes(a, b)
    }));
    let name = |station: &Station| station.name.clone();
    found.extend(compare("station", first.stations(), second.stations(), name, |a, b| {
        sides.station_changes(a, b)
    }));
    found
}

fn compare<T>(
    kind: &str,
    first: &[T],
    second: &[T],
    key: impl Fn(&T) -> String,
    changes: impl Fn(&T, &T) -> Vec<String>,
) -> Vec<Difference> {
    let index = |items| -> BTreeMap<String, &T> {
        <[T]>::iter(items).map(|item| (key(item), item)).collect()
    };
    let (first, second) = (index(first), index(second));
    let subject = |name: &str| format!("{kind} {name}");
    let mut found = Vec::new();
    for (name, item) in &first {
        let Some(other) = second.get(name) else {
            found.push(Difference {
                kind: DifferenceKind::Removed,
                subject: subject(name),
                changes: Vec::new(),
            });
            continue;
        };
        let changes = changes(item, other);
        if !changes.is_empty() {
            found.push(Difference {
                kind: DifferenceKind::Changed,
                subject: subject(name),
                changes,
            });
        }
    }
    let added = second.keys().filter(|name| !first.contains_key(*name));
    found.extend(added.map(|name| Difference {
        kind: DifferenceKind::Added,
        subject: subject(name),
        changes: Vec::new(),
    }));
    found
}

fn node_key(node: &Node) -> String {
    node.name().map_or_else(|| node.id.to_string(), str::to_owned)
}

fn edge_key(edge: &Edge) -> String {
    edge.name().map_or_else(|| edge.id.to_string(), str::to_owned)
}

struct Sides<'g> {
    first: &'g RouteGraph,
    second: &'g RouteGraph,
}

impl Sides<'_> {
    fn node_changes(&self, a: &Node, b: &Node) -> Vec<String> {
        let distance =
            (a.position + self.first.origin()).distance(b.position + self.second.origin());
        let turn = crate::model::angle::normalize_angle(b.theta - a.theta).abs();
        let mut changes = Vec::new();
        if distance > TOLERANCE {
            changes.push(format!("moved by {distance:.3} m"));
        }
        if turn > TOLERANCE {
            changes.push(format!("turned by {:.2}°", turn.to_degrees()));
        }
        if a.role != b.role {
            changes.push(format!("role {} → {}", a.role.name(), b.role.name()));
        }
        changes.extend(tag_changes(a.tags.as_deref(), b.tags.as_deref()));
        changes
    }

    fn edge_changes(&self, a: &Edge, b: &Edge) -> Vec<String> {
        let mut changes = Vec::new();
        let ends = |graph: &RouteGraph, edge: &Edge| {
            [edge.origin, edge.destination].map(|node| node_key(graph.node(node)))
        };
        let (from, to) = (ends(self.first, a), ends(self.second, b));
        if from != to {
            changes.push(format!("{} to {} → {} to {}", from[0], from[1], to[0], to[1]));
        }
        let distance = self.path_distance(a, b);
        if distance > TOLERANCE {
            changes.push(format!("path differs by {distance:.3} m"));
        }
        if a.speed != b.speed {
            changes.push(format!("speed {} → {} m/s", a.speed, b.speed));
        }
        if a.reverse_speed != b.reverse_speed {
            let speed = |speed: Option<f64>| {
                speed.map_or("none".to_owned(), |speed| format!("{speed} m/s"))
            };
            let (from, to) = (speed(a.reverse_speed), speed(b.reverse_speed));
            changes.push(format!("reverse speed {from} → {to}"));
        }
        if a.orientation != b.orientation {
            changes.push(format!(
                "orientation {} → {}",
                described(a.orientation),
                described(b.orientation)
            ));
        }
        changes.extend(tag_changes(a.tags.as_deref(), b.tags.as_deref()));
        changes
    }

    fn station_changes(&self, a: &Station, b: &Station) -> Vec<String> {
        let nodes = |graph: &RouteGraph, station: &Station| -> Vec<String> {
            station.nodes.iter().map(|&node| node_key(graph.node(node))).collect()
        };
        let mut changes = Vec::new();
        if a.role != b.role {
            changes.push(format!("role {} → {}", a.role.name(), b.role.name()));
        }
        if nodes(self.first, a) != nodes(self.second, b) {
            changes.push("other nodes".to_owned());
        }
        let position =
            |graph: &RouteGraph, station: &Station| station.position.map(|at| at + graph.origin());
        match (position(self.first, a), position(self.second, b)) {
            (Some(from), Some(to)) if from.distance(to) <= TOLERANCE => {}
            (None, None) => {}
            _ => changes.push("moved".to_owned()),
        }
        changes
    }

    /// Returns the largest distance of a point of one of two paths from the other path, or of their
    /// starts or ends.
    fn path_distance(&self, a: &Edge, b: &Edge) -> f64 {
        let shift = self.second.origin() - self.first.origin();
        let b = b.path.map(|point| point + shift);
        let ends = a.path.start().distance(b.start()).max(a.path.end().distance(b.end()));
        ends.max(farthest(&a.path, &b)).max(farthest(&b, &a.path))
    }
}

/// Returns the largest distance of points of a path from another path.
fn farthest(path: &Path, other: &Path) -> f64 {
    let parameters = || (0..=SAMPLES).map(|index| f64::from(index) / f64::from(SAMPLES));
    let points = path.cubics().flat_map(|cubic| parameters().map(|at| cubic.position(at)));
    points.map(|point| distance(other, point)).fold(0.0, f64::max)
}

/// Returns the distance of a point from a path: from the nearest of some points of each cubic,
/// Newton's method goes on.
fn distance(path: &Path, point: DVec2) -> f64 {
    let of_cubic = |cubic: &regatta_base::bezier::CubicBezier| {
        let gap = |at: f64| cubic.position(at).distance(point);
        let starts = (0..=SAMPLES).map(|index| f64::from(index) / f64::from(SAMPLES));
        let start = starts.min_by(|a, b| gap(*a).total_cmp(&gap(*b))).unwrap_or(0.0);
        gap((0..8).fold(start, |nearest, _| cubic.nearer(nearest, point)))
    };
    path.cubics().map(of_cubic).fold(f64::INFINITY, f64::min)
}

fn described(orientation: Orientation) -> String {
    match orientation {
        Orientation::Tangential => "tangential".to_owned(),
        Orientation::Offset(angle) => format!("{:.2}° to the tangent", angle.to_degrees()),
        Orientation::Fixed(heading) => format!("{:.2}° on the map", heading.to_degrees()),
    }
}

/// Returns the names and properties that differ.
fn tag_changes(a: Option<&Tags>, b: Option<&Tags>) -> Vec<String> {
    let empty = Tags::default();
    let (a, b) = (a.unwrap_or(&empty), b.unwrap_or(&empty));
    let texts = |tags: &Tags| -> BTreeMap<String, String> {
        let named = [("name", &tags.name), ("level", &tags.level), ("zone", &tags.zone)];
        let named = named
            .into_iter()
            .filter_map(|(key, text)| Some((key.to_owned(), text.as_ref()?.to_string())));
        named
            .chain(
                tags.properties
                    .iter()
                    .map(|(key, text)| (format!("property `{key}`"), text.to_string())),
            )
            .collect()
    };
    let (a, b) = (texts(a), texts(b));
    let keys: std::collections::BTreeSet<_> = a.keys().chain(b.keys()).collect();
    let text = |tags: &BTreeMap<String, String>, key| {
        tags.get(key).map_or("none".to_owned(), |text| shorten(text))
    };
    let changed = keys.into_iter().filter(|key| a.get(*key) != b.get(*key));
    changed.map(|key| format!("{key} {} → {}", text(&a, key), text(&b, key))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::options::ReadOptions;
    use crate::parse;

    fn graph(speed: f64, x: f64, more: &str) -> RouteGraph {
        let text = format!(
            "Vertices:\n- {{Id: 1, X: 0, Y: 0, Theta: 0}}\n- {{Id: 2, X: {x}, Y: 0, Theta: 0, Role: park}}\n{more}\
             Edges:\n- {{Id: 7, Origin_ID: 1, Destination_ID: 2, CurveType: Linear, VelocityForward: {speed}}}\n"
        );
        parse(&text, "g", &ReadOptions::default()).expect("a graph").0
    }

    fn differences(first: &RouteGraph, second: &RouteGraph) -> Vec<String> {
        diff(first, second).iter().map(ToString::to_string).collect()
    }

    #[test]
    fn a_graph_doesnt_differ_from_itself() {
        assert_eq!(differences(&graph(1.0, 5.0, ""), &graph(1.0, 5.0, "")), [""; 0]);
    }

    #[test]
    fn every_difference_is_named() {
        let more = "- {Id: 3, X: 9, Y: 9, Theta: 0}\n";
        let found = differences(&graph(1.0, 5.0, ""), &graph(2.0, 5.5, more));
        assert_eq!(
            found,
            [
                "~ node 2: moved by 0.500 m",
                "+ node 3",
                "~ edge 7: path differs by 0.500 m, speed 1 → 2 m/s"
            ]
        );
        assert_eq!(differences(&graph(1.0, 5.0, more), &graph(1.0, 5.0, "")), ["- node 3"]);
    }

    #[test]
    fn paths_are_compared_whatever_their_cubics_are() {
        let edge = |points: &str| {
            let text = format!(
                "Vertices:\n- {{Id: 1, X: 0, Y: 0, Theta: 0}}\n- {{Id: 2, X: 6, Y: 0, Theta: 0}}\n\
                 Edges:\n- {{Id: 7, Origin_ID: 1, Destination_ID: 2, CurveType: Bezier, ControlPoints: [{points}], VelocityForward: 1, Zone: a}}\n"
            );
            parse(&text, "g", &ReadOptions::default()).expect("a graph").0
        };
        // The same curve, also as its first quarter and the rest, by de Casteljau's scheme.
        let whole = edge("[0, 0], [0, 4], [6, 4], [6, 0]");
        let parts =
            edge("[0, 0], [0, 1], [0.375, 1.75], [0.9375, 2.25], [2.625, 3.75], [6, 3], [6, 0]");
        assert_eq!(differences(&whole, &parts), [""; 0]);
        let other = edge("[0, 0], [0, 4.4], [6, 4.4], [6, 0]");
        assert_eq!(differences(&whole, &other), ["~ edge 7: path differs by 0.300 m"]);
    }
}
