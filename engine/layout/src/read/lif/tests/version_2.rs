//! The draft of LIF 2.

use super::{messages, options, read, read_with};
use crate::model::options::ReadOptions;
use crate::model::tags::{Orientation, Role};

/// The draft of LIF 2, with robot types of a manufacturer.
const SECOND: &str = r#"{"metaInformation": {"lifId": "L", "creator": "me", "lifVersion": "2.0.0"},
 "origins": [{"originId": "O1", "layouts": [{"layoutId": "hall", "layoutVersion": "1",
  "nodes": [
   {"nodeId": "A", "nodePosition": {"x": 0.0, "y": 0.0}, "mobileRobotTypeNodeProperties": [
    {"mobileRobotTypes": [{"manufacturer": "Maker", "seriesName": "One"}, {"manufacturer": "Maker", "seriesName": "Two"}],
     "theta": 0.5, "allowedDeviationXY": {"aMaximum": 0.1}, "feasibleActions": [{"actionType": "pick", "blockingType": "HARD"}]}]},
   {"nodeId": "B", "nodePosition": {"x": 6.0, "y": 0.0}, "mobileRobotTypeNodeProperties": [
    {"mobileRobotTypes": [{"manufacturer": "Maker", "seriesName": "One"}], "requiredActions": [{"actionType": "drop"}]}]}],
  "edges": [
   {"edgeId": "A-B", "startNodeId": "A", "endNodeId": "B", "mobileRobotTypeEdgeProperties": [
    {"mobileRobotTypes": [{"manufacturer": "Maker", "seriesName": "One"}], "orientationType": "TANGENTIAL",
     "mobileRobotOrientations": [0.0, 3.14159], "maximumSpeed": 1.4, "corridor": {"maximumLeftWidth": 0.2, "maximumRightWidth": 0.3}}]},
   {"edgeId": "B-A", "startNodeId": "B", "endNodeId": "A", "mobileRobotTypeEdgeProperties": [
    {"mobileRobotTypes": [{"manufacturer": "Maker", "seriesName": "One"}], "mobileRobotOrientations": [3.14159], "maxSpeed": 0.7}]}],
  "stations": [{"stationId": "S", "interactionNodeIds": ["A"], "stationType": "rack"}]}]}]}"#;

#[test]
fn the_draft_of_version_2_is_read() {
    let (graph, findings) = read(SECOND);
    let messages = messages(&findings);
    let roles: Vec<Role> = graph.nodes().iter().map(|node| node.role).collect();
    assert_eq!(roles, [Role::Pick, Role::Drop], "{messages}");
    let [there, back] = graph.edges() else { panic!("two edges") };
    assert_eq!((there.speed, there.orientation), (1.4, Orientation::Tangential));
    let Orientation::Offset(offset) = back.orientation else { panic!("tail first") };
    assert!(back.speed == 0.7 && (offset - std::f64::consts::PI).abs() < 1e-4, "{offset}");
    let properties = &there.tags.as_ref().expect("tags").properties;
    assert_eq!(&*properties["corridor"], r#"{"maximumLeftWidth":0.2,"maximumRightWidth":0.3}"#);
    assert_eq!(&*properties["mobileRobotOrientations"], "[0.0,3.14159]");
    assert_eq!(&*properties["vehicleTypeId"], "Maker/One");
    assert_eq!(graph.stations()[0].role, Role::Pick);
    assert_eq!(&*graph.stations()[0].properties["stationType"], "rack");
    assert!(messages.contains("several `mobileRobotOrientations`: the first is used"));
    assert!(!messages.contains("read as LIF") && !messages.contains("origin"), "{messages}");
}

#[test]
fn an_origin_of_version_2_can_be_chosen() {
    let origin = &SECOND[SECOND.find("{\"originId\"").expect("an origin")..];
    let origin = origin.strip_suffix("]}").expect("an end");
    let other = origin.replace("O1", "O2").replace("\"hall\"", "\"yard\"");
    let text = SECOND.replace(origin, &format!("{origin}, {other}"));
    let (graph, findings) = read(&text);
    assert_eq!(graph.nodes().len(), 4);
    assert!(messages(&findings).contains("the layouts of 2 origins lie in one plane"));
    let (graph, _) = read_with(&text, &ReadOptions { level: Some("O2".to_owned()), ..options() });
    assert_eq!(graph.nodes().len(), 2);
}
