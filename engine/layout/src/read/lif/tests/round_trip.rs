//! Graphs that are written and read again; every file is checked by the schema of the VDMA.

use std::sync::OnceLock;

use boon::{Compiler, SchemaIndex, Schemas};
use glam::DVec2;
use proptest::prelude::*;
use regatta_base::bezier::CubicBezier;
use regatta_base::graph::{Gear, NodeIndex};
use serde_json::Value;

use super::super::Header;
use super::{FOLDER, edge, file, layout, messages, node, options, read, sample, two_levels};
use crate::model::path::Path;
use crate::model::route_graph::{Edge, Node, RouteGraph};
use crate::model::tags::{OTHER_VEHICLE_TYPES, Orientation, Role, Station, Tags};
use crate::parse;
use crate::write::lif::{write, write_with};

/// Asserts that a text is valid LIF.
fn assert_valid(text: &str) {
    static SCHEMA: OnceLock<(Schemas, SchemaIndex)> = OnceLock::new();
    let (schemas, index) = SCHEMA.get_or_init(|| {
        let mut schemas = Schemas::new();
        let mut compiler = Compiler::new();
        let schema: Value = serde_json::from_str(&sample("LIF.schema")).expect("JSON");
        let name = format!("{FOLDER}LIF.schema.json");
        compiler.add_resource(&name, schema).expect("a schema");
        let index = compiler.compile(&name, &mut schemas).expect("a schema");
        (schemas, index)
    });
    let value: Value = serde_json::from_str(text).expect("JSON");
    if let Err(error) = schemas.validate(&value, *index) {
        panic!("{error:#}\n{text}");
    }
}

/// Asserts that two graphs have the same curves, speeds and headings. What was written as an edge
/// in reverse gear is at the end of `read`.
fn assert_same(graph: &RouteGraph, read: &RouteGraph) {
    assert_eq!(graph.nodes().len(), read.nodes().len());
    for (node, other) in graph.nodes().iter().zip(read.nodes()) {
        assert!((graph.origin() + node.position).distance(read.origin() + other.position) < 1e-9);
        assert_eq!(node.has_heading, other.has_heading);
        // A heading that isn't given is that of an edge, which may have been connected to the node
        // since.
        assert!(
            !node.has_heading || (node.theta - other.theta).abs() < 1e-12,
            "{node:?} {other:?}"
        );
        assert_eq!(node.role, other.role);
    }
    for (edge, other) in graph.edges().iter().zip(read.edges()) {
        assert_eq!(edge.speed, other.speed);
        assert_same_path(graph, (&edge.path, edge.orientation), read, other);
    }
    let reverse = graph.edges().iter().filter(|edge| edge.reverse_speed.is_some());
    let mut others = read.edges()[graph.edges().len()..].iter();
    for edge in reverse {
        let other = others.next().expect("an edge for the reverse gear");
        assert_eq!((edge.reverse_speed, other.reverse_speed), (Some(other.speed), None));
        assert_eq!((edge.origin, edge.destination), (other.destination, other.origin));
        // Seen from the destination, the same curve and the same headings.
        let back = Edge {
            path: other.path.reversed(),
            orientation: opposite(other.orientation),
            ..other.clone()
        };
        assert_same_path(graph, (&edge.path, edge.orientation), read, &back);
    }
    assert!(others.next().is_none());
}

fn opposite(orientation: Orientation) -> Orientation {
    match orientation {
        Orientation::Tangential => Orientation::Offset(std::f64::consts::PI),
        Orientation::Offset(angle) => Orientation::Offset(angle + std::f64::consts::PI),
        fixed @ Orientation::Fixed(_) => fixed,
    }
}

fn assert_same_path(
    graph: &RouteGraph,
    (path, orientation): (&Path, Orientation),
    read: &RouteGraph,
    other: &Edge,
) {
    assert_eq!(path.cubic_count(), other.path.cubic_count());
    for step in 0..=50u32 {
        let fraction = f64::from(step) / 50.0;
        let (point, tangent) = path.at(fraction);
        let (other_point, other_tangent) = other.path.at(fraction);
        let distance = (graph.origin() + point).distance(read.origin() + other_point);
        assert!(distance < 1e-6, "{distance}");
        let difference = orientation.heading(tangent.to_angle())
            - other.orientation.heading(other_tangent.to_angle());
        // At a joint, a fraction can be on either side.
        let is_joint = (fraction * path.cubic_count() as f64).fract().min(1.0) < 1e-9;
        assert!(
            is_joint || difference.sin().abs() < 1e-6 && difference.cos() > 0.0,
            "{difference}"
        );
    }
}

#[test]
fn examples_are_written_as_valid_files_and_read_again() {
    for name in ["1", "2", "3", "4", "7", "10", "12", "13", "16", "17"] {
        let (graph, _) = read(&sample(&format!("ex_10_{name}.lif.json")));
        let written = write(&graph);
        assert_valid(&written.text);
        let loss = "1 node has other properties for other vehicle types: not kept";
        assert_eq!(written.losses, if name == "10" { vec![loss] } else { vec![] }, "{name}");
        let (again, findings) = read(&written.text);
        assert_same(&graph, &again);
        for (node, other) in graph.nodes().iter().zip(again.nodes()) {
            let mut tags = node.tags.clone().expect("vehicle types");
            tags.properties.remove(OTHER_VEHICLE_TYPES);
            assert_eq!(Some(tags), other.tags);
        }
        for (edge, other) in graph.edges().iter().zip(again.edges()) {
            assert_eq!(edge.tags, other.tags);
        }
        let heights = graph.stations().iter().zip(again.stations());
        assert!(heights.clone().all(|(one, other)| (&one.name, one.role, &one.nodes)
            == (&other.name, other.role, &other.nodes)));
        assert!(!messages(&findings).contains("gap"), "{name}: {}", messages(&findings));
    }
}

#[test]
fn nodes_without_a_heading_stay_without() {
    let nodes = [node("1", 0.0, 0.0, ""), node("2", 10.0, 0.0, ", \"theta\": 1.5")];
    let (mut graph, _) =
        read(&file(&[layout("\"layoutId\": \"L\"", &nodes, &[edge("1", ["1", "2"], "")])]));
    assert!(graph.nodes().iter().any(|node| !node.has_heading));
    for _ in 0..2 {
        let written = write(&graph);
        assert_valid(&written.text);
        let given = |graph: &RouteGraph| {
            graph.nodes().iter().map(|node| node.has_heading).collect::<Vec<_>>()
        };
        let (again, _) = read(&written.text);
        assert_eq!(given(&again), given(&graph));
        assert_same(&graph, &again);
        graph = again;
    }
}

#[test]
fn levels_are_layouts() {
    let (graph, _) = read(&two_levels());
    let written = write(&graph);
    assert_valid(&written.text);
    assert!(written.text.contains("\"layoutLevelId\": \"upper\""), "{}", written.text);
    let (again, _) = read(&written.text);
    let name = |graph: &RouteGraph| -> Vec<String> {
        graph.nodes().iter().map(|node| format!("{:?} {:?}", node.name(), node.position)).collect()
    };
    assert_eq!(name(&graph), name(&again));
}

#[test]
fn what_is_lost_is_listed() {
    let tags = Tags { zone: Some("z".into()), ..Tags::default() };
    let mut nodes = vec![Node::new(7, DVec2::ZERO, 0.5), Node::new(9, DVec2::X * 4.0, 0.0)];
    nodes[0].tags = tags.boxed();
    let mut edge = Edge::new(
        3,
        NodeIndex(0),
        NodeIndex(1),
        CubicBezier::straight(DVec2::ZERO, DVec2::X * 4.0),
        1.5,
    );
    edge.reverse_speed = Some(0.5);
    let mut tags = Tags::default();
    tags.set("colour", "red");
    tags.set("maxHeight", "2.5");
    tags.set("rotationAtEndNodeAllowed", "sometimes");
    edge.tags = tags.boxed();
    let station = Station {
        name: "S".to_owned(),
        role: Role::Pick,
        nodes: vec![NodeIndex(1)],
        ..Station::default()
    };
    let empty = Station { name: "T".to_owned(), ..Station::default() };
    let graph = RouteGraph::from_valid_parts(nodes, vec![edge])
        .with_surroundings(vec![station, empty], vec![vec![DVec2::ZERO, DVec2::X].into()]);
    let written =
        write_with(&graph, &Header { timestamp: "2024-05-06T07:08:09.00Z", ..Header::default() });
    assert_valid(&written.text);
    assert!(
        written.text.contains("\"exportTimestamp\":\"2024-05-06T07:08:09.00Z\""),
        "{}",
        written.text
    );
    let expected = [
        "1 edge can be driven in reverse gear: written as further edges, which are read as such",
        "1 edge has a property `colour` that isn't valid in LIF",
        "1 edge has a property `rotationAtEndNodeAllowed` that isn't valid in LIF",
        "1 line of the background: LIF has none",
        "1 node has a zone: LIF has none",
        "1 station has another role than their nodes: LIF has only actions of nodes and edges",
        "1 station has no node: LIF has only stations with nodes",
    ];
    assert_eq!(
        written.losses.iter().collect::<std::collections::BTreeSet<_>>(),
        expected.map(String::from).iter().collect()
    );
    let (again, _) = read(&written.text);
    assert_same(&graph, &again);
    assert_eq!(again.nodes().iter().map(|node| node.id).collect::<Vec<_>>(), [7, 9]);
    assert_eq!((again.edges()[0].id, again.edges()[1].id), (3, 4));
}

#[test]
fn names_are_ids_if_all_have_one() {
    let node = |id: u32, name: &str| Node {
        tags: Tags::named(name).boxed(),
        ..Node::new(id, DVec2::X * f64::from(id), 0.0)
    };
    let path = CubicBezier::straight(DVec2::X * 5.0, DVec2::X * 6.0);
    let edge = |id: u32| Edge::new(id, NodeIndex(0), NodeIndex(1), path, 1.0);
    let named = |id: u32, name: &str| Edge { tags: Tags::named(name).boxed(), ..edge(id) };
    let graph = RouteGraph::from_valid_parts(
        vec![node(5, "a"), node(6, "b")],
        vec![edge(1), named(2, "second")],
    );
    let written = write(&graph);
    assert_eq!(written.losses, ["2 numbers of nodes: their names are their ids"]);
    assert!(
        written.text.contains("\"nodeId\":\"a\"")
            && written.text.contains("\"edgeName\":\"second\"")
    );
    let (again, _) = read(&written.text);
    assert_eq!((again.nodes()[0].id, again.nodes()[0].name()), (1, Some("a")));
    assert_eq!((again.edges()[1].id, again.edges()[1].name()), (2, Some("second")));
    let unclear = vec![node(5, "a"), node(6, "a")];
    let (again, _) = read(&write(&RouteGraph::from_valid_parts(unclear, vec![edge(3)])).text);
    assert_eq!((again.nodes()[1].id, again.nodes()[1].name()), (6, Some("a")));
}

#[test]
fn the_number_of_vehicle_types_is_bounded() {
    let types: Vec<String> = (0..101).map(|number| format!("type{number}")).collect();
    let mut tags = Tags::default();
    tags.set("vehicleTypeId", &types.join(", "));
    let mut nodes = vec![Node::new(1, DVec2::ZERO, 0.0), Node::new(2, DVec2::X, 0.0)];
    nodes[0].tags = tags.boxed();
    let path = CubicBezier::straight(DVec2::ZERO, DVec2::X);
    let graph = RouteGraph::from_valid_parts(
        nodes,
        vec![Edge::new(1, NodeIndex(0), NodeIndex(1), path, 1.0)],
    );
    let written = write(&graph);
    assert_eq!(written.text.matches("\"type").count(), 100);
    assert_eq!(written.losses, ["1 node has a property `vehicleTypeId` that isn't valid in LIF"]);
}

#[test]
fn reverse_gears_are_numbered_after_the_last_edge() {
    let nodes = vec![Node::new(1, DVec2::ZERO, 0.0), Node::new(2, DVec2::X, 0.0)];
    let path = CubicBezier::straight(DVec2::ZERO, DVec2::X);
    let edge = |id| Edge {
        reverse_speed: Some(1.0),
        ..Edge::new(id, NodeIndex(0), NodeIndex(1), path, 1.0)
    };
    let (again, _) =
        read(&write(&RouteGraph::from_valid_parts(nodes, [9, 4].map(edge).into())).text);
    assert_eq!(again.edges().iter().map(|edge| edge.id).collect::<Vec<_>>(), [9, 4, 10, 11]);
}

/// Graphs of curves of several cubics, with any orientation and role.
fn graphs() -> impl Strategy<Value = RouteGraph> {
    let angle = || -3.1..3.1f64;
    let point = || (-300.0..300.0f64, -300.0..300.0f64).prop_map(|(x, y)| DVec2::new(x, y));
    let node = (point(), angle(), prop::sample::select(Role::ALL.to_vec()));
    let nodes = prop::collection::vec(node, 2..8);
    let orientation = (0..3, angle()).prop_map(|(kind, angle)| match kind {
        0 => Orientation::Tangential,
        1 => Orientation::Offset(angle),
        _ => Orientation::Fixed(angle),
    });
    let speeds = (0.1..5.0f64, prop::option::of(0.1..5.0f64));
    let edge = (
        any::<[prop::sample::Index; 2]>(),
        prop::collection::vec(point(), 0..12),
        orientation,
        speeds,
    );
    let edges = prop::collection::vec(edge, 1..10);
    let origin = prop_oneof![Just(DVec2::ZERO), Just(DVec2::new(400_000.0, 5_000_000.0))];
    (nodes, edges, origin).prop_map(|(nodes, edges, origin)| {
        let nodes = (1..).zip(nodes).map(|(id, (position, theta, role))| {
            // No two nodes are at the same position.
            Node { role, ..Node::new(id, position + DVec2::X * 700.0 * f64::from(id), theta) }
        });
        let nodes: Vec<Node> = nodes.collect();
        let edges = (1..).zip(edges).map(|(id, (ends, handles, orientation, speeds))| {
            let [from, mut to] = ends.map(|end| end.index(nodes.len()));
            if from == to {
                to = (from + 1) % nodes.len();
            }
            let path = path(nodes[from].position, nodes[to].position, &handles);
            let [from, to] = [from, to].map(|index| NodeIndex(index as u32));
            let (speed, reverse_speed) = speeds;
            Edge { orientation, reverse_speed, ..Edge::new(id, from, to, path, speed) }
        });
        let edges = edges.collect();
        RouteGraph::from_valid_parts(nodes, edges).with_origin(origin)
    })
}

/// Returns cubics through every third of some points.
fn path(from: DVec2, to: DVec2, points: &[DVec2]) -> Path {
    let Some((&[first, second], rest)) = points.split_first_chunk::<2>() else {
        return CubicBezier::straight(from, to).into();
    };
    let mut cubics = Vec::new();
    let mut control_points = [from, first, second, to];
    for chunk in rest.chunks_exact(3) {
        control_points[3] = chunk[0];
        cubics.push(CubicBezier { control_points });
        control_points = [chunk[0], chunk[1], chunk[2], to];
    }
    cubics.push(CubicBezier { control_points });
    Path::from_cubics(&cubics).expect("at least one")
}

proptest! {
    #[test]
    fn graphs_stay_the_same(graph in graphs()) {
        let written = write(&graph);
        assert_valid(&written.text);
        let (again, _) = match parse(&written.text, "test", &options()) {
            Ok(read) => read,
            Err(error) => panic!("{error}\n{:#?}", error.findings()),
        };
        assert_same(&graph, &again);
        let reverse = graph.edges().iter().filter(|edge| edge.reverse_speed.is_some()).count();
        prop_assert_eq!(again.edges().len(), graph.edges().len() + reverse);
        prop_assert!(graph.edges().iter().zip(again.edges()).all(|(edge, other)| edge.id == other.id));
        prop_assert!(again.departures(NodeIndex(0)).iter().all(|leg| leg.gear == Gear::Forward));
    }
}
