use std::f64::consts::PI;
use std::path::Path as FilePath;

use proptest::prelude::*;

use super::*;
use crate::model::options::ReadOptions;
use crate::{parse, read};

/// A text without outer white space, such as names in real files, with everything that is special
/// in YAML.
fn texts() -> impl Strategy<Value = String> {
    let words = prop::sample::select(vec![
        "a", "null", "~", "1.0", "- x", "#", ": ", "[[", "}", "'", "\"", "\\", "*", "&",
    ]);
    let characters = prop::sample::select(vec![
        '\n', '\t', '\0', '\u{85}', '\u{2028}', '\u{feff}', '\u{7f}', 'ä', '😀', '%', ',',
    ]);
    let parts = prop_oneof![
        words.prop_map(str::to_owned),
        characters.prop_map(String::from),
        any::<char>().prop_map(String::from)
    ];
    prop::collection::vec(parts, 1..8).prop_map(|parts| parts.concat().trim().to_owned())
}

fn properties() -> impl Strategy<Value = BTreeMap<Box<str>, Box<str>>> {
    prop::collection::btree_map(texts().prop_map(Into::into), texts().prop_map(Into::into), 0..3)
}

fn tags() -> impl Strategy<Value = Option<Box<Tags>>> {
    let text = || {
        prop::option::of(texts().prop_filter("empty", |text| !text.is_empty()).prop_map(Box::from))
    };
    (text(), text(), text(), properties())
        .prop_map(|(name, level, zone, properties)| Tags { name, level, zone, properties }.boxed())
}

fn role() -> impl Strategy<Value = Role> {
    prop::sample::select(Role::ALL.to_vec())
}

/// A point in the range of precise poses.
fn point() -> impl Strategy<Value = DVec2> {
    (-4000.0..4000.0, -4000.0..4000.0).prop_map(|(x, y)| DVec2::new(x, y))
}

fn orientation() -> impl Strategy<Value = Orientation> {
    prop_oneof![
        Just(Orientation::Tangential),
        Just(Orientation::Offset(PI)),
        (0.01..3.0).prop_map(Orientation::Offset),
        (-3.0..3.0).prop_map(Orientation::Fixed),
    ]
}

/// The parts of an edge that don't depend on its ends: inner points of cubics, speeds, orientation,
/// tags.
type EdgeParts = (Vec<DVec2>, f64, Option<f64>, Orientation, Option<Box<Tags>>);

fn edge_parts() -> impl Strategy<Value = EdgeParts> {
    (
        prop::collection::vec(point(), 0..9),
        0.001..50.0,
        prop::option::of(1e-6..50.0),
        orientation(),
        tags(),
    )
}

fn edge(id: u32, nodes: &[Node], parts: EdgeParts) -> Edge {
    let (inner, forward, backwards, orientation, tags) = parts;
    let (from, to) = (nodes[id as usize].position, nodes[id as usize + 1].position);
    let whole = inner.len() / 3 * 3;
    let mut points = vec![from];
    points.extend(&inner[..whole]);
    let cubics: Vec<_> = if whole == 0 {
        vec![CubicBezier::straight(from, to)]
    } else {
        *points.last_mut().expect("a point") = to;
        points
            .windows(4)
            .step_by(3)
            .map(|points| CubicBezier { control_points: [0, 1, 2, 3].map(|i| points[i]) })
            .collect()
    };
    Edge {
        orientation,
        reverse_speed: backwards,
        rotation: Ends {
            origin: Rotation::ALL[id as usize % 4],
            destination: Rotation::ALL[(id as usize + 1) % 4],
        },
        tags,
        ..Edge::new(
            id * 7 + 3,
            NodeIndex(id),
            NodeIndex(id + 1),
            Path::from_cubics(&cubics).expect("cubics"),
            forward,
        )
    }
}

fn background() -> impl Strategy<Value = Vec<BackgroundLine>> {
    let level = prop::option::of(texts().prop_filter("empty", |text| !text.is_empty()));
    let line = (prop::collection::vec(point(), 2..6), level);
    let line = line.prop_map(|(points, level)| BackgroundLine {
        points,
        level: level.map(String::into_boxed_str),
    });
    prop::collection::vec(line, 0..4)
}

pub fn graphs() -> impl Strategy<Value = RouteGraph> {
    let node = (point(), -3.1..3.1, role(), tags());
    let station = (
        role(),
        prop::collection::btree_set(0u32..4, 0..3),
        prop::option::of(point()),
        properties(),
    );
    let stations = prop::collection::btree_map(texts(), station, 0..3);
    let (nodes, edges) = (prop::collection::vec(node, 4), prop::collection::vec(edge_parts(), 3));
    (nodes, edges, stations, background()).prop_map(|(nodes, edges, stations, background)| {
        let nodes: Vec<_> = (0..)
            .zip(nodes)
            .map(|(id, (position, theta, role, tags))| Node {
                role,
                tags,
                ..Node::new(id * 5, position, theta)
            })
            .collect();
        let edges = (0..).zip(edges).map(|(id, parts)| edge(id, &nodes, parts)).collect();
        let stations = stations.into_iter().filter(|(name, _)| !name.is_empty());
        let stations = stations
            .map(|(name, (role, nodes, position, properties))| Station {
                name,
                role,
                nodes: nodes.into_iter().map(NodeIndex).collect(),
                position,
                properties,
            })
            .collect();
        RouteGraph::from_valid_parts(nodes, edges).with_surroundings(stations, background)
    })
}

fn assert_equal(written: &RouteGraph, read: &RouteGraph) {
    assert_eq!(written.nodes(), read.nodes());
    assert_eq!(written.edges(), read.edges());
    assert_eq!(written.stations(), read.stations());
    assert_eq!(written.background(), read.background());
    assert_eq!(written.origin(), read.origin());
}

fn round_trip(graph: &RouteGraph) -> RouteGraph {
    let Written { text, losses } = write(graph);
    assert_eq!(losses, [""; 0]);
    match parse(&text, "written.yaml", &ReadOptions::default()) {
        Ok((read, _)) => read,
        Err(error) => panic!("{error}\n{text}"),
    }
}

#[test]
fn the_shipped_graphs_are_read_back() {
    let folder = FilePath::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../graphs"));
    for name in ["square.yaml", "porto.yaml", "warehouse.yaml"] {
        let (graph, _) = read(&folder.join(name), &ReadOptions::default()).expect("a graph");
        assert_equal(&graph, &round_trip(&graph));
    }
}

#[test]
fn each_item_is_one_line() {
    let nodes = vec![Node::new(1, DVec2::ZERO, 0.0), Node::new(2, DVec2::X, 0.0)];
    let mut edge =
        Edge::new(5, NodeIndex(0), NodeIndex(1), CubicBezier::straight(DVec2::ZERO, DVec2::X), 0.5);
    edge.reverse_speed = Some(0.25);
    edge.tags = Some(Tags::named("A \"1\"\n").into());
    let background = vec![vec![DVec2::ZERO, DVec2::Y].into()];
    let graph =
        RouteGraph::from_valid_parts(nodes, vec![edge]).with_surroundings(Vec::new(), background);
    let Written { text, losses } = write(&graph);
    let expected = "\
        # 1 edges, 2 nodes; metres, radians, metres per second.\n\
        Edges:\n\
        - {Id: 5, Origin_ID: 1, Destination_ID: 2, CurveType: Linear, VelocityForward: 0.5, VelocityBackwards: 0.25, \
        Name: \"A \\\"1\\\"\\x0A\"}\n\
        \n\
        Vertices:\n\
        - {Id: 1, X: 0.0, Y: 0.0, Theta: 0.0}\n\
        - {Id: 2, X: 1.0, Y: 0.0, Theta: 0.0}\n\
        \n\
        Background:\n\
        - {Line: [[0.0, 0.0], [0.0, 1.0]]}\n";
    assert_eq!(text, expected);
    assert_eq!(losses, ["1 text has white space at an end, which isn't kept"]);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(if cfg!(miri) { 2 } else { 256 }))]

    #[test]
    fn any_graph_is_read_back(graph in graphs()) {
        assert_equal(&graph, &round_trip(&graph));
    }

    #[test]
    fn far_graphs_are_read_back(graph in graphs()) {
        // Coordinates as they come from a file: multiples of the spacing of numbers at the origin.
        let far = round_trip(&graph.with_origin(DVec2::new(-512_345.0, 5_400_000.0)));
        prop_assert!(far.origin() != DVec2::ZERO);
        assert_equal(&far, &round_trip(&far));
    }
}

#[test]
fn doors_and_lifts_are_read_as_they_were_written() {
    let folder = FilePath::new(env!("CARGO_MANIFEST_DIR")).join("../../graphs/imported/open-rmf");
    let options = ReadOptions::default();
    let file = folder.join("hotel.building.yaml");
    let text = std::fs::read_to_string(file).expect("the sample");
    let (graph, _) = parse(&text, "hotel.yaml", &options).expect("a building");
    let (again, _) = parse(&write(&graph).text, "hotel.yaml", &options).expect("our own format");
    assert_eq!((again.doors(), again.lifts()), (graph.doors(), graph.lifts()));
    assert!(!graph.doors().is_empty() && !graph.lifts().is_empty());
    assert_eq!(again.zones(), graph.zones());
    assert_eq!(again.background(), graph.background());
    assert!(graph.background().iter().any(|line| line.level.is_some()));
}
