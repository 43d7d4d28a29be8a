//! The official examples, files that break the specification, and graphs that are written and read
//! again.

mod round_trip;
mod version_2;

use std::f64::consts::{FRAC_PI_2, PI};

use glam::DVec2;
use proptest::prelude::*;

use crate::model::finding::Findings;
use crate::model::format::Format;
use crate::model::options::ReadOptions;
use crate::model::route_graph::RouteGraph;
use crate::model::tags::{OTHER_VEHICLE_TYPES, Orientation, Role, VEHICLE_TYPES};
use crate::parse;
use crate::write::write;

const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../graphs/imported/lif/");

fn sample(name: &str) -> String {
    std::fs::read_to_string(format!("{FOLDER}{name}")).expect("the sample exists")
}

fn options() -> ReadOptions {
    ReadOptions { format: Some(Format::Lif), ..ReadOptions::default() }
}

fn read(text: &str) -> (RouteGraph, Findings) {
    read_with(text, &options())
}

fn read_with(text: &str, options: &ReadOptions) -> (RouteGraph, Findings) {
    parse(text, "test.lif.json", options)
        .unwrap_or_else(|error| panic!("{error}\n{:#?}", error.findings()))
}

/// Returns the errors of a text, one line each.
fn errors(text: &str, options: &ReadOptions) -> String {
    let error = parse(text, "test.lif.json", options).expect_err("an error");
    match error.findings() {
        Some(findings) => messages(findings),
        None => error.to_string(),
    }
}

fn messages(findings: &Findings) -> String {
    findings.as_slice().iter().map(|finding| format!("{finding}\n")).collect()
}

fn node(id: &str, x: f64, y: f64, properties: &str) -> String {
    format!(
        r#"{{"nodeId": "{id}", "nodePosition": {{"x": {x}, "y": {y}}},
            "vehicleTypeNodeProperties": [{{"vehicleTypeId": "A"{properties}}}]}}"#
    )
}

fn edge(id: &str, ends: [&str; 2], properties: &str) -> String {
    format!(
        r#"{{"edgeId": "{id}", "startNodeId": "{}", "endNodeId": "{}",
            "vehicleTypeEdgeProperties": [{{"vehicleTypeId": "A"{properties}}}]}}"#,
        ends[0], ends[1]
    )
}

fn layout(names: &str, nodes: &[String], edges: &[String]) -> String {
    format!("{{{names}, \"nodes\": [{}], \"edges\": [{}]}}", nodes.join(",\n"), edges.join(",\n"))
}

fn file(layouts: &[String]) -> String {
    format!("{{\"layouts\": [{}]}}", layouts.join(",\n"))
}

/// Returns a file with two nodes, ten metres apart, and one edge with these properties.
fn one_edge(properties: &str) -> String {
    let nodes = [node("1", 0.0, 0.0, ""), node("2", 10.0, 0.0, "")];
    file(&[layout("\"layoutId\": \"L\"", &nodes, &[edge("1", ["1", "2"], properties)])])
}

#[test]
fn messages_name_the_edge() {
    let nodes = [node("1", 0.0, 0.0, ""), node("2", 4.0, 0.0, "")];
    let edges = [edge("there", ["1", "2"], ", \"maxSpeed\": -1"), edge("back", ["2", "1"], "")];
    let text = file(&[layout("\"layoutId\": \"L\"", &nodes, &edges)]);
    let found = messages(&read(&text).1);
    assert!(found.contains("isn't above 0: read as no limit (edge `there`)"), "{found}");
    let slow = text.replace("\"vehicleTypeId\"", "\"maxSpeed\": 0, \"vehicleTypeId\"");
    let slow = slow.replace(", \"maxSpeed\": -1", "");
    let found = messages(&read(&slow).1);
    assert!(found.contains("read as no limit (2 times, first at edge `there`)"), "{found}");
    let cut = text.replace("\"startNodeId\": \"2\",", "");
    let found = errors(&cut, &options());
    assert!(found.contains("no `endNodeId`: give it both (edge `back`)"), "{found}");
}

#[test]
fn every_official_example_is_read() {
    let expected = [
        ("ex_10_1", 2, 1, 0),
        ("ex_10_2", 2, 2, 0),
        ("ex_10_3", 2, 2, 0),
        ("ex_10_4", 2, 2, 0),
        ("ex_10_7", 5, 6, 1),
        ("ex_10_10", 6, 6, 1),
        ("ex_10_12", 3, 3, 0),
        ("ex_10_13", 2, 2, 1),
        ("ex_10_16", 4, 6, 3),
        ("ex_10_17", 2, 2, 0),
    ];
    for (name, nodes, edges, stations) in expected {
        let text = sample(&format!("{name}.lif.json"));
        let (graph, findings) = parse(&text, name, &ReadOptions::default()).expect(name);
        let counts = (graph.nodes().len(), graph.edges().len(), graph.stations().len());
        assert_eq!(counts, (nodes, edges, stations), "{name}");
        let messages = messages(&findings);
        let mut unused = messages.lines().filter(|line| line.contains("not used"));
        assert!(
            unused.all(|line| line.contains("of a layout") || line.contains("`metaInf")),
            "{name}: {messages}"
        );
    }
}

#[test]
fn positions_and_orientations_of_an_example_are_those_of_the_file() {
    let (graph, findings) = read(&sample("ex_10_4.lif.json"));
    assert_eq!(graph.nodes()[1].position, DVec2::new(11.0, 0.0));
    assert_eq!(graph.nodes()[1].name(), Some("N2"));
    assert_eq!(graph.edges()[0].orientation, Orientation::Offset(FRAC_PI_2));
    assert_eq!(graph.edges()[1].orientation, Orientation::Offset(-FRAC_PI_2));
    let tags = graph.edges()[0].tags.as_ref().expect("tags");
    assert_eq!(tags.name.as_deref(), Some("N1-N2"));
    assert_eq!(tags.properties["rotationAllowed"].as_ref(), "true");
    assert_eq!(tags.properties["rotationAtStartNodeAllowed"].as_ref(), "NONE");
    // Robots drive sideways: they keep the heading π/2 in both directions.
    assert!(graph.nodes().iter().all(|node| (node.theta - FRAC_PI_2).abs() < 1e-12));
    assert!(messages(&findings).contains("2 edges have no speed limit"), "{}", messages(&findings));
}

#[test]
fn speeds_and_roles_of_an_example_are_those_of_the_file() {
    let (graph, _) = read(&sample("ex_10_12.lif.json"));
    let speeds: Vec<f64> = graph.edges().iter().map(|edge| edge.speed).collect();
    assert_eq!(speeds, [1.0, 0.8, 0.3]);
    assert_eq!(graph.edges()[0].orientation, Orientation::Offset(PI));
    assert_eq!(graph.nodes()[0].role, Role::Charge);
    let tags = graph.edges()[2].tags.as_ref().expect("tags");
    let restriction = r#"{"loadSetNames":["Unstable_Load_Unit"],"loaded":true,"unloaded":false}"#;
    assert_eq!(tags.properties["loadRestriction"].as_ref(), restriction);
}

#[test]
fn stations_of_an_example_have_the_roles_of_their_nodes() {
    let (graph, findings) = read(&sample("ex_10_16.lif.json"));
    let stations: Vec<_> =
        graph.stations().iter().map(|station| (station.name.as_str(), station.role)).collect();
    let expected =
        [("S01_Level_A", Role::Pick), ("S01_Level_B", Role::Drop), ("S01_Level_C", Role::Transfer)];
    assert_eq!(stations, expected);
    assert_eq!(graph.stations()[1].properties["stationHeight"].as_ref(), "2.5");
    assert_eq!(graph.node(graph.stations()[1].nodes[0]).name(), Some("NB"));
    assert!(!messages(&findings).contains("several roles"), "{}", messages(&findings));
}

#[test]
fn a_curve_that_does_not_start_at_its_node_is_connected() {
    let (graph, findings) = read(&sample("ex_10_17.lif.json"));
    let path = &graph.edges()[0].path;
    assert_eq!(
        (path.cubic_count(), path.start(), path.end()),
        (4, DVec2::X * 5.0, DVec2::X * 15.0)
    );
    // A straight segment comes first; then the quadratic from (0, 0) to (3.6, 0) over (1.8, 1.8).
    assert!(path.at(0.5).0.distance(DVec2::splat(1.8)) < 1e-12);
    let messages = messages(&findings);
    assert!(
        messages
            .contains("test.lif.json:43: warning: edge 1: `N1-N2`: its curve has a gap of 5.000 m"),
        "{messages}"
    );
}

#[test]
fn numbers_may_be_texts_and_orientations_global() {
    let properties =
        r#", "maxSpeed": "1.5", "vehicleOrientation": " 1.25 ", "orientationType": "global""#;
    let (graph, findings) = read(&one_edge(properties));
    assert_eq!(
        (graph.edges()[0].speed, graph.edges()[0].orientation),
        (1.5, Orientation::Fixed(1.25))
    );
    assert_eq!((graph.edges()[0].id, graph.edges()[0].name()), (1, None));
    assert!(
        messages(&findings).contains(
            "written as a text, in quotes: read as a number (2 times, first at edge `1`)"
        )
    );
}

#[test]
fn an_illegal_trajectory_is_read_as_straight() {
    let cases = [
        (
            r#"{"degree": 3, "knotVector": [0, 1], "controlPoints": [{"x": 0, "y": 0}]}"#,
            "1 control points: degree 3 needs",
        ),
        (
            r#"{"knotVector": [0, 1], "controlPoints": [{"x": 0, "y": 0}, {"x": 10, "y": 0}]}"#,
            "2 knots: 4 are needed",
        ),
        (r#"{"degree": 2.5}"#, "the degree is 2.5"),
        (r#"{"degree": 1e300}"#, "the degree is 1"),
        (r#"{"controlPoints": [{"x": 0}]}"#, "no x or no y"),
        (r#"{"knotVector": ["a"]}"#, "a knot isn't a number"),
    ];
    for (trajectory, expected) in cases {
        let (graph, findings) =
            read(&one_edge(&format!(", \"maxSpeed\": 1, \"trajectory\": {trajectory}")));
        assert_eq!(graph.edges()[0].path.at(0.5).0, DVec2::X * 5.0);
        let messages = messages(&findings);
        assert!(messages.contains(expected) && messages.contains("read as straight"), "{messages}");
    }
}

#[test]
fn rational_and_quintic_trajectories_are_read() {
    let arc = r#", "trajectory": {"degree": 2, "knotVector": [0, 0, 0, 1, 1, 1], "controlPoints":
        [{"x": 0, "y": 0}, {"x": 5, "y": 5, "weight": 0.7071067811865476}, {"x": 10, "y": 0}]}"#;
    let (graph, _) = read(&one_edge(arc));
    let centre = DVec2::new(5.0, -5.0);
    for step in 0..=100u32 {
        let radius = graph.edges()[0].path.at(f64::from(step) / 100.0).0.distance(centre);
        assert!((radius - 50.0_f64.sqrt()).abs() < 0.001, "{radius}");
    }
    let quintic = r#", "trajectory": {"degree": "5", "knotVector": [0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1], "controlPoints":
        [{"x": 0, "y": 0}, {"x": 2, "y": 0}, {"x": 4, "y": 0}, {"x": 6, "y": 2}, {"x": 8, "y": 2}, {"x": 10, "y": 0}]}"#;
    let (graph, _) = read(&one_edge(quintic));
    // The Bernstein polynomials at 1/2 are 1, 5, 10, 10, 5, 1 thirty-seconds.
    let middle = DVec2::new(5.0, 30.0 / 32.0);
    let path = &graph.edges()[0].path;
    let distances = (0..=4000u32).map(|step| path.at(f64::from(step) / 4000.0).0.distance(middle));
    assert!(distances.fold(f64::INFINITY, f64::min) < 0.003);
}

#[test]
fn one_cause_is_one_error() {
    let nodes =
        [node("1", 0.0, 0.0, "").replace("\"x\": 0", "\"x\": \"abc\""), node("2", 10.0, 0.0, "")];
    let edges = [edge("1", ["1", "2"], ""), edge("2", ["2", "1"], "")];
    let found = errors(&file(&[layout("\"layoutId\": \"L\"", &nodes, &edges)]), &options());
    assert_eq!(found.matches(": error: ").count(), 1, "{found}");
    assert!(
        found.contains("node `1` has no `nodePosition`") && !found.contains("doesn't exist"),
        "{found}"
    );
    let found = errors("{\"layouts\": []}", &options());
    assert_eq!(found.matches(": error: ").count(), 1, "{found}");
}

#[test]
fn values_of_the_wrong_type_are_one_warning_with_their_number() {
    let nodes = [node("1", 0.0, 0.0, ""), node("2", 10.0, 0.0, "")];
    let edge = |id, ends| edge(id, ends, ", \"maxSpeed\": 1, \"vehicleOrientation\": \"left\"");
    let edges = [edge("1", ["1", "2"]), edge("2", ["2", "1"])];
    let (_, findings) = read(&file(&[layout("\"layoutId\": \"L\"", &nodes, &edges)]));
    let messages = messages(&findings);
    assert_eq!(messages.matches("vehicleOrientation").count(), 1, "{messages}");
    assert!(
        messages.contains("isn't a number: not used (2 times, first at edge `1`)"),
        "{messages}"
    );
}

#[test]
fn a_file_of_ours_has_no_findings() {
    let (graph, _) = read(&one_edge(", \"maxSpeed\": 1"));
    let (_, findings) = read(&crate::write::lif::write(&graph).text);
    let messages = messages(&findings);
    assert!(!messages.contains("not used"), "{messages}");
}

#[test]
fn another_format_than_the_named_one_is_told() {
    let lif = ReadOptions { format: Some(Format::Lif), ..options() };
    let error =
        parse("<model version=\"7.0.0\"/>", "plant.xml", &lif).expect_err("XML").to_string();
    assert!(
        error.ends_with("the content looks like opentcs, not lif: leave the format out"),
        "{error}"
    );
}

#[test]
fn angles_in_degrees_are_suspected() {
    let (_, findings) =
        read(&one_edge(r#", "vehicleOrientation": 180, "orientationType": "GLOBAL""#));
    assert!(messages(&findings).contains("LIF has radians"), "{}", messages(&findings));
}

fn two_levels() -> String {
    let nodes = |y: f64| [node("1", 0.0, y, ""), node("2", 10.0, y, "")];
    let names = r#""layoutId": "ground", "layoutName": "Ground floor", "layoutLevelId": "0""#;
    let mut first = nodes(0.0).to_vec();
    first.push(node("lift", 5.0, 5.0, ""));
    let edges = [edge("1", ["1", "2"], ""), edge("up", ["2", "top"], "")];
    let ground = layout(names, &first, &edges);
    let mut second = nodes(20.0).to_vec();
    second.push(node("top", 5.0, 15.0, ""));
    let upper = layout(r#""layoutId": "upper""#, &second, &[edge("1", ["1", "2"], "")]);
    file(&[ground, upper])
}

#[test]
fn layouts_that_use_the_same_ids_do_not_clash() {
    let (graph, findings) = read(&two_levels());
    let names: Vec<_> = graph.nodes().iter().filter_map(|node| node.name()).collect();
    assert_eq!(names, ["ground/1", "ground/2", "lift", "upper/1", "upper/2", "top"]);
    let edges: Vec<_> = graph.edges().iter().filter_map(|edge| edge.name()).collect();
    assert_eq!(edges, ["ground/1", "up", "upper/1"]);
    assert_eq!(graph.edges()[2].path.start(), DVec2::Y * 20.0);
    assert_eq!(
        graph.nodes()[5].tags.as_ref().and_then(|tags| tags.level.as_deref()),
        Some("upper")
    );
    let messages = messages(&findings);
    assert!(messages.contains("the 2 layouts `0`, `upper` lie in one plane"), "{messages}");
    assert!(messages.contains("2 ids of nodes, such as `1`"), "{messages}");
}

#[test]
fn one_level_can_be_read() {
    for level in ["ground", "Ground floor", "0"] {
        let (graph, findings) =
            read_with(&two_levels(), &ReadOptions { level: Some(level.to_owned()), ..options() });
        let names: Vec<_> = graph.nodes().iter().filter_map(|node| node.name()).collect();
        assert_eq!((names, graph.edges().len()), (vec!["1", "2", "lift"], 1));
        assert!(
            messages(&findings).contains("leads to a layout that isn't read"),
            "{}",
            messages(&findings)
        );
    }
    let unknown =
        errors(&two_levels(), &ReadOptions { level: Some("cellar".to_owned()), ..options() });
    assert!(
        unknown.contains("no layout is named `cellar`: the file has `0`, `upper`"),
        "{unknown}"
    );
}

#[test]
fn the_first_vehicle_type_is_read_or_the_chosen_one() {
    let properties = r#", "maxSpeed": 2.0}, {"vehicleTypeId": "B", "maxSpeed": 0.5"#;
    let text = one_edge(properties);
    let (graph, findings) = read(&text);
    assert_eq!(graph.edges()[0].speed, 2.0);
    let messages = messages(&findings);
    assert!(
        messages.contains("vehicle types differ") && messages.contains("those of `A` are used"),
        "{messages}"
    );
    let properties = &graph.edges()[0].tags.as_ref().expect("tags").properties;
    assert_eq!([VEHICLE_TYPES, OTHER_VEHICLE_TYPES].map(|key| &*properties[key]), ["A", "B"]);
    // A type must not get the properties of another one.
    let written = write(&graph, Format::Lif).expect("LIF");
    assert!(!written.text.contains("\"B\""), "{}", written.text);
    let loss = "1 edge has other properties for other vehicle types: not kept";
    assert_eq!(written.losses, [loss]);
    let same = read(&one_edge(r#"}, {"vehicleTypeId": "B""#)).0;
    let properties = &same.edges()[0].tags.as_ref().expect("tags").properties;
    assert_eq!(&*properties[VEHICLE_TYPES], "A, B");
    let choose = |name: &str| ReadOptions { vehicle_type: Some(name.to_owned()), ..options() };
    assert_eq!(read_with(&text, &choose("B")).0.edges()[0].speed, 0.5);
    let unknown = errors(&text, &choose("C"));
    assert!(unknown.contains("no vehicle type is named `C`: the file has `A`, `B`"), "{unknown}");
}

#[test]
fn an_edge_for_another_vehicle_type_is_told() {
    let nodes = [node("1", 0.0, 0.0, ""), node("2", 10.0, 0.0, "")];
    let edges = [edge("1", ["1", "2"], ""), edge("2", ["2", "1"], "").replace("\"A\"", "\"B\"")];
    let (graph, findings) = read(&file(&[layout("\"layoutId\": \"L\"", &nodes, &edges)]));
    let messages = messages(&findings);
    assert_eq!(graph.edges().len(), 2);
    assert!(messages.contains("not for the vehicle type `A`, but read all the same"), "{messages}");
}

#[test]
fn actions_on_an_edge_are_those_of_its_end() {
    let (graph, _) =
        read(&one_edge(r#", "actions": [{"actionType": "Pick", "blockingType": "HARD"}]"#));
    assert_eq!((graph.nodes()[0].role, graph.nodes()[1].role), (Role::None, Role::Pick));
}

#[test]
fn what_is_not_understood_is_counted_or_kept() {
    let (graph, findings) =
        read(&one_edge(r#", "colour": "red", "shape": {"a": 1}, "maxSpeed": null"#));
    let tags = graph.edges()[0].tags.as_ref().expect("tags");
    assert_eq!(tags.properties["colour"].as_ref(), "red");
    let expected = "key `shape` of an element of `vehicleTypeEdgeProperties`: not used";
    assert!(messages(&findings).contains(expected), "{}", messages(&findings));
}

#[test]
fn what_is_said_of_the_file_and_its_layouts_is_listed() {
    let names = r#""layoutId": "L", "layoutVersion": "7", "layoutDescription": "x", "odd": {"a": 1}, "layoutName": """#;
    let nodes = [node("1", 0.0, 0.0, ""), node("2", 10.0, 0.0, "")];
    let text = file(&[layout(names, &nodes, &[edge("1", ["1", "2"], "")])]);
    let text =
        text.replacen('{', r#"{"metaInformation": {"creator": "me", "lifVersion": "1.0.0"}, "#, 1);
    let messages = messages(&read(&text).1);
    for key in ["layoutId", "layoutVersion", "layoutDescription", "odd"] {
        assert!(
            messages.contains(&format!("key `{key}` of a layout: not used")),
            "{key}: {messages}"
        );
    }
    assert!(messages.contains("key `creator` of `metaInformation`: not used"), "{messages}");
    assert_eq!(messages.matches("not used").count(), 5, "{messages}");
}

#[test]
fn files_of_no_use_say_what_to_do() {
    let cases = [
        ("{}", "a LIF file has `metaInformation`, and `layouts`"),
        ("[]", "invalid type"),
        ("{\"layouts\": 3}", "a LIF file has"),
        ("{\"layouts\": []}", "`layouts` is empty: add a layout"),
        ("{\"layouts\": [3]}", "a layout is expected here"),
        ("{\"layouts\": [{\"nodes\": [{}]}]}", "a node has no `nodeId`: give it one"),
        ("{\"layouts\": [{\"nodes\": [{\"nodeId\": 1}]}]}", "node `1` has no `nodePosition`"),
        ("{\"layouts\": [{\"edges\": [{\"edgeId\": 1}]}]}", "no `startNodeId` or no `endNodeId`"),
        ("{\"layouts\": [{\"nodes\": {}}]}", "`nodes` of a layout isn't a list"),
        ("{\"layouts\": [{\n\"nodes\": [\n", "test.lif.json:3: not a route graph"),
    ];
    for (text, expected) in cases {
        let found = errors(text, &options());
        assert!(found.contains(expected), "{text}: {found}");
    }
}

#[test]
fn long_names_of_layouts_are_refused() {
    let name = "n".repeat(101);
    for key in ["layoutId", "layoutName", "layoutLevelId"] {
        let text = one_edge("").replace("\"layoutId\": \"L\"", &format!("\"{key}\": \"{name}\""));
        let found = errors(&text, &options());
        assert!(
            found.contains(&format!("`{key}` of a layout is longer than 100 bytes")),
            "{found}"
        );
        read(&text.replace(&name, &name[1..]));
    }
}

#[test]
fn messages_have_only_the_start_of_long_ids() {
    let long = "i".repeat(1000);
    let edges = [edge("e", ["1", &long], "")];
    let text = file(&[layout("\"layoutLevelId\": \"L\"", &[node("1", 0.0, 0.0, "")], &edges)]);
    let found = errors(&text, &options());
    assert!(found.contains("ends at node `iiii") && found.len() < 300, "{found}");
    let station =
        format!(r#""stations": [{{"stationId": "{long}", "interactionNodeIds": ["7"]}}], "nodes""#);
    let (_, findings) = read(&one_edge("").replacen("\"nodes\"", &station, 1));
    let messages = messages(&findings);
    assert!(
        messages.contains("names node `7`, which doesn't exist") && messages.len() < 600,
        "{messages}"
    );
}

proptest! {
    #[test]
    fn damaged_files_never_panic(
        cut in 0.0..1.0f64,
        changes in prop::collection::vec((0.0..1.0f64, prop::sample::select(b"0123456789-.eE,:{}[]\"nN ".to_vec())), 0..6),
        name in prop::sample::select(vec!["ex_10_7", "ex_10_12", "ex_10_16", "ex_10_17"]),
        truncate in any::<bool>(),
    ) {
        let mut bytes = sample(&format!("{name}.lif.json")).into_bytes();
        let count = bytes.len() as f64;
        for (at, byte) in changes {
            bytes[(at * count) as usize] = byte;
        }
        if truncate {
            bytes.truncate((cut * count) as usize);
        }
        if let Ok(text) = String::from_utf8(bytes) {
            let _ = parse(&text, "test.lif.json", &options());
        }
    }
}
