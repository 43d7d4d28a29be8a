use std::f64::consts::PI;

use proptest::prelude::*;
use regatta_base::bezier::CubicBezier;
use regatta_base::graph::{NodeIndex, Rotation};

use super::*;
use crate::model::path::Path;
use crate::model::route_graph::{Edge, Node};
use crate::model::tags::Orientation;
use crate::read::open_tcs::tests::{graph, sample};

/// The largest distance of a point that is moved to whole millimetres: half the diagonal of a
/// square millimetre.
const MILLIMETRE: f64 = 0.001;

fn text(path: &Path) -> Vec<[f64; 2]> {
    path.control_points().map(|point| point.to_array()).collect()
}

/// Checks that what is read back is the same within a millimetre.
fn assert_near(written: &RouteGraph, read: &RouteGraph) {
    assert_eq!(written.nodes().len(), read.nodes().len());
    assert_eq!(written.edges().len(), read.edges().len());
    for (a, b) in written.nodes().iter().zip(read.nodes()) {
        assert!(a.position.distance(b.position) < MILLIMETRE, "{} {}", a.position, b.position);
        assert!((a.theta - b.theta).abs() < 1e-9);
        assert_eq!((a.id, a.role, &a.tags), (b.id, b.role, &b.tags));
    }
    for (a, b) in written.edges().iter().zip(read.edges()) {
        assert_eq!(
            (a.id, a.origin, a.destination, a.name()),
            (b.id, b.origin, b.destination, b.name())
        );
        assert_eq!(a.orientation, b.orientation);
        assert!((a.speed - b.speed).abs() <= 0.000_500_1);
        assert_eq!(a.reverse_speed.is_some(), b.reverse_speed.is_some());
        assert_eq!(a.path.cubic_count(), b.path.cubic_count());
        for (p, q) in a.path.control_points().zip(b.path.control_points()) {
            assert!(p.distance(q) < MILLIMETRE, "{:?} {:?}", text(&a.path), text(&b.path));
        }
    }
    for (a, b) in written.stations().iter().zip(read.stations()) {
        assert_eq!((&a.name, a.role, &a.nodes), (&b.name, b.role, &b.nodes));
        assert!(a.position.zip(b.position).is_some_and(|(a, b)| a.distance(b) < MILLIMETRE));
    }
}

#[test]
fn the_samples_are_written_without_losses_and_read_back() {
    for name in ["Demo-01.xml", "PlantModelV7.sample.xml"] {
        let (model, _) = graph(&sample(name));
        let Written { text, losses } = write(&model);
        assert_eq!(losses, [""; 0], "{name}");
        let (again, _) = graph(&text);
        assert_near(&model, &again);
        assert_eq!(model.edges().len(), again.edges().len());
        // The second time nothing changes at all.
        assert_eq!(write(&again).text, text);
    }
}

#[test]
fn the_structure_is_that_of_the_schema() {
    let points = [(1, 0.0), (2, 10.0)].map(|(id, x)| Node::new(id, DVec2::new(x, 0.25), 0.0));
    let path = CubicBezier::straight(points[0].position, points[1].position);
    let edge = Edge::new(1, NodeIndex(0), NodeIndex(1), path, 1.0);
    let edge = Edge { reverse_speed: Some(0.3), ..edge };
    let station = Station {
        name: "<S>".into(),
        role: Role::Charge,
        nodes: vec![NodeIndex(1)],
        ..Station::default()
    };
    let graph = RouteGraph::from_valid_parts(points.into(), vec![edge])
        .with_surroundings(vec![station], vec![vec![].into()]);
    let Written { text, losses } = write(&graph);
    let expected = r##"<?xml version="1.0" encoding="UTF-8" standalone="yes"?>
<model version="7.0.0" name="Regatta">
    <point name="Point-0001" positionX="0" positionY="250" positionZ="0" vehicleOrientationAngle="0" type="HALT_POSITION">
        <maxVehicleBoundingBox length="1000" width="1000" height="1000" referenceOffsetX="0" referenceOffsetY="0"/>
        <outgoingPath name="Point-0001 --- Point-0002"/>
        <property name="regatta:id" value="1"/>
        <pointLayout labelOffsetX="-10" labelOffsetY="-20" layerId="0"/>
    </point>
    <point name="Point-0002" positionX="10000" positionY="250" positionZ="0" vehicleOrientationAngle="0" type="HALT_POSITION">
        <maxVehicleBoundingBox length="1000" width="1000" height="1000" referenceOffsetX="0" referenceOffsetY="0"/>
        <property name="regatta:id" value="2"/>
        <pointLayout labelOffsetX="-10" labelOffsetY="-20" layerId="0"/>
    </point>
    <path name="Point-0001 --- Point-0002" sourcePoint="Point-0001" destinationPoint="Point-0002" length="10000" maxVelocity="1000" maxReverseVelocity="300" locked="false">
        <property name="regatta:id" value="1"/>
        <pathLayout connectionType="DIRECT" layerId="0"/>
    </path>
    <locationType name="Charge station">
        <allowedOperation name="CHARGE"/>
        <locationTypeLayout locationRepresentation="RECHARGE_GENERIC"/>
    </locationType>
    <location name="&lt;S&gt;" positionX="10000" positionY="250" positionZ="0" locked="false" type="Charge station">
        <link point="Point-0002"/>
        <locationLayout labelOffsetX="-10" labelOffsetY="-20" locationRepresentation="DEFAULT" layerId="0"/>
    </location>
    <visualLayout name="VLayout-01" scaleX="50.0" scaleY="50.0">
        <layer id="0" ordinal="0" visible="true" name="Default layer" groupId="0"/>
        <layerGroup id="0" name="Default layer group" visible="true"/>
    </visualLayout>
</model>
"##;
    assert_eq!(text, expected);
    assert_eq!(
        losses,
        [
            "1 background line: this format has none",
            "1 station has no position: drawn at the first node"
        ]
    );
}

#[test]
fn what_the_format_cannot_say_is_listed() {
    let [a, b] = [DVec2::ZERO, DVec2::new(6.0, 0.0004)];
    let mut nodes = vec![Node::new(1, a, 0.0), Node::new(2, b, 0.0)];
    nodes[0].role = Role::Drop;
    nodes[0].tags =
        Tags { level: Some("L1".into()), zone: Some("Z".into()), ..Tags::default() }.boxed();
    let wave = |x: f64| {
        [(x, 0.0), (x + 1.0, 1.0), (x + 1.0, -1.0), (x + 2.0, 0.0)].map(|(x, y)| DVec2::new(x, y))
    };
    let mut cubics = [0.0, 2.0, 4.0].map(|x| CubicBezier { control_points: wave(x) });
    cubics[2].control_points[3] = b;
    let path = Path::from_cubics(&cubics).expect("cubics");
    let mut edge = Edge::new(1, NodeIndex(0), NodeIndex(1), path.clone(), 1.000_04);
    edge.orientation = Orientation::Fixed(1.0);
    edge.rotation.destination = Rotation::None;
    let written = RouteGraph::from_valid_parts(nodes, vec![edge]);
    let Written { text, losses } = write(&written);
    let expected = [
        "1 curve has several cubics: drawn as lines with corners",
        "1 edge has a heading other than along the edge",
        "1 edge prescribes how robots turn at their ends: this format doesn't",
        "1 level is kept as properties `regatta:level`",
        "1 node is moved to whole millimetres",
        "1 node has a role other than park: it is kept as property `regatta:role`",
        "1 speed is rounded to whole mm/s",
        "1 zone is kept as properties `regatta:zone`",
    ];
    assert_eq!(losses, expected);
    let (read, _) = graph(&text);
    assert_eq!(read.nodes()[0].tags, written.nodes()[0].tags);
    assert_eq!(read.nodes()[0].role, Role::Drop);
    let line = &read.edges()[0].path;
    for index in 0..=300 {
        let (point, _) = path.at(f64::from(index) / 300.0);
        let distance = line.cubics().map(|cubic| {
            let (from, along) =
                (cubic.control_points[0], cubic.control_points[3] - cubic.control_points[0]);
            let share = ((point - from).dot(along) / along.length_squared()).clamp(0.0, 1.0);
            point.distance(from + along * share)
        });
        let nearest = distance.fold(f64::INFINITY, f64::min);
        assert!(nearest < 0.006, "{nearest} m at {point}");
    }
}

#[test]
fn blocks_keep_the_members_that_were_listed() {
    let nodes = "Vertices:\n- {Id: 1, X: 0, Y: 0, Theta: 0}\n- {Id: 2, X: 5, Y: 0, Theta: 0}\n\
                 - {Id: 3, X: 10, Y: 0, Theta: 0}\n- {Id: 4, X: 5, Y: 5, Theta: 0}\n";
    let edge = |id: u32, from: u32, to: u32| {
        format!(
            "- {{Id: {id}, Origin_ID: {from}, Destination_ID: {to}, CurveType: Linear, \
             VelocityForward: 1}}\n"
        )
    };
    let edges =
        [edge(1, 1, 2), edge(2, 2, 3), edge(3, 3, 4), edge(4, 4, 1), edge(5, 2, 4)].concat();
    for listed in ["", ", Nodes: [2]"] {
        let zone = format!("- {{Name: Z, Rule: same_direction{listed}, Edges: [1, 2]}}\n");
        let yaml = format!("{nodes}Edges:\n{edges}Zones:\n{zone}");
        let read = |text: &str, name| {
            crate::parse(text, name, &crate::ReadOptions::default()).expect("a graph").0
        };
        let graph = read(&yaml, "plant.yaml");
        assert_eq!(graph.zones()[0].nodes, [NodeIndex(1)]);
        let model = write(&graph).text;
        let members = model.matches("<member name=").count();
        assert_eq!(members, if listed.is_empty() { 2 } else { 3 }, "{model}");
        let again = read(&model, "plant.xml");
        assert_eq!(again.zones(), graph.zones(), "{listed}");
        let yaml_again = crate::write::regatta::write(&again).text;
        let written = format!("Rule: same_direction{listed}, Edges: [1, 2]");
        assert!(yaml_again.contains(&written), "{yaml_again}");
    }
}

#[test]
fn names_are_unique_and_soon_found() {
    let mut taken = Taken::default();
    let names = ["a", "a (3)", "a", "a", "", "", "a (3)"].map(|name| taken.unique(name.to_owned()));
    assert_eq!(names, ["a", "a (3)", "a (2)", "a (4)", " (2)", " (3)", "a (3) (2)"]);
    // Each search from the start would take hours.
    let last = (0..200_000).map(|_| taken.unique("b".to_owned())).last();
    assert_eq!(last.as_deref(), Some("b (200000)"));
}

fn point() -> impl Strategy<Value = DVec2> {
    (-400.0..400.0, -400.0..400.0).prop_map(|(x, y)| DVec2::new(x, y))
}

fn name() -> impl Strategy<Value = Option<Box<Tags>>> {
    prop::option::of("[A-Z<&\"'\n ]{1,3}")
        .prop_map(|name| name.map(|name| Box::new(Tags::named(&name))))
}

/// The inner points of cubics, speeds, whether it is driven tail first, and the name.
type EdgeParts = (Vec<DVec2>, f64, Option<f64>, bool, Option<Box<Tags>>);

fn edge(
    id: u32,
    nodes: &[Node],
    (inner, forward, backwards, is_tail_first, tags): EdgeParts,
) -> Edge {
    let (from, to) = (nodes[id as usize].position, nodes[id as usize + 1].position);
    let cubics = match inner[..] {
        [a, b, middle, c, d, ..] => {
            vec![
                CubicBezier { control_points: [from, a, b, middle] },
                CubicBezier { control_points: [middle, c, d, to] },
            ]
        }
        [a, b, ..] => vec![CubicBezier { control_points: [from, a, b, to] }],
        [corner] => vec![CubicBezier::straight(from, corner), CubicBezier::straight(corner, to)],
        [] => vec![CubicBezier::straight(from, to)],
    };
    let path = Path::from_cubics(&cubics).expect("cubics");
    let backwards = backwards.filter(|_| !is_tail_first);
    let orientation = if is_tail_first { Orientation::Offset(PI) } else { Orientation::Tangential };
    Edge {
        orientation,
        tags,
        reverse_speed: backwards,
        ..Edge::new(id + 7, NodeIndex(id), NodeIndex(id + 1), path, forward)
    }
}

fn graphs() -> impl Strategy<Value = RouteGraph> {
    let role = prop::sample::select(Role::ALL.to_vec());
    let node = (point(), -3.1..3.1, role.clone(), name());
    let speed = || 0.001..50.0;
    let edge_parts = (
        prop::collection::vec(point(), 0..6),
        speed(),
        prop::option::of(speed()),
        any::<bool>(),
        name(),
    );
    let station = (role, 0u32..4, point());
    let parts = (
        prop::collection::vec(node, 4),
        prop::collection::vec(edge_parts, 3),
        prop::collection::vec(station, 0..3),
    );
    parts.prop_map(|(nodes, edges, stations)| {
        let nodes: Vec<_> = (0..)
            .zip(nodes)
            .map(|(id, (position, theta, role, tags))| Node {
                role,
                tags,
                ..Node::new(id * 3, position, theta)
            })
            .collect();
        let edges = (0..).zip(edges).map(|(id, parts)| edge(id, &nodes, parts)).collect();
        let stations = (0..).zip(stations).map(|(id, (role, node, position))| Station {
            name: format!("Point-000{id}"),
            role,
            nodes: vec![NodeIndex(node)],
            position: Some(position),
            ..Station::default()
        });
        RouteGraph::from_valid_parts(nodes, edges).with_surroundings(stations.collect(), Vec::new())
    })
}

/// Files have half a turn with four decimals.
#[test]
fn half_a_turn_with_few_decimals_is_a_path_driven_tail_first() {
    let nodes = [0.0, 6.0].map(|x| DVec2::new(x, 0.0));
    let straight = CubicBezier::straight(nodes[0], nodes[1]);
    let nodes = (1..).zip(nodes).map(|(id, position)| Node::new(id, position, 0.0)).collect();
    let mut edge = Edge::new(1, NodeIndex(0), NodeIndex(1), straight, 0.8);
    edge.orientation = Orientation::Offset((PI * 1e4).round() / 1e4);
    let Written { text, losses } = write(&RouteGraph::from_valid_parts(nodes, vec![edge]));
    assert_eq!(losses, [""; 0]);
    let (read, _) = graph(&text);
    assert_eq!(read.edges()[0].orientation, Orientation::Offset(PI), "{text}");
    assert_eq!((read.edges()[0].speed, read.edges()[0].reverse_speed), (0.8, None), "{text}");
}

#[test]
fn a_length_that_is_a_cost_is_kept() {
    let text = sample("Demo-01.xml").replacen("length=\"6000\"", "length=\"60001\"", 1);
    assert!(text.contains("length=\"60001\""));
    let (model, _) = graph(&text);
    let kept = |graph: &RouteGraph| {
        let lengths = graph
            .edges()
            .iter()
            .filter_map(|edge| edge.tags.as_ref()?.properties.get("opentcs:length").cloned());
        lengths.filter(|length| **length == *"60001").count()
    };
    let written = write(&model);
    assert_eq!(kept(&model), 1);
    assert_eq!(written.text.matches("length=\"60001\"").count(), 1);
    assert_eq!(kept(&graph(&written.text).0), 1);
}

#[test]
fn a_length_of_another_format_stays_a_property() {
    let text = "Vertices:\n- {Id: 1, X: 0, Y: 0, Theta: 0}\n- {Id: 2, X: 5, Y: 0, Theta: 0}\nEdges:\n\
                - {Id: 7, Origin_ID: 1, Destination_ID: 2, CurveType: Linear, VelocityForward: 1, Properties: {length: 7}}\n";
    let (ours, _) = crate::parse(text, "g", &crate::ReadOptions::default()).expect("a graph");
    let written = write(&ours).text;
    assert!(written.contains("length=\"5000\""), "{written}");
    let (back, _) = graph(&written);
    assert_eq!(back.edges()[0].tags.as_ref().expect("tags").properties["length"].as_ref(), "7");
}

#[test]
fn points_without_an_angle_stay_without() {
    let text = sample("Demo-01.xml").replacen(
        "vehicleOrientationAngle=\"NaN\"",
        "vehicleOrientationAngle=\"30.0\"",
        1,
    );
    let (model, _) = graph(&text);
    let written = write(&model).text;
    let count = |text: &str| text.matches("vehicleOrientationAngle=\"NaN\"").count();
    assert!(count(&text) > 0);
    assert_eq!(count(&written), count(&text));
    let given =
        |graph: &RouteGraph| graph.nodes().iter().map(|node| node.has_heading).collect::<Vec<_>>();
    assert_eq!(given(&graph(&written).0), given(&model));
}

/// Removes the property of paths whose length isn't that of their curve.
fn without_lengths(graph: RouteGraph) -> RouteGraph {
    let without = |edge: &Edge| {
        let mut edge = edge.clone();
        edge.tags = edge.tags.and_then(|mut tags| {
            tags.properties.remove("opentcs:length");
            tags.boxed()
        });
        edge
    };
    let edges = graph.edges().iter().map(without).collect();
    RouteGraph::from_valid_parts(graph.nodes().to_vec(), edges)
        .with_surroundings(graph.stations().to_vec(), Vec::new())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(if cfg!(miri) { 2 } else { 256 }))]

    #[test]
    fn any_graph_is_read_back(written in graphs()) {
        let (read, _) = graph(&write(&written).text);
        let read = without_lengths(read);
        assert_near(&written, &read);
        for (a, b) in written.edges().iter().zip(read.edges()) {
            prop_assert_eq!(&a.tags, &b.tags);
        }
    }
}
