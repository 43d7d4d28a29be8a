//! Validates the doors and the lifts of a file.

use std::collections::{BTreeMap, BTreeSet};
use std::num::NonZeroU32;

use glam::DVec2;
use regatta_base::graph::{EdgeIndex, NodeIndex};

use super::validate::{MAX_COORDINATE, to_radians};
use crate::model::facilities::{
    Cabin, DEFAULT_LEVEL_SECS, Door, DoorTimes, Lift, LiftLevel, MAX_FACILITY_SECS, crossing,
};
use crate::model::finding::{Report, Subject};
use crate::model::raw::{RawDoor, RawDoorTimes, RawGraph, RawLift};
use crate::model::route_graph::RouteGraph;
use crate::model::value::shorten;

/// A door or a lift of a file, with the report about it.
struct Check<'a, 'text> {
    at: u32,
    /// ``door `d` ``.
    subject: String,
    graph: &'a RouteGraph,
    report: &'a mut Report<'text>,
}

/// Returns the doors, and reports every error.
pub(super) fn check_doors(
    raw: &[RawDoor],
    graph: &RouteGraph,
    origin: DVec2,
    report: &mut Report<'_>,
) -> Vec<Door> {
    let mut names = BTreeSet::new();
    let mut doors = Vec::with_capacity(raw.len());
    for door in raw {
        let subject = format!("door `{}`", shorten(&door.name));
        let mut check = Check { at: door.at, subject, graph, report };
        check.unique(names.insert(door.name.as_str()));
        let edges: BTreeSet<EdgeIndex> =
            door.edges.iter().filter_map(|&id| check.edge(id)).collect();
        if edges.is_empty() {
            check.error("is across no edge: list the Edges that lead through it");
        }
        check.one_level(&edges);
        doors.push(Door {
            name: door.name.as_str().into(),
            edges: edges.into_iter().collect(),
            line: door.line.map(|line| check.line(line, origin)),
            times: check.door_times(door.times),
        });
    }
    doors
}

/// Returns the lifts, and reports every error.
pub(super) fn check_lifts(
    raw: &RawGraph,
    graph: &RouteGraph,
    origin: DVec2,
    report: &mut Report<'_>,
) -> Vec<Lift> {
    let mut names = BTreeSet::new();
    let mut owners = BTreeMap::new();
    let mut lifts = Vec::with_capacity(raw.lifts.len());
    for lift in &raw.lifts {
        let subject = format!("lift `{}`", shorten(&lift.name));
        let mut check = Check { at: lift.at, subject, graph, report };
        check.unique(names.insert(lift.name.as_str()));
        let lift = check.lift(lift, origin, raw.degrees);
        for node in lift.levels.iter().flat_map(|level| &level.nodes) {
            let id = graph.node(*node).id;
            match owners.insert(*node, lift.name.clone()) {
                None => {}
                Some(other) if other == lift.name => {
                    check.error(&format!("lists node {id} twice: list it once"));
                }
                Some(other) => check.error(&format!(
                    "has node {id}, as lift `{}` does: a node is in one cabin",
                    shorten(&other)
                )),
            }
        }
        lifts.push(lift);
    }
    lifts
}

impl Check<'_, '_> {
    fn lift(&mut self, raw: &RawLift, origin: DVec2, degrees: bool) -> Lift {
        let levels = self.levels(&raw.nodes);
        let home = raw.home.as_deref().map(|name| self.home(name, &levels));
        let mut lift = Lift {
            name: raw.name.as_str().into(),
            levels,
            rides: Vec::new(),
            cabin: raw.cabin.map(|cabin| self.cabin(cabin, origin, degrees)),
            door_times: self.door_times(raw.door_times),
            level_secs: self.secs("SecondsPerLevel", raw.level_secs, DEFAULT_LEVEL_SECS),
            capacity: raw.capacity.and_then(NonZeroU32::new).unwrap_or(NonZeroU32::MIN),
            home: home.unwrap_or_default(),
        };
        if lift.level_secs <= 0.0 {
            self.error("SecondsPerLevel must be above 0");
        }
        lift.rides = self.rides(&lift);
        lift
    }

    /// Returns the levels of nodes, each of which is on the level that its tag names.
    fn levels(&mut self, ids: &[u32]) -> Vec<LiftLevel> {
        let mut levels: Vec<LiftLevel> = Vec::new();
        for &id in ids {
            let Some(node) = self.graph.node_by_id(id) else {
                self.error(&format!(
                    "names node {id}, which doesn't exist: add it or correct the id"
                ));
                continue;
            };
            let tags = self.graph.node(node).tags.as_ref();
            let Some(name) = tags.and_then(|tags| tags.level.clone()) else {
                self.error(&format!("has node {id}, which has no Level: give it one"));
                continue;
            };
            match levels.iter_mut().find(|level| level.name == name) {
                Some(level) => level.nodes.push(node),
                None => levels.push(LiftLevel { name, nodes: vec![node] }),
            }
        }
        if levels.len() < 2 {
            self.error("joins fewer than two levels: list Nodes of at least two Levels");
        }
        levels
    }

    fn home(&mut self, name: &str, levels: &[LiftLevel]) -> usize {
        let found = levels.iter().position(|level| &*level.name == name);
        found.unwrap_or_else(|| {
            let name = shorten(name);
            self.error(&format!("begins at the level `{name}`, which it doesn't serve"));
            0
        })
    }

    fn cabin(&mut self, cabin: Cabin, origin: DVec2, degrees: bool) -> Cabin {
        let is_size = cabin.size.cmpgt(DVec2::ZERO).all() && is_in_range(cabin.size);
        if !is_size {
            self.error(&format!(
                "has no Width or no Depth: give both in metres, above 0 and up to {MAX_COORDINATE}"
            ));
        }
        let centre = cabin.centre - origin;
        if !is_in_range(centre) {
            self.error(&format!(
                "stands more than {MAX_COORDINATE} m from the nodes: correct X and Y"
            ));
        }
        Cabin { centre, yaw: to_radians(cabin.yaw, degrees), ..cabin }
    }

    fn line(&mut self, line: [DVec2; 2], origin: DVec2) -> [DVec2; 2] {
        let line = line.map(|point| point - origin);
        if !line.iter().all(|point| is_in_range(*point)) {
            self.error(&format!(
                "has a Line more than {MAX_COORDINATE} m from the nodes: correct it"
            ));
        }
        line
    }

    /// Checks that all edges of a door are on a level of its first edge.
    fn one_level(&mut self, edges: &BTreeSet<EdgeIndex>) {
        let Some(first) = edges.first() else { return };
        let levels = self.levels_of(*first);
        let other = edges
            .iter()
            .find(|&&edge| !self.levels_of(edge).into_iter().any(|level| levels.contains(&level)));
        if let Some(&other) = other {
            let [first, other] = [*first, other].map(|edge| self.graph.edge(edge).id);
            self.error(&format!(
                "is across edges {first} and {other}, which are on different levels: make it a \
                 door on each level"
            ));
        }
    }

    /// The levels of the ends of an edge; `None` for an end without a level.
    fn levels_of(&self, edge: EdgeIndex) -> [Option<&str>; 2] {
        let edge = self.graph.edge(edge);
        [edge.origin, edge.destination].map(|node| {
            let tags = self.graph.node(node).tags.as_ref();
            tags.and_then(|tags| tags.level.as_deref())
        })
    }

    /// Returns the edges between neighbouring levels.
    fn rides(&mut self, lift: &Lift) -> Vec<EdgeIndex> {
        let mut rides = Vec::new();
        for (index, edge) in (0..).map(EdgeIndex).zip(self.graph.edges()) {
            let ends = [edge.origin, edge.destination].map(|node| lift.level_of(node));
            let [Some(from), Some(to)] = ends else { continue };
            match from.abs_diff(to) {
                0 => {}
                1 => rides.push(index),
                _ => self.error(&format!(
                    "has edge {}, which passes a level: lead it over the nodes between",
                    edge.id
                )),
            }
        }
        rides
    }

    fn edge(&mut self, id: u32) -> Option<EdgeIndex> {
        let found = self.graph.edge_by_id(id);
        if found.is_none() {
            self.error(&format!("names edge {id}, which doesn't exist: add it or correct the id"));
        }
        found
    }

    fn door_times(&mut self, times: RawDoorTimes) -> DoorTimes {
        let default = DoorTimes::default();
        DoorTimes {
            opening_secs: self.secs("OpeningSeconds", times.opening, default.opening_secs),
            closing_secs: self.secs("ClosingSeconds", times.closing, default.closing_secs),
        }
    }

    fn secs(&mut self, key: &str, secs: Option<f64>, default: f64) -> f64 {
        let secs = secs.unwrap_or(default);
        if !(0.0..=MAX_FACILITY_SECS).contains(&secs) {
            self.error(&format!("{key} is {secs}: give 0 to {MAX_FACILITY_SECS} seconds"));
        }
        secs
    }

    fn unique(&mut self, is_new: bool) {
        if !is_new {
            self.error("is given twice: give each a name of its own");
        }
    }

    fn error(&mut self, problem: &str) {
        let message = format!("{} {problem}", self.subject);
        self.report.error(self.at, Subject::File, message);
    }
}

/// Whether a point or an extent is within the range of coordinates.
fn is_in_range(metres: DVec2) -> bool {
    metres.is_finite() && metres.abs().max_element() <= MAX_COORDINATE
}

/// The nodes within this distance of a door in metres are too near: robots that wait there stand in
/// it.
const NEAR_DOOR: f64 = 0.3;

/// Warns of doors at nodes, in lifts or beside their edges, of lifts that lack nodes for their
/// capacity, and of lifts in which levels aren't joined.
pub(super) fn lint(graph: &RouteGraph, raw: &RawGraph, report: &mut Report<'_>) {
    for (door, raw) in graph.doors().iter().zip(&raw.doors) {
        for problem in [in_a_lift(graph, door), beside_an_edge(graph, door)].into_iter().flatten() {
            report.file_warning(raw.at, format!("door `{}` {problem}", shorten(&door.name)));
        }
        let near = door.edges.iter().find_map(|edge| node_near(graph, door, *edge));
        if let Some(node) = near {
            let message = format!(
                "door `{}` is within {NEAR_DOOR} m of node {}: robots that wait there stand in it",
                shorten(&door.name),
                graph.node(node).id
            );
            report.file_warning(raw.at, message);
        }
    }
    for (lift, raw) in graph.lifts().iter().zip(&raw.lifts) {
        if let Some(problem) = lift.lack_of_places() {
            report.assumption(raw.at, format!("lift `{}` {problem}", shorten(&lift.name)));
        }
        for (below, pair) in lift.levels.windows(2).enumerate() {
            if !is_joined(graph, lift, below) {
                let [from, to] = [&pair[0], &pair[1]].map(|level| shorten(&level.name));
                let message = format!(
                    "lift `{}` has no edge between the levels {from} and {to}: robots can't ride \
                     there",
                    shorten(&lift.name)
                );
                report.file_warning(raw.at, message);
            }
        }
    }
}

/// Tells that a door is on a ride, if it is: a lift has doors of its own.
fn in_a_lift(graph: &RouteGraph, door: &Door) -> Option<String> {
    let ride = door.edges.iter().find(|edge| graph.is_ride(**edge))?;
    Some(format!(
        "is on edge {}, which a lift rides: lifts have doors of their own; remove it",
        graph.edge(*ride).id
    ))
}

/// Tells the first edge that the line of a door doesn't cross, if there is one.
fn beside_an_edge(graph: &RouteGraph, door: &Door) -> Option<String> {
    let line = door.line?;
    let beside = door.edges.iter().find(|edge| crossing(&graph.edge(**edge).path, line).is_none());
    Some(format!(
        "has a Line that doesn't cross edge {}: it stands in the middle of the edge",
        graph.edge(*beside?).id
    ))
}

/// Whether a ride joins a level with the next.
fn is_joined(graph: &RouteGraph, lift: &Lift, below: usize) -> bool {
    lift.rides.iter().any(|ride| {
        let edge = graph.edge(*ride);
        let ends = [edge.origin, edge.destination].map(|node| lift.level_of(node));
        ends == [Some(below), Some(below + 1)] || ends == [Some(below + 1), Some(below)]
    })
}

/// Returns the end of an edge that is near to a door on it.
fn node_near(graph: &RouteGraph, door: &Door, edge: EdgeIndex) -> Option<NodeIndex> {
    let edge = graph.edge(edge);
    let place = door.place(&edge.path);
    let length = edge.path.length();
    // The door of an edge that is that short is near to both ends anyhow.
    if length < 2.0 * NEAR_DOOR {
        return None;
    }
    match (place < NEAR_DOOR, length - place < NEAR_DOOR) {
        (true, _) => Some(edge.origin),
        (_, true) => Some(edge.destination),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use crate::model::options::ReadOptions;
    use crate::{GraphError, RouteGraph, parse};

    const PLANT: &str = "Edges:
- {Id: 1, Origin_ID: 1, Destination_ID: 2, CurveType: Linear, VelocityForward: 1}
- {Id: 2, Origin_ID: 2, Destination_ID: 3, CurveType: Linear, VelocityForward: 1}
- {Id: 3, Origin_ID: 3, Destination_ID: 4, CurveType: Linear, VelocityForward: 1}
- {Id: 4, Origin_ID: 2, Destination_ID: 5, CurveType: Linear, VelocityForward: 1}
Vertices:
- {Id: 1, X: 0, Y: 0, Theta: 0, Level: low}
- {Id: 2, X: 4, Y: 0, Theta: 0, Level: low}
- {Id: 3, X: 4, Y: 1, Theta: 0, Level: high}
- {Id: 4, X: 8, Y: 1, Theta: 0, Level: high}
- {Id: 5, X: 4, Y: 9, Theta: 0, Level: top}
";

    fn read(more: &str) -> Result<(RouteGraph, Vec<String>), String> {
        match parse(&format!("{PLANT}{more}"), "g", &ReadOptions::default()) {
            Ok((graph, findings)) => {
                let found = findings.as_slice().iter();
                Ok((graph, found.map(|finding| finding.message.clone()).collect()))
            }
            Err(GraphError::Invalid(findings)) => Err(findings.as_slice()[0].message.clone()),
            Err(other) => panic!("{other}"),
        }
    }

    #[test]
    fn a_lift_takes_its_levels_rides_and_times_from_the_file() {
        let lift = "Lifts:\n- {Name: L, Nodes: [2, 3], SecondsPerLevel: 10, Capacity: 2, Home: high}\n\
                    Doors:\n- {Name: d, Edges: [1], Line: [[3, -1], [3, 1]], ClosingSeconds: 2}\n";
        let (graph, _) = read(lift).expect("a plant");
        let [lift] = graph.lifts() else { panic!("{:?}", graph.lifts()) };
        assert_eq!((lift.levels.len(), lift.home, lift.rides.len()), (2, 1, 1));
        assert_eq!(&*lift.levels[1].name, "high");
        assert_eq!(graph.edge(lift.rides[0]).speed, 0.1, "a metre in ten seconds");
        let zone = graph.zones().last().expect("the zone of the lift");
        assert_eq!((&*zone.name, zone.nodes.len(), zone.edges.len()), ("lift L", 2, 4));
        let door = &graph.doors()[0];
        assert_eq!((door.times.opening_secs, door.times.closing_secs), (5.0, 2.0));
        assert!((door.place(&graph.edge(door.edges[0]).path) - 3.0).abs() < 1e-9);
    }

    #[test]
    fn wrong_facilities_are_errors_that_say_what_to_do() {
        for (text, message) in [
            ("Lifts:\n- {Name: L, Nodes: [2, 9]}\n", "lift `L` names node 9, which doesn't exist"),
            ("Lifts:\n- {Name: L, Nodes: [1, 2]}\n", "lift `L` joins fewer than two levels"),
            (
                "Lifts:\n- {Name: L, Nodes: [2, 3, 5]}\n",
                "lift `L` has edge 4, which passes a level",
            ),
            ("Lifts:\n- {Name: L, Nodes: [2, 3], SecondsPerLevel: -1}\n", "SecondsPerLevel is -1"),
            ("Lifts:\n- {Name: L, Nodes: [2, 3], Home: roof}\n", "begins at the level `roof`"),
            (
                "Lifts:\n- {Name: L, Nodes: [2, 3]}\n- {Name: M, Nodes: [3, 5]}\n",
                "lift `M` has node 3, as lift `L` does",
            ),
            ("Lifts:\n- {Name: L, Nodes: [2, 3], Width: 2}\n", "has no X: give one"),
            ("Lifts:\n- {Name: L, Nodes: [2, 2, 3]}\n", "lift `L` lists node 2 twice"),
            (
                "Lifts:\n- {Name: L, Nodes: [2, 3], X: 0, Y: 0, Width: 1e300, Depth: 1}\n",
                "has no Width or no Depth: give both in metres, above 0 and up to 8000",
            ),
            (
                "Lifts:\n- {Name: L, Nodes: [2, 3], X: 9999, Y: 0, Width: 1, Depth: 1}\n",
                "lift `L` stands more than 8000 m from the nodes",
            ),
            (
                "Doors:\n- {Name: d, Edges: [1], Line: [[1, 1e300], [1, 2]]}\n",
                "door `d` has a Line more than 8000 m from the nodes",
            ),
            (
                "Doors:\n- {Name: d, Edges: [1, 3]}\n",
                "door `d` is across edges 1 and 3, which are on different levels",
            ),
            ("Doors:\n- {Name: d, Edges: []}\n", "door `d` is across no edge"),
            ("Doors:\n- {Name: d, Edges: [7]}\n", "door `d` names edge 7, which doesn't exist"),
            ("Doors:\n- {Name: d, Edges: [1], Line: [[1, 2]]}\n", "Line must have two points"),
            ("Doors:\n- {Edges: [1]}\n", "a door has no Name"),
            ("Doors:\n- {Name: d, Edges: [1]}\n- {Name: d, Edges: [3]}\n", "is given twice"),
        ] {
            let error = read(text).map(drop).expect_err(text);
            assert!(error.contains(message), "{text}: {error}");
        }
    }

    #[test]
    fn a_door_at_a_node_and_levels_without_a_ride_are_warned_of() {
        let near = "Doors:\n- {Name: d, Edges: [1], Line: [[3.9, -1], [3.9, 1]]}\n";
        let (_, warnings) = read(near).expect("a plant");
        let is_near = |warning: &String| warning.contains("door `d` is within 0.3 m of node 2");
        assert!(warnings.iter().any(is_near), "{warnings:?}");
        let beside = "Doors:\n- {Name: d, Edges: [1], Line: [[3, 1], [3, 2]]}\n";
        let (_, warnings) = read(beside).expect("a plant");
        let is_beside = |warning: &String| warning.contains("doesn't cross edge 1: it stands in");
        assert!(warnings.iter().any(is_beside), "{warnings:?}");
        let ride = "Lifts:\n- {Name: L, Nodes: [2, 3]}\nDoors:\n- {Name: d, Edges: [2]}\n";
        let (_, warnings) = read(ride).expect("a plant");
        let is_ride = |warning: &String| warning.contains("is on edge 2, which a lift rides");
        assert!(warnings.iter().any(is_ride), "{warnings:?}");
        let apart = "Lifts:\n- {Name: L, Nodes: [3, 5]}\n";
        let (_, warnings) = read(apart).expect("a plant");
        let is_apart =
            |warning: &String| warning.contains("no edge between the levels high and top");
        assert!(warnings.iter().any(is_apart), "{warnings:?}");
    }
}
