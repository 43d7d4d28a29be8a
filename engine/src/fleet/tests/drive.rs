//! Driving without acceleration limits: distances, routes and durations.

use std::sync::Arc;
use std::time::Duration;

use regatta_layout::{EdgeIndex, Leg, NodeIndex};
use regatta_plugin::event::EventKind;
use regatta_plugin::frame::{NO_EDGE, RobotState};
use regatta_scenario::Repeat;

use super::support::*;
use crate::fleet::{EventBuffer, Fleet, FleetConfig, Placement, RouteSource};

fn without_limits() -> FleetConfig {
    config(vec![robot_type(f32::INFINITY, f32::INFINITY)])
}

fn spawn_on(fleet: &mut Fleet, node: u32, legs: &[Leg], repeat: Repeat) -> u32 {
    let source = RouteSource::Listed(legs.into(), repeat);
    fleet
        .spawn(Placement::Node(NodeIndex(node)), 0, source, 0, &mut events())
        .expect("a valid route")
}

fn count(events: &EventBuffer, kind: EventKind) -> usize {
    events.records().iter().filter(|event| event.kind == kind as u32).count()
}

#[test]
fn distance_is_speed_times_time() {
    for (speed, hertz, ticks) in
        [(0.05, 1000, 20_000), (1.0, 60, 600), (1.7, 500, 5000), (50.0, 10, 100)]
    {
        let graph = chain(&[(3.0, speed), (0.011, speed), (900.0, speed)]);
        let config =
            FleetConfig { tick_period: Duration::from_secs(1) / hertz, ..without_limits() };
        let mut fleet = fleet(&graph, config);
        spawn_on(&mut fleet, 0, &[forward(0), forward(1), forward(2)], Repeat::Once);
        for _ in 0..ticks {
            fleet.step(None, &mut events());
        }
        let x = f64::from(poses(&mut fleet).columns().x[0]);
        let expected = speed * f64::from(ticks) / f64::from(hertz);
        assert!(
            (x - expected).abs() < 0.001 * expected,
            "{speed} m/s at {hertz} Hz: {x} m instead of {expected} m"
        );
    }
}

#[test]
fn a_change_of_speed_within_a_tick_keeps_the_time() {
    let graph = chain(&[(1.01, 1.0), (5.0, 2.0)]);
    let mut fleet = fleet(&graph, without_limits());
    spawn_on(&mut fleet, 0, &[forward(0), forward(1)], Repeat::Once);
    (0..51).for_each(|_| fleet.step(None, &mut events()));
    let frame = poses(&mut fleet);
    assert!((frame.columns().x[0] - 1.03).abs() < 1e-5, "{}", frame.columns().x[0]);
    assert_eq!((frame.columns().speed[0], frame.columns().edge[0]), (2.0, 1));
    assert!((frame.columns().s[0] - 0.02).abs() < 1e-5);
}

#[test]
fn a_route_ends_in_the_pose_of_its_last_node_and_is_reported() {
    let graph = town(3, 7.3);
    let mut fleet = fleet(&graph, without_limits());
    let first = graph.departures(NodeIndex(0))[0];
    let robot = spawn_on(&mut fleet, 0, &[first], Repeat::Once);
    let mut events = events();
    (0..2000).for_each(|_| fleet.step(None, &mut events));
    let frame = poses(&mut fleet);
    let end = graph.node(graph.leg_end(first));
    assert_eq!(
        (frame.columns().x[0], frame.columns().y[0]),
        (end.position.x as f32, end.position.y as f32)
    );
    assert_eq!((frame.columns().speed[0], frame.columns().state[0]), (0.0, RobotState::Idle as u8));
    assert_eq!(frame.columns().edge[0], first.edge.0);
    let [reached, done] = events.records() else { panic!("{:?}", events.records()) };
    assert_eq!(
        (reached.kind, reached.robot, reached.id),
        (EventKind::ReachedNode as u32, robot, end.id)
    );
    assert_eq!(done.kind, EventKind::RouteDone as u32);
}

#[test]
fn reverse_gear_drives_back_with_the_same_heading() {
    let graph = chain(&[(2.0, 1.0), (2.0, 1.0)]);
    let mut fleet = fleet(&graph, without_limits());
    spawn_on(&mut fleet, 0, &[forward(0), reverse(0)], Repeat::Loop);
    (0..110).for_each(|_| fleet.step(None, &mut events()));
    let frame = poses(&mut fleet);
    let columns = frame.columns();
    assert_eq!((columns.theta[0], columns.speed[0], columns.edge[0]), (0.0, -0.5, 0));
    assert!(
        (columns.x[0] - 1.9).abs() < 1e-5 && (columns.s[0] - 1.9).abs() < 1e-5,
        "{}",
        columns.x[0]
    );
    (0..190 + 50).for_each(|_| fleet.step(None, &mut events()));
    assert!((poses(&mut fleet).columns().x[0] - 1.0).abs() < 1e-4, "a loop goes on");
}

#[test]
fn random_walks_never_stop_without_dead_ends() {
    let graph = town(5, 4.0);
    let mut fleet = fleet(&graph, without_limits());
    for node in 0..25 {
        fleet
            .spawn(Placement::Node(NodeIndex(node)), 0, RouteSource::Random, 0, &mut events())
            .expect("a node");
    }
    let mut visited = vec![false; graph.edges().len()];
    for _ in 0..20_000 {
        fleet.step(None, &mut events());
        let frame = poses(&mut fleet);
        frame.columns().edge.iter().for_each(|&edge| visited[edge as usize] = true);
        assert_eq!(fleet.robots_by_state(), [0, 25, 0, 0, 0, 0, 0, 0]);
    }
    assert!(visited.iter().all(|&visited| visited), "random walks visit every edge");
}

#[test]
fn a_random_walk_turns_back_only_at_dead_ends() {
    let graph = town(2, 4.0);
    let mut fleet = fleet(&graph, without_limits());
    fleet
        .spawn(Placement::Node(NodeIndex(0)), 0, RouteSource::Random, 0, &mut events())
        .expect("a node");
    let mut nodes = Vec::new();
    let mut events = events();
    (0..20_000).for_each(|_| fleet.step(None, &mut events));
    nodes.extend(events.records().iter().map(|event| event.id));
    assert!(nodes.len() > 50 && nodes.windows(3).all(|three| three[0] != three[2]), "{nodes:?}");
}

#[test]
fn a_random_walk_faults_at_a_dead_end() {
    let graph = chain(&[(1.0, 1.0)]);
    let mut fleet = fleet(&graph, without_limits());
    let mut events = events();
    fleet
        .spawn(Placement::Edge(EdgeIndex(0), 0.25), 0, RouteSource::Random, 9, &mut events)
        .expect("an edge");
    assert_eq!(events.records()[0].token, 9);
    (0..100).for_each(|_| fleet.step(None, &mut events));
    assert_eq!(fleet.states(), [RobotState::Faulted as u8]);
    assert_eq!(count(&events, EventKind::Faulted), 1);
}

#[test]
fn robots_without_a_route_stay_where_they_were_spawned() {
    let graph = chain(&[(11.0, 1.0)]);
    let mut fleet = fleet(&graph, without_limits());
    let mut spawn = |placement| fleet.spawn(placement, 0, RouteSource::None, 0, &mut events());
    spawn(Placement::Edge(EdgeIndex(0), 8.25)).expect("on the edge");
    spawn(Placement::Edge(EdgeIndex(0), 0.0)).expect("its start");
    spawn(Placement::Edge(EdgeIndex(0), 11.0)).expect("its end");
    spawn(Placement::Node(NodeIndex(1))).expect("a node");
    assert!(
        spawn(Placement::Edge(EdgeIndex(0), 11.1)).is_err()
            && spawn(Placement::Edge(EdgeIndex(0), f32::NAN)).is_err()
    );
    assert!(
        spawn(Placement::Edge(EdgeIndex(0), -0.1)).is_err()
            && spawn(Placement::Node(NodeIndex(2))).is_err()
    );
    fleet.step(None, &mut events());
    let frame = poses(&mut fleet);
    let columns = frame.columns();
    assert_eq!(columns.x, [8.25, 0.0, 11.0, 11.0]);
    assert_eq!(columns.s, [8.25, 0.0, 11.0, 0.0]);
    assert_eq!(columns.edge, [0, 0, 0, NO_EDGE]);
    assert_eq!(columns.state, [RobotState::Idle as u8; 4]);
}

#[test]
fn the_lowest_free_id_is_used_first_and_absent_rows_at_the_end_are_dropped() {
    let graph = chain(&[(1.0, 1.0)]);
    let mut fleet = fleet(&graph, without_limits());
    let spawn = |fleet: &mut Fleet| {
        fleet
            .spawn(Placement::Node(NodeIndex(0)), 0, RouteSource::None, 0, &mut events())
            .expect("a node")
    };
    (0..200).for_each(|id| assert_eq!(spawn(&mut fleet), id));
    for id in [3, 70, 198] {
        fleet.remove(id, &mut events()).expect("it is there");
        assert!(fleet.remove(id, &mut events()).is_err());
    }
    assert_eq!((fleet.robots(), fleet.present()), (200, 197));
    fleet.remove(199, &mut events()).expect("it is there");
    assert_eq!((fleet.robots(), fleet.present()), (198, 196));
    assert_eq!([spawn(&mut fleet), spawn(&mut fleet), spawn(&mut fleet)], [3, 70, 198]);
    (0..199).for_each(|id| fleet.remove(id, &mut events()).expect("it is there"));
    assert_eq!((fleet.robots(), fleet.present()), (0, 0));
    step(&mut fleet, &mut events());
}

#[test]
fn memory_per_robot_is_31_or_51_bytes() {
    let graph = chain(&[(1.0, 1.0)]);
    let unlimited = fleet(&graph, without_limits());
    let limited = fleet(&graph, config(vec![robot_type(1.0, 1.0)]));
    assert_eq!((unlimited.bytes_per_robot(), limited.bytes_per_robot()), (31, 51));
}

#[test]
fn invalid_fleets_are_refused() {
    let graph = chain(&[(1.0, 50.0)]);
    let tracks = Arc::new(crate::arc_length::compile(&graph));
    let new = |config| {
        Fleet::new(graph.clone(), tracks.clone(), config).map(drop).unwrap_err().to_string()
    };
    assert!(
        new(FleetConfig { tick_period: Duration::from_secs(1), ..without_limits() })
            .contains("50.0 m")
    );
    assert!(new(config(vec![robot_type(1.0, 0.0)])).contains("test"));
    assert!(new(config(vec![robot_type(f32::NAN, 1.0)])).contains("test"));
}
