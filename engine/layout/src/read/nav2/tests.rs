use std::f64::consts::PI;

use proptest::prelude::*;

use super::*;
use crate::model::finding::Findings;
use crate::model::format::Format;
use crate::model::route_graph::RouteGraph;
use crate::model::tags::{Orientation, Role};
use crate::parse;
use crate::read::file::GraphError;
use crate::write::nav2::write;

fn sample(name: &str) -> String {
    let path = format!("{}/../../graphs/imported/nav2/{name}", env!("CARGO_MANIFEST_DIR"));
    std::fs::read_to_string(&path).expect(&path)
}

fn messages(findings: &Findings) -> String {
    findings.as_slice().iter().map(|finding| format!("{finding}\n")).collect()
}

fn graph_of(text: &str) -> (RouteGraph, String) {
    let (graph, findings) = parse(text, "graph", &ReadOptions::default()).expect("a graph");
    (graph, messages(&findings))
}

fn errors_of(text: &str) -> String {
    let options = ReadOptions { format: Some(Format::Nav2), ..ReadOptions::default() };
    match parse(text, "graph", &options) {
        Err(GraphError::Invalid(findings)) => messages(&findings),
        Err(other) => other.to_string(),
        Ok(_) => String::new(),
    }
}

fn layout_of(text: &str) -> Layout {
    let mut report = Report::new("graph", text);
    let source = Source { text, folder: std::path::Path::new(""), stem: "graph" };
    let layout = read(source, &ReadOptions::default(), &mut report).expect("a graph");
    assert_eq!(messages(&report.into_findings()).matches("error").count(), 0);
    layout
}

#[test]
fn every_sample_is_read() {
    // The loop of the AWS graph is dropped, and the six repeated ids of the TurtleBot 4 graph are
    // replaced.
    let cases = [
        ("aws_graph.geojson", 40, 83, "edge `112`: it starts and ends at the same node"),
        ("error_codes.geojson", 13, 1, "no speed limit"),
        ("sample_graph.geojson", 9, 24, "edge `9`: `speed_limit` is a share"),
        ("turtlebot4_graph.geojson", 34, 78, "and 5 more: its id is missing or given twice"),
    ];
    for (name, nodes, edges, message) in cases {
        let (graph, messages) = graph_of(&sample(name));
        assert_eq!((graph.nodes().len(), graph.edges().len()), (nodes, edges), "{name}");
        assert!(messages.contains(message), "{name}: {messages}");
        assert!(graph.edges().iter().all(|edge| edge.path.single().is_some()));
    }
}

#[test]
fn ids_positions_and_metadata_of_the_samples() {
    let (graph, _) = graph_of(&sample("aws_graph.geojson"));
    let node = graph.node(graph.node_by_id(12).expect("node 12"));
    assert_eq!(node.position, DVec2::new(1.0, -5.872_222_992_965_73));
    let edge = graph.edge(graph.edge_by_id(123).expect("a LineString nested as a MultiLineString"));
    assert_eq!((graph.node(edge.origin).id, graph.node(edge.destination).id), (20, 4));
    let (graph, _) = graph_of(&sample("turtlebot4_graph.geojson"));
    let twice: Vec<_> = graph
        .edges()
        .iter()
        .filter_map(|edge| edge.tags.as_ref()?.properties.get("id").cloned())
        .collect();
    assert_eq!(twice.len(), 6);
    let layout = layout_of(&sample("sample_graph.geojson"));
    let properties = &layout.edges[0].tags.properties;
    let property = |key: &str| properties.get(key).map(|value| &**value);
    assert_eq!((property("cost"), property("overridable")), (Some("10.0"), Some("false")));
    assert_eq!((property("speed_limit"), property("aisle_number")), (Some("0.85"), Some("14")));
    assert!(property("operations").is_some_and(|json| json.contains("\"trigger\":\"ON_ENTER\"")));
    assert!(layout.nodes[0].tags.properties["region"].contains("living_room"));
}

/// A graph of two points and lines between them.
fn with_lines(lines: &str) -> String {
    format!(
        r#"{{"type": "FeatureCollection", "features": [
{{"type": "Feature", "properties": {{"id": 1, "metadata": {{"theta": 1.5, "role": "charge", "class": "dock"}}}}, "geometry": {{"type": "Point", "coordinates": [0, 0]}}}},
{{"type": "Feature", "properties": {{"id": "2.0", "frame": "odom", "metadata": {{"orientation": {{"z": 1.0, "w": 0.0}}}}}}, "geometry": {{"type": "Point", "coordinates": [4, 0, 9]}}}},
{{"type": "Feature", "properties": {{"id": 3.0}}, "geometry": {{"type": "Point", "coordinates": [4, 3]}}}},
{lines}]}}"#
    )
    .replace("\"2.0\"", "2.0")
}

fn line(properties: &str, coordinates: &str) -> String {
    format!(
        r#"{{"type": "Feature", "properties": {{{properties}}}, "geometry": {{"type": "LineString", "coordinates": {coordinates}}}}}"#
    )
}

#[test]
fn nodes_have_headings_roles_and_frames() {
    let text = with_lines(&line(
        r#""id": 7, "startid": 1, "endid": 2, "metadata": {"abs_speed_limit": 0.4}"#,
        "[]",
    ));
    let layout = layout_of(&text);
    assert_eq!(
        layout.nodes.iter().map(|node| node.id.as_str()).collect::<Vec<_>>(),
        ["1", "2", "3"]
    );
    assert_eq!((layout.nodes[0].heading, layout.nodes[0].role), (Some(1.5), Role::Charge));
    assert_eq!(layout.nodes[0].tags.zone.as_deref(), Some("dock"));
    assert!((layout.nodes[1].heading.expect("a heading") - PI).abs() < 1e-12);
    assert_eq!(layout.edges[0].speed, Some(0.4));
    assert!(graph_of(&text).1.contains("in the frames map, odom"));
}

#[test]
fn an_angle_that_cannot_be_used_is_told_with_its_value_and_node() {
    let point = |id: u32, metadata: &str| {
        format!(
            r#"{{"type": "Feature", "properties": {{"id": {id}, "metadata": {{{metadata}}}}}, "geometry": {{"type": "Point", "coordinates": [{id}, 9]}}}}"#
        )
    };
    let points = [
        point(11, r#""theta": 90"#),
        point(12, r#""theta": 6.5"#),
        point(13, r#""yaw": "north""#),
        point(14, r#""theta": "1.57""#),
        point(15, r#""heading": 1.25"#),
        point(16, r#""heading": 120"#),
    ];
    let edge = line(r#""id": 7, "startid": 1, "endid": 2, "heading": 180"#, "[]");
    let text = with_lines(&format!("{},\n{edge}", points.join(",\n")));
    let (graph, messages) = graph_of(&text);
    for told in [
        "node `11` and 1 more: its `theta` `90` isn't an angle in radians",
        "node `13`: its `yaw` `north` isn't",
        "node `16`: its `heading` `120` isn't",
        "edge `7`: its `heading` `180` isn't",
    ] {
        assert!(messages.contains(told), "{told}: {messages}");
    }
    let heading = |id: u32| graph.node(graph.node_by_id(id).expect("a node")).theta;
    assert_eq!((heading(14), heading(15)), (1.57, 1.25));
}

#[test]
fn a_speed_that_is_not_a_number_above_0_is_told_with_its_edge() {
    let speeds = ["\"fast\"", "-0.5", "\"fast\"", "\" 0.4 \"", "0"];
    let edge = |(index, speed): (usize, &&str)| {
        let metadata = format!("\"metadata\": {{\"abs_speed_limit\": {speed}}}");
        line(&format!(r#""id": {}, "startid": 1, "endid": 2, {metadata}"#, index + 4), "[]")
    };
    let lines: Vec<String> = speeds.iter().enumerate().map(edge).collect();
    let (graph, messages) = graph_of(&with_lines(&lines.join(",\n")));
    for told in [
        "edge `4` and 1 more: its `abs_speed_limit` `fast` isn't a number",
        "edge `5`: its `abs_speed_limit` `-0.5` isn't a number",
        "edge `8` has no speed limit",
    ] {
        assert!(messages.contains(told), "{told}: {messages}");
    }
    let speeds: Vec<f64> = graph.edges().iter().map(|edge| edge.speed).collect();
    assert_eq!(speeds, [1.0, 1.0, 1.0, 0.4, 1.0]);
}

#[test]
fn lines_with_inner_points_are_polylines_between_their_nodes() {
    let lines = [
        line(r#""id": 4, "startid": 1, "endid": 3"#, "[[0, 0], [4, 0], [4, 3]]"),
        line(r#""id": 5, "startid": 3, "endid": 1"#, "[[0, 0], [4, 0], [4, 3]]"),
        line(r#""id": 6, "startid": 1, "endid": 2"#, "[[[0, 0], [2, 0]], [[2, 0], [4, 1]]]"),
        line(r#""id": 7, "startid": 1, "endid": 2"#, "[[0, 0], [0, 0], [4, 0], [4, 0]]"),
    ];
    let (graph, messages) = graph_of(&with_lines(&lines.join(",\n")));
    let lengths: Vec<f64> = graph.edges().iter().map(|edge| edge.path.length()).collect();
    assert_eq!(
        lengths.iter().map(|length| length.round()).collect::<Vec<_>>(),
        [7.0, 7.0, 4.0, 4.0]
    );
    assert_eq!(
        graph.edges().iter().map(|edge| edge.path.cubic_count()).collect::<Vec<_>>(),
        [2, 2, 2, 1]
    );
    assert!(
        messages.contains("graph:5: warning: edge `4` and 2 more: its line has inner points"),
        "{messages}"
    );
    assert!(
        messages.contains("edge `5`: its line is drawn from its end to its start"),
        "{messages}"
    );
    assert!(
        messages
            .contains("graph:7: warning: edge `6`: its line doesn't begin and end at its nodes"),
        "{messages}"
    );
}

#[test]
fn broken_files_say_what_to_do() {
    let edge = |properties: &str| with_lines(&line(properties, "[]"));
    let cases = [
        ("{".to_owned(), "graph:1: not a route graph"),
        ("[]".to_owned(), "graph:1: not a route graph"),
        ("{\"a\": 1}".to_owned(), "it has no `features`"),
        ("{\"features\": []}".to_owned(), "has no nodes"),
        (edge(r#""id": 7, "startid": 1"#), "graph:5: error: edge `7` lacks `startid` or `endid`"),
        (edge(r#""id": 7, "startid": 1, "endid": 99"#), "ends at node `99`, which doesn't exist"),
        (
            with_lines(
                r#"{"properties": {"id": 4}, "geometry": {"type": "Point", "coordinates": [1]}}"#,
            ),
            "graph:5: error: point `4` needs two finite coordinates",
        ),
        (
            with_lines(r#"{"geometry": {"type": "Point", "coordinates": [1, 1]}}"#),
            "a point has no `id`",
        ),
        (
            with_lines(r#"{"geometry": {"type": "Point", "coordinates": [[1e999, 1]]}}"#),
            "number out of range",
        ),
    ];
    for (text, expected) in cases {
        assert!(errors_of(&text).contains(expected), "{text}\n{}", errors_of(&text));
    }
}

#[test]
fn what_is_written_reads_the_same() {
    for name in ["aws_graph.geojson", "sample_graph.geojson", "turtlebot4_graph.geojson"] {
        let (graph, _) = graph_of(&sample(name));
        let written = write(&graph);
        let (again, _) = graph_of(&written.text);
        assert_eq!(again.nodes(), graph.nodes(), "{name}");
        for (again, edge) in again.edges().iter().zip(graph.edges()) {
            let mut again = again.clone();
            // The length is written where the file has no cost.
            if edge.tags.as_ref().is_none_or(|tags| !tags.properties.contains_key("cost")) {
                let mut tags = again.tags.take().unwrap_or_default();
                tags.properties.remove("cost");
                again.tags = tags.boxed();
            }
            assert_eq!(again, *edge, "{name}");
        }
        assert_eq!(again.edges().len(), graph.edges().len());
    }
}

#[test]
fn losses_are_listed() {
    let yaml = "Edges:\n- {Id: 1, Origin_ID: 1, Destination_ID: 2, CurveType: Spline, ParamF: 1, ParamB: 1, VelocityForward: 1, \
                VelocityBackwards: 0.5}\nVertices:\n- {Id: 1, X: 0, Y: 0, Theta: 1}\n- {Id: 2, X: 5, Y: 0, Theta: 1}\n";
    let (graph, _) = graph_of(yaml);
    let written = write(&graph);
    assert_eq!(written.losses.len(), 3, "{:?}", written.losses);
    assert!(written.losses.iter().any(|loss| loss.starts_with("1 edge is curved")));
    assert!(written.text.contains("MultiLineString") && written.text.contains("\"reverse_of\":1"));
    let (again, _) = graph_of(&written.text);
    let [edge] = again.edges() else { panic!("{:?}", again.edges()) };
    assert_eq!(edge.reverse_speed, Some(0.5));
    assert!((edge.path.length() - graph.edges()[0].path.length()).abs() < 0.02);
    // Without the first edge, the second is one that is driven tail first.
    let alone: Vec<&str> =
        written.text.lines().filter(|line| !line.contains("\"id\":1,\"startid\"")).collect();
    let (alone, _) = graph_of(&alone.join("\n"));
    assert_eq!(alone.edges()[0].orientation, Orientation::Offset(PI));
}

/// A graph of our own format with straight edges.
fn straight_graph() -> impl Strategy<Value = String> {
    let nodes = prop::collection::vec((-9e6..9e6_f64, 0..3000_i32, -3.0..3.0_f64), 2..8);
    let edges = prop::collection::vec(
        (0..8_usize, 1..7_usize, 0.01..9.0_f64, prop::option::of(0.01..9.0_f64)),
        1..12,
    );
    (nodes, edges).prop_map(|(nodes, edges)| {
        let count = nodes.len();
        let centre = nodes[0].0;
        let nodes = nodes.iter().enumerate().map(|(id, (_, y, theta))| {
            format!("- {{Id: {id}, X: {}, Y: {}, Theta: {theta}}}\n", centre + id as f64 * 1.25, f64::from(*y) / 7.0)
        });
        let edges = edges.iter().enumerate().map(|(id, (from, step, forward, back))| {
            let (from, to) = (from % count, (from + 1 + (step - 1) % (count - 1)) % count);
            let back = back.map(|back| format!(", VelocityBackwards: {back}")).unwrap_or_default();
            format!("- {{Id: {}, Origin_ID: {from}, Destination_ID: {to}, CurveType: Linear, VelocityForward: {forward}{back}}}\n", id * 3)
        });
        format!("Vertices:\n{}Edges:\n{}", nodes.collect::<String>(), edges.collect::<String>())
    })
}

#[test]
fn nodes_without_a_heading_stay_without() {
    let (graph, _) = graph_of(&sample("aws_graph.geojson"));
    let written = write(&graph);
    assert!(!written.text.contains("theta"), "{}", written.text);
    assert!(
        !written.losses.iter().any(|loss| loss.contains("nodes have a heading")),
        "{:?}",
        written.losses
    );
    assert!(graph_of(&written.text).0.nodes().iter().all(|node| !node.has_heading));
}

#[test]
fn boxes_and_third_coordinates_are_listed() {
    let text = r#"{"type": "FeatureCollection", "bbox": [0, 0, 1, 1], "features": [
        {"type": "Feature", "bbox": [0, 0, 0, 0], "properties": {"id": 0},
         "geometry": {"type": "Point", "coordinates": [0, 0, 3], "bbox": [0, 0, 0, 0]}},
        {"type": "Feature", "properties": {"id": 1}, "geometry": {"type": "Point", "coordinates": [1, 0, 0]}},
        {"type": "Feature", "properties": {"id": 2, "startid": 0, "endid": 1},
         "geometry": {"type": "LineString", "coordinates": []}}]}"#;
    let (_, messages) = graph_of(text);
    for kind in ["of the file", "of a feature", "of a geometry"] {
        assert!(messages.contains(&format!("key `bbox` {kind}: not used")), "{kind}: {messages}");
    }
    assert!(
        messages.contains("graph:2: warning: third coordinate of a position: not used"),
        "{messages}"
    );
}

#[test]
fn coordinates_may_be_texts() {
    fn point(id: &str, x: &str) -> String {
        format!(
            r#"{{"properties": {{"id": "{id}"}}, "geometry": {{"type": "Point", "coordinates": ["{x}", "0"]}}}},"#
        )
    }
    let text = format!(
        r#"{{"type": "FeatureCollection", "features": [{}{}
        {{"properties": {{"id": 1, "startid": "a", "endid": "b"}}, "geometry": {{"type": "LineString", "coordinates": []}}}}]}}"#,
        point("a", "0"),
        point("b", "5.5"),
    );
    let (graph, _) = parse(&text, "g.geojson", &ReadOptions::default()).expect("a graph");
    assert_eq!(graph.nodes()[1].position, DVec2::new(5.5, 0.0));
}

#[test]
fn keys_beside_metadata_are_those_of_metadata() {
    fn point(id: u32, x: u32, keys: &str) -> String {
        format!(
            r#"{{"type": "Feature", "properties": {{"id": {id}{keys}}}, "geometry": {{"type": "Point", "coordinates": [{x}, 0]}}}},"#
        )
    }
    let text = format!(
        r#"{{"type": "FeatureCollection", "features": [{}{}
        {{"type": "Feature", "properties": {{"id": 9, "startid": 0, "endid": 3, "abs_speed_limit": 0.5, "frame": "map"}},
          "geometry": {{"type": "LineString", "coordinates": [[0, 0], [5, 0]]}}}}]}}"#,
        point(0, 0, r#", "name": "dock", "yaw": 1.571, "colour": "red""#),
        point(3, 5, r#", "name": "outer", "metadata": {"name": "bench", "role": "charge"}"#),
    );
    let (graph, findings) = parse(&text, "g.geojson", &ReadOptions::default()).expect("a graph");
    let messages = findings.as_slice().iter().map(ToString::to_string).collect::<String>();
    let [dock, bench] = graph.nodes() else { panic!("two nodes") };
    assert_eq!((dock.name(), dock.theta), (Some("dock"), 1.571), "{messages}");
    assert_eq!(dock.tags.as_ref().expect("tags").properties["colour"].as_ref(), "red");
    assert_eq!((bench.name(), bench.role), (Some("bench"), Role::Charge));
    assert_eq!(bench.tags.as_ref().expect("tags").properties["name"].as_ref(), "outer");
    assert_eq!(graph.edges()[0].speed, 0.5);
}

/// An id that is a text, and a name beside it: both are names.
#[test]
fn a_name_beside_an_id_survives_the_round_trip() {
    let text =
        "id,name,x,y\nW1,Goods in,0,0\nW2,Goods out,9,0\n\nfrom,to,speed\nW1,W2,1\nW2,W1,1\n";
    let (graph, _) = parse(text, "plant.csv", &ReadOptions::default()).expect("a graph");
    assert_eq!(graph.nodes()[0].other_names(), ["Goods in"]);
    let written = crate::write::nav2::write(&graph).text;
    let (again, _) = parse(&written, "g.geojson", &ReadOptions::default()).expect("a graph");
    assert_eq!(
        (again.nodes()[0].name(), again.nodes()[0].other_names()),
        (Some("W1"), vec!["Goods in".to_owned()])
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn straight_graphs_survive_the_round_trip(yaml in straight_graph()) {
        let (graph, _) = graph_of(&yaml);
        let (again, _) = graph_of(&write(&graph).text);
        prop_assert_eq!(again.origin(), graph.origin());
        prop_assert_eq!(again.nodes(), graph.nodes());
        prop_assert_eq!(again.edges().len(), graph.edges().len());
        for (again, edge) in again.edges().iter().zip(graph.edges()) {
            prop_assert_eq!((again.id, again.origin, again.destination), (edge.id, edge.origin, edge.destination));
            prop_assert_eq!(&again.path, &edge.path);
            prop_assert_eq!(again.speed, edge.speed);
            prop_assert_eq!(again.reverse_speed, edge.reverse_speed);
            prop_assert_eq!(again.orientation, edge.orientation);
        }
    }

    #[test]
    fn changed_samples_dont_panic(which in 0..2_usize, at in 0.0..1.0_f64, length in 0..40_usize, with in "[-0-9a-z:,.{}\\[\\]\" \n]{0,12}") {
        let text = sample(["sample_graph.geojson", "error_codes.geojson"][which]);
        let start = text.floor_char_boundary((text.len() as f64 * at) as usize);
        let end = text.floor_char_boundary((start + length).min(text.len()));
        errors_of(&format!("{}{with}{}", &text[..start], &text[end..]));
        errors_of(&text[..start]);
    }
}
