use proptest::prelude::*;

use super::*;
use crate::model::finding::Findings;
use crate::model::format::Format;
use crate::model::options::LengthUnit;
use crate::model::route_graph::RouteGraph;
use crate::model::tags::Role;
use crate::{GraphError, parse, read};

fn options() -> ReadOptions {
    ReadOptions { format: Some(Format::Csv), ..ReadOptions::default() }
}

fn graph(text: &str) -> (RouteGraph, Findings) {
    parse(text, "map.csv", &options()).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

fn error(text: &str) -> String {
    parse(text, "map.csv", &options()).expect_err(text).to_string()
}

fn messages(findings: &Findings) -> String {
    findings.as_slice().iter().map(|finding| format!("{finding}\n")).collect()
}

/// The examples of the documentation.
const BOTH: &str = "\
# A comment.
ID,X,Y,Theta,Name,Level,Zone,Role,Colour
1,0,0,1.5,Dock A,L1,Z,charge,red
2,10,0,,,L1,,,
7,10,5.5,,,L1,,,

Id,From Node,to_node,Max Speed,Reverse Speed,Bidirectional,x1,y1,x2,y2,note
5,1,2,2,0.3,no,,,,,\"wet, slow\"
6,2,7,1.5,,yes,12,0,12,5,
";

#[test]
fn both_tables_of_a_file_are_read() {
    let (graph, findings) = graph(BOTH);
    // Robots turn at both ends of edge 6.
    let expected = [
        "map.csv:1: warning: the heading changes by more than",
        "map.csv:2: warning: unknown columns of nodes are kept as properties: `Colour`",
        "map.csv:7: warning: unknown columns of edges are kept as properties: `note`",
    ];
    let messages = messages(&findings);
    assert_eq!(messages.lines().count(), expected.len(), "{messages}");
    assert!(messages.lines().zip(expected).all(|(line, start)| line.starts_with(start)));
    let dock = &graph.nodes()[0];
    assert_eq!(
        (dock.id, dock.position, dock.theta, dock.role),
        (1, DVec2::ZERO, 1.5, Role::Charge)
    );
    let tags = dock.tags.as_ref().expect("tags");
    assert_eq!(
        (dock.name(), tags.level.as_deref(), tags.zone.as_deref()),
        (Some("Dock A"), Some("L1"), Some("Z"))
    );
    assert_eq!(tags.properties.get("Colour").map(AsRef::as_ref), Some("red"));
    assert_eq!(graph.nodes()[2].position, DVec2::new(10.0, 5.5));
    let ids: Vec<u32> = graph.edges().iter().map(|edge| edge.id).collect();
    assert_eq!(ids, [5, 6, 7]);
    let [straight, curve, back] = graph.edges() else { panic!("three edges") };
    assert_eq!((straight.speed, straight.reverse_speed), (2.0, Some(0.3)));
    assert_eq!(straight.path.single(), Some(&CubicBezier::straight(DVec2::ZERO, DVec2::X * 10.0)));
    assert_eq!(
        straight.tags.as_ref().and_then(|tags| tags.properties.get("note")).map(AsRef::as_ref),
        Some("wet, slow")
    );
    let points = [[10.0, 0.0], [12.0, 0.0], [12.0, 5.0], [10.0, 5.5]];
    assert_eq!(curve.path.single().expect("one cubic").control_points, points.map(DVec2::from));
    assert_eq!((back.origin, back.destination), (curve.destination, curve.origin));
    assert_eq!(back.path, curve.path.reversed());
}

/// The x coordinates of the nodes, in the file's unit.
fn graph_of(text: &str) -> Vec<f64> {
    let (graph, _) = graph(text);
    graph.nodes().iter().map(|node| graph.origin().x + node.position.x).collect()
}

#[test]
fn separators_decimal_commas_units_and_names_vary() {
    let text = "Vertex_ID;X [mm];Y [mm];Heading [deg]\nA;1500,5;0;90\nB;2500;0;\n\nSource;Target;vmax\nA;B;1,25\n";
    let (graph, _) = graph(text);
    assert_eq!(graph.nodes()[0].name(), Some("A"));
    assert_eq!(graph.nodes()[0].position, DVec2::new(1.5005, 0.0));
    assert_eq!(graph.nodes()[0].theta, std::f64::consts::FRAC_PI_2);
    assert_eq!((graph.edges()[0].id, graph.edges()[0].speed), (1, 1.25));
    let hourly = "id,x [in],y\nA,3,0\nB,300,0\n\nfrom,to,speed (km/h)\nA,B,5.4\n";
    let hourly = parse(hourly, "hourly.csv", &options()).expect("a graph").0;
    assert_eq!((hourly.nodes()[0].position.x, hourly.edges()[0].speed), (0.0762, 1.5));
    let thousands = "id;x;y\nA;1.000,5;0\nB;12.000;0\n\nfrom;to\nA;B\n";
    let xs = graph_of(thousands);
    assert_eq!(xs, [1000.5, 12_000.0], "a point is no decimal point where commas are");
    assert_eq!(graph_of(&thousands.replace("1.000,5", "1.5")), [1.5, 12.0]);
    let tabs = "from\tto\n1\t2\nnode\tx\ty\n1\t0\t0\n2\t100\t0\n";
    let options = ReadOptions { units: Some(LengthUnit::Centimetre), ..options() };
    let (graph, findings) = parse(tabs, "map.csv", &options).expect("a graph");
    assert_eq!(graph.nodes()[1].position, DVec2::X);
    assert!(messages(&findings).contains("no speed limit"));
}

#[test]
fn the_tables_may_be_in_two_files() {
    let folder = tempfile::tempdir().expect("a folder");
    let (nodes, edges) = BOTH.split_once("\n\n").expect("two tables");
    for [node_name, edge_name] in
        [["map-nodes.csv", "map-edges.csv"], ["site_Vertices.csv", "site_Edges.tsv"]]
    {
        let [node_file, edge_file] = [node_name, edge_name].map(|name| folder.path().join(name));
        std::fs::write(&node_file, nodes).expect("written");
        std::fs::write(&edge_file, edges).expect("written");
        for file in [node_file, edge_file] {
            let (graph, _) = read(&file, &options()).expect("a graph");
            assert_eq!((graph.nodes().len(), graph.edges().len()), (3, 3));
        }
    }
    std::fs::write(folder.path().join("map-edges.csv"), edges.replace("0.3", "slow"))
        .expect("written");
    let message =
        read(&folder.path().join("map-nodes.csv"), &options()).expect_err("no number").to_string();
    assert!(
        message.contains("map-edges.csv:2: error: `Reverse Speed` is `slow`: give a number"),
        "{message}"
    );
    // An error of an edge has the place of the edge, whichever file is given.
    let lost = edges.replace("5,1,2,", "5,1,77,");
    assert_ne!(lost, edges);
    std::fs::write(folder.path().join("map-edges.csv"), lost).expect("written");
    for file in ["map-nodes.csv", "map-edges.csv"] {
        let message = read(&folder.path().join(file), &options()).expect_err("no node").to_string();
        assert!(message.contains("map-edges.csv:"), "{message}");
        assert!(!message.contains("map-nodes.csv:1"), "{message}");
    }
}

#[test]
fn one_level_can_be_read() {
    let text = "id,x,y,level\n1,0,0,A\n2,1,0,A\n3,1,0,B\nfrom,to\n1,2\n2,3\n";
    let level = |level: &str| {
        parse(text, "map.csv", &ReadOptions { level: Some(level.to_owned()), ..options() })
    };
    let (graph, _) = level("A").expect("a graph");
    assert_eq!((graph.nodes().len(), graph.edges().len()), (2, 1));
    assert!(level("C").expect_err("none").to_string().contains("no node has the level `C`"));
}

#[test]
fn mistakes_are_reported() {
    let nodes = "id,x,y\n1,0,0\n2,1,0\n";
    assert!(
        error("1,2,3\n").contains("map.csv:1: not a route graph: the first row isn't a header")
    );
    assert!(error(nodes).contains("there is no table of edges"));
    assert!(error("id,x,y\nfrom,to\n").contains("the tables have no rows"));
    assert!(
        error(&format!("{nodes}\nfrom,to\n1,3\n"))
            .contains("map.csv:6: error: edge `1` ends at node `3`")
    );
    assert!(
        error(&format!("{nodes}\nfrom,to\n1,\n")).contains("map.csv:6: error: an edge has no ends")
    );
    assert!(
        error(&format!("{nodes}3,one,0\nfrom,to\n1,2\n"))
            .contains("map.csv:4: error: `x` is `one`: give a number")
    );
    assert!(
        error(&format!("{nodes}\nfrom,to,x1\n1,2,5\n")).contains("a control point is incomplete")
    );
    assert!(error(&format!("{nodes}{}\n", "a,".repeat(300))).contains("200 columns"));
    let (_, findings) = graph("id,x,y,role\n1,0,0,shelf\n2,1,0,\n\nfrom,to,two-way\n1,2,maybe,4\n");
    let messages = messages(&findings);
    for message in [
        "map.csv:2: warning: `shelf` is not a role",
        "bidirectional is `maybe`",
        "cells without a column name",
    ] {
        assert!(messages.contains(message), "{messages}");
    }
}

#[test]
fn an_end_by_a_name_that_two_nodes_have_is_told_as_such() {
    let nodes = "id,x,y,name\nA,0,0,Ramp\nB,9,0,Ramp\nC,9,9,Dock\n";
    let told = error(&format!("{nodes}\nfrom,to\nA,B\nB,Dock\nRamp,C\n"));
    let expected = "edge `3` starts at node `Ramp`, a name that several nodes have: give the id";
    assert!(told.contains(expected), "{told}");
    let (_, findings) = graph(&format!("{nodes}\nfrom,to\nA,B\nB,Dock\n"));
    let told = messages(&findings);
    assert!(told.contains("several nodes have the name `Ramp`"), "{told}");
}

#[test]
fn all_errors_of_all_rows_are_told_once() {
    let text = "id,x,y\n1,0,0\n2,1,0\n3,one,0\n4,,0\n\nfrom,to,speed,x1,y1\n1,2,1,,\n2,3,1,,\n\
                1,9,1,,\n4,8,1,,\n1,2,fast,,\n2,1,-1,,\n1,2,1,5,five\n";
    let error = parse(text, "map.csv", &options()).expect_err("errors");
    let GraphError::Invalid(findings) = error else { panic!("{error}") };
    let told: Vec<String> = findings.as_slice().iter().map(ToString::to_string).collect();
    let expected = [
        "map.csv:4: error: `x` is `one`: give a number",
        "map.csv:5: error: node `4` has no x or no y: give both",
        "map.csv:10: error: edge `3` ends at node `9`, which doesn't exist: add it or correct the id",
        "map.csv:11: error: edge `4` ends at node `8`, which doesn't exist: add it or correct the id",
        "map.csv:12: error: `speed` is `fast`: give a number",
        "map.csv:13: error: edge 6: its speed is -1 m/s: it must be above 0 and at most 50 m/s",
        "map.csv:14: error: `y1` is `five`: give a number",
    ];
    assert_eq!(told, expected);
}

#[test]
fn errors_of_both_files_are_told() {
    let folder = tempfile::tempdir().expect("a folder");
    let nodes = folder.path().join("map-nodes.csv");
    std::fs::write(&nodes, "id,x,y\n1,0,0\n2,one,0\n").expect("written");
    std::fs::write(folder.path().join("map-edges.csv"), "from,to\n1,2\n1,9\n").expect("written");
    let error = read(&nodes, &options()).expect_err("errors");
    let GraphError::Invalid(findings) = error else { panic!("{error}") };
    assert_eq!(findings.errors(), 2, "{findings:?}");
    assert!(messages(&findings).contains("node `9`, which doesn't exist"), "{findings:?}");
}

#[test]
fn tables_of_a_german_excel_are_read() {
    let text = "sep=;\r\nid;x;y\r\n1;1.000,5;-2.500.000,25\r\n2;2,5;-2.50.001\r\n;;\r\n\
                from;to;speed;bidirectional\r\n1;2;1,5;WAHR\r\n";
    let error = parse(text, "map.csv", &ReadOptions::default()).expect_err("two points");
    assert!(error.to_string().contains("map.csv:4: error: `y` is `-2.50.001`: give"), "{error}");
    let text = text.replace("-2.50.001", "-2.500.001");
    let (graph, _) = parse(&text, "map.csv", &ReadOptions::default()).expect("a graph");
    let [one, other] = [0, 1].map(|node| graph.nodes()[node].position + graph.origin());
    assert_eq!((one, other), (DVec2::new(1000.5, -2.50000025e6), DVec2::new(2.5, -2.500001e6)));
    assert_eq!((graph.edges().len(), graph.edges()[1].speed), (2, 1.5));
}

#[test]
fn the_same_warning_about_many_rows_is_one() {
    let nodes: String = (0..100).map(|id| format!("{id},{id},0,shelf\n")).collect();
    let edges: String = (1..100).map(|id| format!("{},{id},both\n", id - 1)).collect();
    let (_, findings) = graph(&format!("id,x,y,role\n{nodes}\nfrom,to,bidirectional\n{edges}"));
    let messages = messages(&findings);
    assert_eq!(messages.matches("`shelf` is not a role").count(), 1, "{messages}");
    assert!(messages.contains("use yes or no (99 times)"), "{messages}");
}

#[test]
fn long_names_of_columns_are_refused() {
    let name = "n".repeat(101);
    let text = format!("id,x,y,{name}\n1,0,0,a\n2,1,0,b\n\nfrom,to\n1,2\n");
    let error = error(&text);
    assert!(error.contains("map.csv:1:") && error.contains("is longer than 100 bytes"), "{error}");
    graph(&text.replace(&name, &name[1..]));
}

#[test]
fn a_node_is_found_by_its_id_and_by_its_name() {
    let (graph, _) = graph(
        "id,x,y,name\nW1,0,0,Inbound\nD1,10,0,Shelf\nD2,20,0,Shelf\n\n\
         from,to,bidirectional\nW1,D1,yes\nD1,D2,yes\n",
    );
    let nodes = graph.nodes();
    assert_eq!((nodes[0].name(), nodes[0].other_names()), (Some("W1"), vec!["Inbound".to_owned()]));
    assert_eq!(graph.nodes_named("Inbound"), graph.nodes_named("W1"));
    assert_eq!(graph.nodes_named("Shelf").len(), 2);
}

#[test]
fn the_ends_of_an_edge_are_found_by_a_name_that_one_node_has() {
    let nodes = "id,x,y,name\n1,0,0,Start\n2,10,0,Shelf\n3,20,0,Shelf\n4,30,0,1\n";
    let (graph, _) = graph(&format!("{nodes}\nfrom,to\nStart,2\n2,Start\n1,3\n"));
    let ends = graph.edges().iter().map(|edge| [edge.origin.0, edge.destination.0]);
    assert_eq!(ends.collect::<Vec<_>>(), [[0, 1], [1, 0], [0, 2]]);
    let error = error(&format!("{nodes}\nfrom,to\nStart,Shelf\n"));
    assert!(error.contains("ends at node `Shelf`, a name that several nodes have"), "{error}");
}

#[test]
fn ends_that_nearly_meet_are_told() {
    let told = |x: &str| {
        let text =
            format!("id,x,y\nA,0,0\nB,10,0\nC,{x},0\nD,20,0\n\nfrom,to\nA,B\nB,A\nC,D\nD,C\n");
        messages(&graph(&text).1)
    };
    // 10.05 - 10 is a little more than 0.05.
    for (x, remedy) in
        [("10.03", "--fix` joins them"), ("10.05", "--fix` joins them"), ("10.12", "up to 0.05 m")]
    {
        let told = told(x);
        assert!(told.contains("no edge joins them") && told.contains(remedy), "{x}: {told}");
    }
    assert!(!told("10.3").contains("no edge joins them"));
}

#[test]
fn german_headers_are_guessed_and_told() {
    let text = "Knoten;X;Y;Bezeichnung\n1;0;0;Tor\n2;3,5;0;Lager\n\n\
                von;nach;Länge;Höchstgeschwindigkeit [km/h];beide Richtungen\n1;2;3,5;3,6;ja\n";
    let (graph, findings) = graph(text);
    assert_eq!((graph.nodes().len(), graph.edges().len()), (2, 2));
    assert_eq!((graph.nodes()[1].name(), graph.edges()[0].speed), (Some("Lager"), 1.0));
    let told = messages(&findings);
    for guess in
        ["`Knoten` as `id`", "`von` as `from`", "`nach` as `to`", "`Bezeichnung` as `name`"]
    {
        assert!(told.contains(guess), "{guess}: {told}");
    }
    assert!(told.contains("unknown columns of edges are kept as properties: `Länge`"), "{told}");
    let ends = "Startknoten;Zielknoten\n1;2\n\nNr;X-Koordinate;Y-Koordinate\n1;0;0\n2;5;0\n";
    assert_eq!(parse(ends, "map.csv", &options()).expect("a graph").0.edges().len(), 1);
    assert!(!messages(&parse(BOTH, "map.csv", &options()).expect("a graph").1).contains("German"));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(if cfg!(miri) { 2 } else { 256 }))]

    #[test]
    fn no_text_makes_the_reader_panic(at in 0usize..300, removed in 0usize..60, inserted in "[,;\t\n\"'#a-z0-9.-]{0,8}", ends in any::<bool>()) {
        let at = BOTH.floor_char_boundary(at);
        let end = BOTH.floor_char_boundary(at + removed);
        let rest = if ends { "" } else { &BOTH[end..] };
        let _ = parse(&format!("{}{inserted}{rest}", &BOTH[..at]), "map.csv", &options());
    }
}

#[test]
fn points_that_may_separate_thousands_are_told() {
    let told = |text: &str| messages(&graph(text).1).contains("`2.500` is read as 2.5, as are all");
    let thousands = "id;x;y\nA;2.500;0\nB;12.000;0\n\nfrom;to\nA;B\n";
    assert!(told(thousands));
    assert!(!told(&thousands.replace("12.000", "1.5")), "a point of decimals");
    assert!(!told(&thousands.replace("12.000", "1,5")), "read as 2500");
    assert!(!told(&thousands.replace(';', ",")), "a comma separates");
}

#[test]
fn points_in_a_file_with_decimal_commas_are_told() {
    let text = "id;x;y\nA;3,5;0\nB;3.000;0\nC;4.000;0\n\nfrom;to\nA;B\nB;C\nC;A\n";
    assert_eq!(graph_of(text), [3.5, 3000.0, 4000.0]);
    let told = messages(&graph(text).1);
    assert!(told.contains("`x` is `3.000`, which is read as 3000"), "{told}");
    assert!(told.contains("(2 such numbers)"), "{told}");
    let zero = text.replace("3.000", "0.500").replace("4.000", "4");
    assert_eq!(graph_of(&zero), [3.5, 0.5, 4.0]);
    let told = messages(&graph(&zero).1);
    assert!(told.contains("`x` is `0.500`, which is read as 0.5"), "{told}");
    let long = text.replace("3.000", "12345.678").replace("4.000", "4");
    assert_eq!(graph_of(&long)[1], 12_345.678, "not groups of three digits");
    let message = error(&text.replace("4.000", "4.5"));
    assert!(message.contains("`x` is `3.000`, which may be 3000 or 3"), "{message}");
    assert!(message.contains(":3"), "the row: {message}");
}
