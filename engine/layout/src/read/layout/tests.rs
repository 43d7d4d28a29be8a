use crate::model::finding::Findings;
use crate::model::options::ReadOptions;
use crate::model::route_graph::RouteGraph;
use crate::model::tags::Role;
use crate::{GraphError, parse};

fn read(text: &str, name: &str) -> (RouteGraph, String) {
    let (graph, findings) = parse(text, name, &ReadOptions::default()).expect("a layout");
    (graph, messages(&findings))
}

fn messages(findings: &Findings) -> String {
    findings.as_slice().iter().map(|finding| format!("{finding}\n")).collect()
}

#[test]
fn a_charger_at_the_place_of_a_vertex_is_joined_with_it() {
    let text = "\
building_name: hall
levels:
  L1:
    vertices:
    - [0.0, 0.0, {name: a}]
    - [6.0, 0.0, {name: b}]
    - [6.0, 0.0, {name: b_charger, is_charger: true}]
    lanes:
    - [0, 1, {}]
    - [1, 0, {}]
    - [1, 2, {}]
    - [2, 1, {}]
";
    let (graph, messages) = read(text, "nav.yaml");
    assert_eq!((graph.nodes().len(), graph.edges().len()), (2, 2), "{messages}");
    assert_eq!(messages.matches("`b_charger` with `b`").count(), 1, "{messages}");
    let joined = graph.nodes_named("b_charger");
    assert_eq!(joined, graph.nodes_named("b"));
    assert_eq!(graph.node(joined[0]).role, Role::Charge);
}

/// A rotation table of three points, with a block and a location.
const TABLE: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<model version="0.0.2" name="table">
 <point name="P1" xPosition="0" yPosition="0"/>
 <point name="P2" xPosition="6000" yPosition="0"/>
 <point name="P3" xPosition="6000" yPosition="0"/>
 <point name="P4" xPosition="6000" yPosition="0" vehicleOrientationAngle="90"/>
 <path name="P1-P2" sourcePoint="P1" destinationPoint="P2" maxVelocity="1000"/>
 <path name="P2-P3" sourcePoint="P2" destinationPoint="P3" maxVelocity="1000"/>
 <path name="P3-P4" sourcePoint="P3" destinationPoint="P4" maxVelocity="1000"/>
 <path name="P4-P1" sourcePoint="P4" destinationPoint="P1" maxVelocity="1000"/>
 <locationType name="T"><allowedOperation name="Load"/></locationType>
 <location name="S" xPosition="6000" yPosition="900" type="T"><link point="P4"/><link point="P2"/></location>
 <block name="B"><member name="P3"/><member name="P2-P3"/><member name="P4-P1"/></block>
</model>
"#;

#[test]
fn stations_and_zones_keep_the_nodes_that_are_joined() {
    let (graph, messages) = read(TABLE, "plant.xml");
    assert_eq!((graph.nodes().len(), graph.edges().len()), (2, 2), "{messages}");
    assert!(messages.contains("`P3` with `P2`, `P4` with `P2`"), "{messages}");
    let table = graph.nodes_named("P2");
    assert_eq!([graph.nodes_named("P3"), graph.nodes_named("P4")], [table.clone(), table.clone()]);
    assert_eq!(graph.stations()[0].nodes, table);
    assert_eq!((graph.zones()[0].nodes.clone(), graph.zones()[0].edges.len()), (table.clone(), 1));
    let theta = graph.node(table[0]).theta;
    assert!((theta - std::f64::consts::FRAC_PI_2).abs() < 1e-9, "{theta}");
}

#[test]
fn aliases_outlive_a_conversion() {
    let (graph, _) = read(TABLE, "plant.xml");
    let yaml = crate::write(&graph, crate::Format::Regatta).expect("a writer").text;
    let (again, _) = read(&yaml, "plant.yaml");
    assert_eq!(again.nodes_named("P4"), graph.nodes_named("P2"));
}

#[test]
fn an_edge_from_a_node_to_itself_is_left_out() {
    let text = "id,x,y\n1,0,0\n2,5,0\n\nfrom,to\n1,2\n2,2\n2,1\n";
    let (graph, messages) = read(text, "map.csv");
    assert_eq!(graph.edges().len(), 2, "{messages}");
    assert!(messages.contains("map.csv:7: warning: edge `2` starts and ends at the same node"));
}

#[test]
fn levels_are_not_joined() {
    let text = "id,x,y,level\n1,0,0,A\n2,5,0,A\n3,5,0,B\n4,9,0,B\n\nfrom,to\n1,2\n2,3\n3,4\n";
    let (graph, messages) = read(text, "map.csv");
    assert_eq!((graph.nodes().len(), graph.edges().len()), (4, 2), "{messages}");
    assert!(messages.contains("edge `2` joins two levels at one place"), "{messages}");
}

#[test]
fn many_nodes_at_one_place_take_linear_time() {
    let count = 20_000;
    let nodes: String = (1..=count).map(|id| format!("{id},0,0\n")).collect();
    let edges: String = (2..=count).rev().map(|id| format!("{},{id}\n", id - 1)).collect();
    let text = format!("id,x,y\n0,9,0\n{nodes}\nfrom,to\n0,1\n1,0\n{edges}");
    let (graph, messages) = read(&text, "map.csv");
    assert_eq!((graph.nodes().len(), graph.edges().len()), (2, 2), "{messages}");
    assert!(messages.contains("and 19994 more nodes"), "{messages}");
}

/// Of each format with ids: a text whose node `B` has a wrong position, with an edge to it, and one
/// to a node `X` that doesn't exist.
const TWO_ERRORS: [(&str, &str); 4] = [
    ("t.csv", "id,x,y\nA,0,0\nB,one,0\n\nfrom,to\nA,B\nB,A\nA,X\n"),
    (
        "t.lif.json",
        r#"{"metaInformation": {}, "layouts": [{"layoutId": "L", "nodes": [
        {"nodeId": "A", "nodePosition": {"x": 0, "y": 0}},
        {"nodeId": "B", "nodePosition": {"x": 1}}], "edges": [
        {"edgeId": "1", "startNodeId": "A", "endNodeId": "B"},
        {"edgeId": "2", "startNodeId": "A", "endNodeId": "X"}]}]}"#,
    ),
    (
        "t.geojson",
        r#"{"type": "FeatureCollection", "features": [
        {"properties": {"id": "A"}, "geometry": {"type": "Point", "coordinates": [0, 0]}},
        {"properties": {"id": "B"}, "geometry": {"type": "Point", "coordinates": ["one", 0]}},
        {"properties": {"id": 1, "startid": "A", "endid": "B"},
         "geometry": {"type": "LineString", "coordinates": []}},
        {"properties": {"id": 2, "startid": "A", "endid": "X"},
         "geometry": {"type": "LineString", "coordinates": []}}]}"#,
    ),
    (
        "t.xml",
        r#"<?xml version="1.0"?>
        <model version="6.0.0" name="m">
        <point name="A" positionX="0" positionY="0"/><point name="B" positionX="one" positionY="0"/>
        <path name="1" sourcePoint="A" destinationPoint="B" maxVelocity="1000"/>
        <path name="2" sourcePoint="A" destinationPoint="X" maxVelocity="1000"/>
        </model>"#,
    ),
];

#[test]
fn a_wrong_position_hides_no_missing_node_and_counts_once() {
    for (name, text) in TWO_ERRORS {
        let error = parse(text, name, &ReadOptions::default()).expect_err(name);
        let GraphError::Invalid(findings) = error else { panic!("{name}: {error}") };
        let told = messages(&findings);
        assert_eq!(findings.errors(), 2, "{name}: {told}");
        assert!(told.contains("ends at node `X`, which doesn't exist"), "{name}: {told}");
    }
}
