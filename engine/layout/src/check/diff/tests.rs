use super::*;
use crate::model::options::ReadOptions;
use crate::parse;

fn graph(speed: f64, x: f64, more: &str) -> RouteGraph {
    let text = format!(
        "Vertices:\n- {{Id: 1, X: 0, Y: 0, Theta: 0}}\n- {{Id: 2, X: {x}, Y: 0, Theta: 0, \
         Role: park}}\n{more}\
         Edges:\n- {{Id: 7, Origin_ID: 1, Destination_ID: 2, CurveType: Linear, VelocityForward: {speed}}}\n"
    );
    parse(&text, "g", &ReadOptions::default()).expect("a graph").0
}

fn differences(first: &RouteGraph, second: &RouteGraph) -> Vec<String> {
    diff(first, second).iter().map(ToString::to_string).collect()
}

#[test]
fn a_graph_doesnt_differ_from_itself() {
    assert_eq!(differences(&graph(1.0, 5.0, ""), &graph(1.0, 5.0, "")), [""; 0]);
}

#[test]
fn small_differences_have_digits_that_tell_them() {
    assert_eq!(
        differences(&graph(1.0, 5.0, ""), &graph(1.0, 5.0001, "")),
        ["~ node 2: moved by 0.100 mm", "~ edge 7: path differs by 0.100 mm"]
    );
    assert_eq!([length(0.012), length(1.5e-6)], ["0.012 m", "0.002 mm"]);
    assert_eq!([angle(0.1), angle(2e-6)], ["5.73°", "0.00011°"]);
}

#[test]
fn zones_differ_by_their_rules_and_members() {
    let zone = |text: &str| graph(1.0, 5.0, &format!("Zones:\n- {{Name: z, {text}}}\n"));
    let first = zone("Capacity: 1, Nodes: [1]");
    assert_eq!(
        differences(&first, &zone("Capacity: 2, Edges: [7]")),
        ["~ zone z: capacity 1 → capacity 2, other nodes or edges"]
    );
    assert_eq!(differences(&first, &zone("Rule: exclusive, Nodes: [1]")), [""; 0]);
    assert_eq!(differences(&first, &graph(1.0, 5.0, "")), ["- zone z"]);
}

#[test]
fn every_difference_is_named() {
    let more = "- {Id: 3, X: 9, Y: 9, Theta: 0}\n";
    let found = differences(&graph(1.0, 5.0, ""), &graph(2.0, 5.5, more));
    assert_eq!(
        found,
        [
            "~ node 2: moved by 0.500 m",
            "+ node 3",
            "~ edge 7: path differs by 0.500 m, speed 1 → 2 m/s"
        ]
    );
    assert_eq!(differences(&graph(1.0, 5.0, more), &graph(1.0, 5.0, "")), ["- node 3"]);
    let (first, mut second) = (graph(1.0, 5.0, ""), graph(1.0, 5.0, ""));
    let mut edges = second.edges().to_vec();
    edges[0].rotation.destination = Rotation::None;
    second = RouteGraph::from_valid_parts(second.nodes().to_vec(), edges);
    assert_eq!(
        differences(&first, &second),
        ["~ edge 7: rotation at its ends shorter and shorter → shorter and none"]
    );
}

#[test]
fn paths_are_compared_whatever_their_cubics_are() {
    let edge = |points: &str| {
        let text = format!(
            "Vertices:\n- {{Id: 1, X: 0, Y: 0, Theta: 0}}\n- {{Id: 2, X: 6, Y: 0, Theta: 0}}\n\
             Edges:\n- {{Id: 7, Origin_ID: 1, Destination_ID: 2, CurveType: Bezier, ControlPoints: [{points}], VelocityForward: 1, Zone: a}}\n"
        );
        parse(&text, "g", &ReadOptions::default()).expect("a graph").0
    };
    // The same curve, also as its first quarter and the rest, by de Casteljau's scheme.
    let whole = edge("[0, 0], [0, 4], [6, 4], [6, 0]");
    let parts =
        edge("[0, 0], [0, 1], [0.375, 1.75], [0.9375, 2.25], [2.625, 3.75], [6, 3], [6, 0]");
    assert_eq!(differences(&whole, &parts), [""; 0]);
    let other = edge("[0, 0], [0, 4.4], [6, 4.4], [6, 0]");
    assert_eq!(differences(&whole, &other), ["~ edge 7: path differs by 0.300 m"]);
}

#[test]
fn lines_of_the_background_are_counted() {
    let lines = |text: &str| graph(1.0, 5.0, &format!("Background: [{text}]\n"));
    let [ab, cd] = ["{Points: [[0, 0], [1, 0]]}", "{Points: [[0, 1], [1, 1]], Level: L2}"];
    let (first, second) = (lines(ab), lines(&format!("{ab}, {cd}, {cd}")));
    assert_eq!(differences(&first, &second), ["~ background: 2 lines more"]);
    assert_eq!(differences(&second, &lines(cd)), ["~ background: 2 lines fewer"]);
    assert_eq!(differences(&first, &lines(cd)), ["~ background: 1 line fewer, 1 line more"]);
    assert_eq!(differences(&second, &lines(&format!("{cd}, {ab}, {cd}"))), [""; 0]);
}
