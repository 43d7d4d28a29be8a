use std::f64::consts::FRAC_PI_2;
use std::path::Path as FilePath;

use proptest::prelude::*;
use regatta_base::bezier::CubicBezier;

use super::locations::role;
use super::*;
use crate::model::finding::Findings;
use crate::model::options::ReadOptions;
use crate::model::route_graph::{Edge, Node, RouteGraph};
use crate::model::zones::ZoneRule;
use crate::parse;
use crate::read::file::GraphError;

pub(crate) fn sample(name: &str) -> String {
    let folder =
        FilePath::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../graphs/imported/opentcs"));
    std::fs::read_to_string(folder.join(name)).expect("a sample")
}

pub(crate) fn graph(text: &str) -> (RouteGraph, Findings) {
    parse(text, "model.xml", &ReadOptions::default())
        .unwrap_or_else(|error| panic!("{error}\n{text}"))
}

fn node<'graph>(graph: &'graph RouteGraph, name: &str) -> &'graph Node {
    graph.nodes().iter().find(|node| node.name() == Some(name)).expect(name)
}

fn edge<'graph>(graph: &'graph RouteGraph, name: &str) -> &'graph Edge {
    graph.edges().iter().find(|edge| edge.name() == Some(name)).expect(name)
}

/// A model of two points 10 m apart and one path, whose attributes and content are given.
fn model(attributes: &str, content: &str) -> String {
    format!(
        "<model version=\"7.0.0\" name=\"m\">
        <point name=\"A\" positionX=\"0\" positionY=\"0\" positionZ=\"0\" type=\"HALT_POSITION\"/>
        <point name=\"B\" positionX=\"10000\" positionY=\"0\" positionZ=\"0\" type=\"HALT_POSITION\"/>
        <path name=\"P\" sourcePoint=\"A\" destinationPoint=\"B\" length=\"1\" {attributes}>{content}</path>
        <visualLayout name=\"V\" scaleX=\"50.0\" scaleY=\"50.0\"/>
        </model>"
    )
}

#[test]
fn a_speed_that_is_not_a_number_is_an_error() {
    let text = model("maxVelocity=\"1,5\" maxReverseVelocity=\"0\"", "");
    let error = parse(&text, "model.xml", &ReadOptions::default()).expect_err("no number");
    let told = messages(error.findings().expect("findings"));
    assert!(told.contains("path `P`: its maxVelocity is `1,5`: give a number, in mm/s"), "{told}");
}

const ONE_WAY: &str = "maxVelocity=\"1000\" maxReverseVelocity=\"0\" locked=\"false\"";

fn cubics(graph: &RouteGraph, name: &str) -> Vec<[[f64; 2]; 4]> {
    edge(graph, name)
        .path
        .cubics()
        .map(|cubic| cubic.control_points.map(|point| point.to_array()))
        .collect()
}

fn messages(findings: &Findings) -> String {
    findings.as_slice().iter().map(|finding| format!("{finding}\n")).collect()
}

#[test]
fn the_demo_model_is_read() {
    let (graph, findings) = graph(&sample("Demo-01.xml"));
    assert_eq!((graph.nodes().len(), graph.edges().len(), graph.stations().len()), (59, 75, 16));
    assert_eq!(findings.errors(), 0);
    let first = node(&graph, "Point-0001");
    assert_eq!((first.position, first.role), (DVec2::new(31.0, 11.0), Role::None));
    let park = node(&graph, "Point-0002");
    assert_eq!((park.position, park.role), (DVec2::new(25.0, 9.0), Role::Park));
    let priority = park.tags.as_ref().expect("tags").properties.get("tcs:parkingPositionPriority");
    assert_eq!(priority.map(AsRef::as_ref), Some("4"));
    // Control points (610, -180) in units of 50 mm.
    let curve = [[31.0, 11.0], [30.5, 9.0], [30.5, 9.0], [25.0, 9.0]];
    assert_eq!(cubics(&graph, "Point-0001 --- Point-0002"), [curve]);
    let slow = edge(&graph, "Point-0002 --- Point-0004");
    assert_eq!((slow.speed, slow.reverse_speed), (0.5, None));
    assert_eq!(
        slow.path.single(),
        Some(&CubicBezier::straight(DVec2::new(25.0, 9.0), DVec2::new(25.0, 3.0)))
    );
    assert_eq!(slow.tags.as_ref().and_then(|tags| tags.properties.get("opentcs:length")), None);
    assert_eq!(graph.edges().iter().filter(|edge| edge.speed == 0.5).count(), 3);
    assert_eq!(graph.edges().iter().filter(|edge| edge.reverse_speed.is_some()).count(), 0);
    let is_curved = |edge: &&Edge| {
        *edge.path.single().expect("one cubic")
            != CubicBezier::straight(edge.path.start(), edge.path.end())
    };
    assert_eq!(graph.edges().iter().filter(is_curved).count(), 35);
    let zones = |zone: &str| {
        graph
            .edges()
            .iter()
            .filter(|edge| edge.tags.as_ref().and_then(|tags| tags.zone.as_deref()) == Some(zone))
            .count()
    };
    assert_eq!((zones("Block-0002"), zones("Block-0004")), (2, 3));
    let of = |name: &str| graph.zones().iter().find(|zone| *zone.name == *name).expect("a zone");
    assert_eq!((of("Block-0002").edges.len(), of("Block-0004").edges.len()), (2, 3));
}

#[test]
fn the_stations_of_the_demo_model_have_roles() {
    let (graph, findings) = graph(&sample("Demo-01.xml"));
    let station =
        |name: &str| graph.stations().iter().find(|station| station.name == name).expect(name);
    let goods = station("Goods in north 01");
    assert_eq!((goods.role, goods.position), (Role::Transfer, Some(DVec2::new(-28.0, 11.0))));
    assert_eq!(
        goods.nodes.iter().map(|&node| graph.node(node).name()).collect::<Vec<_>>(),
        [Some("Point-0026")]
    );
    assert_eq!(
        goods.properties.get("operations").map(AsRef::as_ref),
        Some("Load cargo, NOP, Unload cargo")
    );
    assert_eq!(station("Recharge 01").role, Role::Charge);
    assert_eq!(
        (station("Fire door 01").role, station("Fire door 01").nodes.len()),
        (Role::None, 0)
    );
    assert_eq!(station("Working station 01").role, Role::None);
    let messages = messages(&findings);
    for ignored in [
        "element `vehicle` of the model",
        "property `loopback:loadOperation` of a vehicle",
        "`vehicleEnvelope`",
    ] {
        assert!(messages.contains(ignored), "{ignored} in\n{messages}");
    }
}

#[test]
fn every_version_has_the_same_shapes() {
    for name in ["PlantModelV004.sample.xml", "PlantModelV6.sample.xml", "PlantModelV7.sample.xml"]
    {
        let (graph, findings) = graph(&sample(name));
        // The seventh path is locked.
        assert_eq!(
            (graph.nodes().len(), graph.edges().len(), graph.stations().len()),
            (15, 6, 2),
            "{name}"
        );
        assert!(
            messages(&findings).contains("path `Point-0013 --- Point-0014` is locked: left out")
        );
        assert!(messages(&findings).contains("location `Location-0002` is locked: no role"));
        let locked = graph.stations().iter().find(|station| station.name == "Location-0002");
        let locked = locked.expect("the location");
        assert_eq!(
            (locked.role, locked.properties.get("locked").map(AsRef::as_ref)),
            (Role::None, Some("true"))
        );
        assert_eq!(node(&graph, "Point-0013").theta, FRAC_PI_2);
        assert_eq!(node(&graph, "Point-0015").role, Role::Park);
        assert_eq!(
            node(&graph, "Point-0013").tags.as_ref().and_then(|tags| tags.zone.as_deref()),
            Some("Block-0001")
        );
        for path in
            ["Point-0001 --- Point-0002", "Point-0003 --- Point-0004", "Point-0005 --- Point-0006"]
        {
            assert_eq!(cubics(&graph, path).len(), 1, "{path}");
        }
        let corners = cubics(&graph, "Point-0007 --- Point-0008")
            .iter()
            .map(|cubic| cubic[3])
            .collect::<Vec<_>>();
        assert_eq!(corners, [[23.0, 6.0], [24.5, 7.5], [25.0, 10.0]]);
        let bezier = [[25.0, 5.0], [27.9, 5.4], [29.45, 6.95], [30.0, 10.0]];
        assert_eq!(cubics(&graph, "Point-0009 --- Point-0010"), [bezier]);
        let two = [
            [[30.0, 5.0], [31.4, 5.5], [30.75, 8.2], [32.95, 7.0]],
            [[32.95, 7.0], [33.9, 6.5], [34.5, 8.0], [35.0, 10.0]],
        ];
        assert_eq!(cubics(&graph, "Point-0011 --- Point-0012"), two);
        assert!(
            messages(&findings).contains("`Point-0007 --- Point-0008`: the curve has a corner of"),
            "{name}"
        );
    }
}

#[test]
fn old_versions_keep_the_drawing_apart() {
    let layout = "<modelLayoutElement visualizedObjectName=\"P\" layer=\"0\">
        <property name=\"CONN_TYPE\" value=\"BEZIER\"/><property name=\"CONTROL_POINTS\" value=\"20,-40;180,-40\"/>
        </modelLayoutElement></visualLayout>";
    let text = model(ONE_WAY, "")
        .replace("scaleY=\"50.0\"/>", &format!("scaleY=\"50.0\">{layout}"))
        .replace("7.0.0", "0.0.2")
        .replace("position", "xPosition")
        .replace("xPositionX", "xPosition")
        .replace("xPositionY", "yPosition")
        .replace("xPositionZ", "zPosition");
    let (graph, _) = graph(&text);
    assert_eq!(cubics(&graph, "P"), [[[0.0, 0.0], [1.0, 2.0], [9.0, 2.0], [10.0, 0.0]]]);
}

#[test]
fn a_path_that_is_drawn_elsewhere_is_moved_turned_and_scaled() {
    let curve =
        "<pathLayout connectionType=\"BEZIER\"><controlPoint x=\"100\" y=\"-20\"/></pathLayout>";
    let place = |x: i32, y: i32| {
        format!("type=\"HALT_POSITION\"><pointLayout positionX=\"{x}\" positionY=\"{y}\"/></point>")
    };
    // Drawn from (5, 0) to (5, 5): half as long, and to the north.
    let text = model(ONE_WAY, curve).replacen("type=\"HALT_POSITION\"/>", &place(5000, 0), 1);
    let text = text.replacen("type=\"HALT_POSITION\"/>", &place(5000, 5000), 1);
    let (graph, findings) = graph(&text);
    let [[from, a, b, to]] = cubics(&graph, "P")[..] else { panic!("one cubic") };
    assert_eq!((from, a, b, to), ([0.0, 0.0], [2.0, 0.0], [2.0, 0.0], [10.0, 0.0]));
    assert!(messages(&findings).contains("1 curved paths are drawn between other places"));
}

#[test]
fn a_path_with_only_a_reverse_speed_is_driven_tail_first() {
    let curve = "<pathLayout connectionType=\"BEZIER\"><controlPoint x=\"20\" y=\"-20\"/><controlPoint x=\"90\" y=\"0\"/></pathLayout>";
    let (graph, _) = graph(&model("maxVelocity=\"0\" maxReverseVelocity=\"300\"", curve));
    let edge = edge(&graph, "P");
    assert_eq!(graph.node(edge.origin).name(), Some("B"));
    assert_eq!((edge.speed, edge.reverse_speed), (0.3, None));
    assert_eq!(edge.orientation, Orientation::Offset(PI));
    assert_eq!(cubics(&graph, "P"), [[[10.0, 0.0], [4.5, 0.0], [1.0, 1.0], [0.0, 0.0]]]);
}

#[test]
fn operations_have_roles() {
    let cases = [
        ("Load cargo", Role::Pick),
        ("PICK_UP", Role::Pick),
        ("unload_cargo", Role::Drop),
        ("Drop", Role::Drop),
        ("CHARGE", Role::Charge),
        ("Recharge", Role::Charge),
        ("discharge", Role::None),
        ("Park", Role::Park),
        ("NOP", Role::None),
    ];
    for (operation, expected) in cases {
        assert_eq!(role(&[operation.to_owned()]), expected, "{operation}");
    }
    let both = ["Unload cargo", "NOP", "Load cargo"].map(str::to_owned);
    assert_eq!(role(&both), Role::Transfer);
}

#[test]
fn what_cannot_be_used_is_reported() {
    let error =
        |text: &str| parse(text, "m.xml", &ReadOptions::default()).expect_err(text).to_string();
    assert!(error("<map/>").contains("the outermost element is `map`, not `model`"));
    assert!(error("<model version=\"7.0.0\" name=\"m\"/>").contains("has no points"));
    assert!(error(&model("maxVelocity=\"0\"", "")).contains("no path that can be driven"));
    assert!(
        error("<?xml version=\"1.0\"?><model>").contains("the file ends inside element `model`")
    );
    assert!(error("<model></point>").contains("m.xml:1: not a route graph"));
    assert!(error(&"<a>".repeat(100)).contains("more than 32 nested ones"));
    let bad_position = model(ONE_WAY, "").replace("positionX=\"10000\"", "positionX=\"ten\"");
    assert!(error(&bad_position).contains("m.xml:3: error: point `B` has no positionX"));
    let unknown = model(ONE_WAY, "").replace("destinationPoint=\"B\"", "destinationPoint=\"C\"");
    assert!(error(&unknown).contains("edge `P` ends at node `C`, which doesn't exist"));
    let bomb = "<!DOCTYPE m [<!ENTITY a \"aaaa\"><!ENTITY b \"&a;&a;\">]><model name=\"&b;\"/>";
    assert!(matches!(
        parse(bomb, "m.xml", &ReadOptions::default()),
        Err(GraphError::Syntax { .. })
    ));
}

#[test]
fn what_is_not_known_is_kept_or_counted() {
    let text = model(
        &format!("{ONE_WAY} routingCost=\"7\""),
        "<foo/><pathLayout connectionType=\"ELBOW\"/>",
    )
    .replace("7.0.0", "9.1");
    let (graph, findings) = graph(&text);
    let properties = &edge(&graph, "P").tags.as_ref().expect("tags").properties;
    assert_eq!(properties.get("routingCost").map(AsRef::as_ref), Some("7"));
    let messages = messages(&findings);
    for message in
        ["version `9.1` isn't", "element `foo` of a path: not used", "corners of ELBOW paths"]
    {
        assert!(messages.contains(message), "{messages}");
    }
}

#[test]
fn long_and_many_blocks_are_bounded() {
    let block = |name: &str| {
        format!("<block name=\"{name}\"><member name=\"P\"/><member name=\"P\"/></block>")
    };
    let with = |blocks: &str| {
        model(ONE_WAY, "").replace("<visualLayout", &format!("{blocks}<visualLayout"))
    };
    let (graph, findings) =
        graph(&with(&(0..30).map(|number| block(&format!("b{number}"))).collect::<String>()));
    let tags = edge(&graph, "P").tags.as_ref().expect("tags");
    assert_eq!((tags.zone.as_deref(), graph.zones().len()), (Some("b0"), 20));
    assert!(graph.zones().iter().all(|zone| zone.rule == ZoneRule::EXCLUSIVE));
    let messages = messages(&findings);
    assert!(
        messages.contains("block whose member is in 20 others: not used (20 times)"),
        "{messages}"
    );
    let error = parse(&with(&block(&"z".repeat(101))), "m.xml", &ReadOptions::default())
        .expect_err("a long name");
    assert!(error.to_string().contains("has a name or a type of more than 100 bytes"), "{error}");
}

#[test]
fn what_locations_get_from_their_types_is_bounded() {
    let value = "v".repeat(20_000);
    let property =
        format!("<property name=\"p\" value=\"{value}\"/><allowedOperation name=\"Load\"/>");
    let locations: String =
        (0..1000).map(|number| format!("<location name=\"l{number}\" type=\"T\"/>")).collect();
    let all = format!("<locationType name=\"T\">{property}</locationType>{locations}<visualLayout");
    let (graph, findings) = graph(&model(ONE_WAY, "").replace("<visualLayout", &all));
    let has = |station: &&crate::model::tags::Station| {
        station.role == Role::Pick && *station.properties["p"] == *value
    };
    assert_eq!(
        (graph.stations().len(), graph.stations().iter().filter(has).count()),
        (1000, (16 << 20) / 20_133)
    );
    let messages = messages(&findings);
    assert!(messages.contains("too many large types and locations: not used ("), "{messages}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(if cfg!(miri) { 2 } else { 64 }))]

    #[test]
    fn no_text_makes_the_reader_panic(at in 0usize..11_000, removed in 0usize..400, inserted in "[<>&\"'/= a-zA-Z0-9-]{0,8}", ends in any::<bool>()) {
        let sample = sample("PlantModelV7.sample.xml");
        let at = sample.floor_char_boundary(at);
        let end = sample.floor_char_boundary(at + removed);
        let rest = if ends { "" } else { &sample[end..] };
        let _ = parse(&format!("{}{inserted}{rest}", &sample[..at]), "m.xml", &ReadOptions { format: Some(crate::Format::OpenTcs), ..ReadOptions::default() });
    }
}
