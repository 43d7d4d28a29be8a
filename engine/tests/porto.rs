//! Compares `graphs/porto.yaml` with the published parts of the dissertation's graph, and
//! `graphs/thirty.yaml` with its routes.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use regatta_engine::arc_length;
use regatta_layout::{Gear, Leg, NodeIndex, ReadOptions, RouteGraph, read};
use regatta_motion::Distance;
use regatta_scenario::{Overrides, Scenario, Start, Told};

/// Tables 5.1 and 5.3: a route, and the target X, Y and θ (degrees) of its end. Two rows have the
/// simulated target 90.03 where the row of the single edge has 90; here it is 90.
const END_POSES: [(&[u32], [f64; 3]); 18] = [
    (&[45], [13.00, 13.50, 90.0]),
    (&[34], [-5.0, -8.0, 180.0]),
    (&[16], [29.00, -15.5, -90.0]),
    (&[12], [27.00, 17.50, 180.0]),
    (&[11], [16.52, 10.47, 180.0]),
    (&[13], [12.99, 17.50, 180.0]),
    (&[23], [35.00, 18.50, 0.0]),
    (&[31], [36.14, 29.94, 90.0]),
    (&[29], [17.16, 23.34, 90.0]),
    (&[27], [-5.00, -8.00, 180.0]),
    (&[34, 45], [13.00, 13.50, 90.0]),
    (&[13, 34], [-5.00, -8.00, 180.0]),
    (&[23, 16], [29.00, -15.5, -90.0]),
    (&[11, 13, 34], [-5.00, -8.00, 180.0]),
    (&[23, 16, 12, 11], [16.52, 10.47, 180.0]),
    (&[29, 31], [36.14, 29.94, 90.0]),
    (&[23, 16, 12, 11, 13], [12.99, 17.50, 180.0]),
    (&[23, 16, 12, 11, 13, 34, 45], [13.00, 13.5, 90.0]),
];

/// Tables 5.5 to 5.7: routes, and the time in seconds that one robot took.
const TIMES: [(&[u32], f64); 3] = [(&[23, 16, 12], 15.57), (&[84, 85], 10.31), (&[64, 65], 10.05)];
/// The allowed difference in seconds: the lengths and speeds of the reconstruction are invented.
const TIME_TOLERANCE: f64 = 0.05;

/// The routes of the thirty-robot test, by robot.
const THIRTY: [&[u32]; 30] = [
    &[64, 65],
    &[100, 101, 102],
    &[103, 104],
    &[23, 16],
    &[55, 56],
    &[22, 15],
    &[11, 13],
    &[53, 54],
    &[51, 52],
    &[57, 99],
    &[58, 59],
    &[106],
    &[62, 63],
    &[105],
    &[66, 67],
    &[68],
    &[69, 70],
    &[71, 72],
    &[73, 74],
    &[76],
    &[77, 78],
    &[79, 80],
    &[81, 87],
    &[82, 83],
    &[84, 85],
    &[86],
    &[88, 89],
    &[90],
    &[98],
    &[96, 97],
];

fn graphs(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../graphs").join(name)
}

fn porto() -> RouteGraph {
    let (graph, findings) = read(&graphs("porto.yaml"), &ReadOptions::default())
        .unwrap_or_else(|error| panic!("{error}"));
    assert!(findings.as_slice().is_empty(), "{findings:#?}");
    graph
}

fn legs(graph: &RouteGraph, route: &[u32]) -> Vec<Leg> {
    let edge = |&id: &u32| graph.edge_by_id(id).unwrap_or_else(|| panic!("no edge {id}"));
    route.iter().map(edge).map(|edge| Leg { edge, gear: Gear::Forward }).collect()
}

#[test]
fn routes_end_at_the_published_poses() {
    let graph = porto();
    let tracks = arc_length::compile(&graph);
    for (route, [x, y, degrees]) in END_POSES {
        let last = tracks.track(*legs(&graph, route).last().unwrap()).unwrap().last_piece();
        let piece = tracks.pieces()[last as usize];
        let theta = degrees.to_radians();
        assert_eq!((piece.x[0], piece.y[0]), (x as f32, y as f32), "{route:?}");
        assert_eq!((piece.x[1], piece.y[1]), (theta.cos() as f32, theta.sin() as f32), "{route:?}");
    }
}

#[test]
fn edge_34_starts_at_the_position_in_the_figure() {
    let graph = porto();
    let start = graph.node(graph.edge(graph.edge_by_id(34).unwrap()).origin).position;
    assert!((start.x - 13.0).abs() < 0.05 && start.y == 17.5, "{start}");
}

#[test]
fn headings_are_continuous_along_routes() {
    let graph = porto();
    let tracks = arc_length::compile(&graph);
    let all = END_POSES.iter().map(|row| row.0).chain(TIMES.iter().map(|row| row.0)).chain(THIRTY);
    for route in all {
        for pair in legs(&graph, route).windows(2) {
            assert_eq!(graph.leg_end(pair[0]), graph.leg_start(pair[1]), "{route:?}");
            let end = tracks.pieces()[tracks.track(pair[0]).unwrap().last_piece() as usize]
                .derivative(0.0);
            let row = tracks.track(pair[1]).unwrap().first_piece as usize;
            let length: Distance = tracks.infos()[row].length;
            let start = tracks.pieces()[row].derivative(-length.to_metres() as f32);
            assert!(
                end.angle_to(start).abs() < 1e-5,
                "{route:?} turns by {} rad",
                end.angle_to(start)
            );
        }
    }
}

#[test]
fn routes_take_about_as_long_as_published() {
    let graph = porto();
    let tracks = arc_length::compile(&graph);
    let time = |leg: Leg| tracks.edge_length(leg.edge) / graph.leg_speed(leg).unwrap();
    for (route, published) in TIMES {
        let seconds: f64 = legs(&graph, route).into_iter().map(time).sum();
        assert!((seconds - published).abs() < TIME_TOLERANCE, "{route:?} takes {seconds} s");
    }
}

#[test]
fn thirty_robots_drive_the_published_routes_between_different_nodes() {
    let scenario = Scenario::read(&graphs("thirty.yaml"), &Overrides::default())
        .unwrap_or_else(|error| panic!("{error}"));
    let warnings = scenario.warnings.told(Told::All);
    assert!(warnings.is_empty(), "{warnings:?}");
    let graph = &scenario.graph;
    let (mut starts, mut ends) = (BTreeSet::new(), BTreeSet::new());
    for (robot, route) in THIRTY.iter().enumerate() {
        let Start::Route { legs, .. } = &scenario.group_of(robot as u32).start else {
            panic!("robot {robot} has no route")
        };
        let ids: Vec<u32> = legs.iter().map(|leg| graph.edge(leg.edge).id).collect();
        assert_eq!(&ids, route, "robot {}", robot + 1);
        starts.insert(graph.leg_start(legs[0]));
        ends.insert(graph.leg_end(legs[legs.len() - 1]));
    }
    assert_eq!((starts.len(), ends.len()), (30, 30), "robots would overlap");
    assert_eq!(scenario.robots(), 30);
}

#[test]
fn every_node_can_be_reached_from_every_other_in_forward_gear() {
    let graph = porto();
    for (start, _) in (0..).map(NodeIndex).zip(graph.nodes()) {
        let mut reached = BTreeSet::from([start]);
        let mut open = vec![start];
        while let Some(node) = open.pop() {
            let forward = graph.departures(node).iter().filter(|leg| leg.gear == Gear::Forward);
            open.extend(
                forward.map(|&leg| graph.leg_end(leg)).filter(|&next| reached.insert(next)),
            );
        }
        assert_eq!(reached.len(), graph.nodes().len(), "from {:?}", graph.node(start));
    }
}
