//! Driving without limits: how far, where to, and for how long.

use std::time::Duration;

use regatta_plugin::event::EventKind;
use regatta_plugin::frame::{NO_EDGE, RobotState};

use super::testing::*;
use super::{Events, Fleet, Placement, Repeat, RouteSource};
use crate::graph::{EdgeIndex, Leg, NodeIndex};

fn free() -> super::FleetConfig {
    config(vec![robot_type(f32::INFINITY, f32::INFINITY)])
}

fn spawn_on(fleet: &mut Fleet, node: u32, legs: &[Leg], repeat: Repeat) -> u32 {
    let source = RouteSource::Listed(legs.into(), repeat);
    fleet.spawn(Placement::Node(NodeIndex(node)), 0, source, 0, &mut events()).expect("a sound route")
}

fn seen(events: &Events, kind: EventKind) -> usize {
    events.records().iter().filter(|event| event.kind == kind as u32).count()
}

#[test]
fn distance_is_speed_times_time() {
    for (speed, hertz, ticks) in [(0.05, 1000, 20_000), (1.0, 60, 600), (1.7, 500, 5000), (50.0, 10, 100)] {
        let graph = lane(&[(3.0, speed), (0.011, speed), (900.0, speed)]);
        let config = super::FleetConfig { tick_period: Duration::from_secs(1) / hertz, ..free() };
        let mut fleet = fleet(&graph, config);
        spawn_on(&mut fleet, 0, &[forward(0), forward(1), forward(2)], Repeat::Once);
        for _ in 0..ticks {
            fleet.step(None, &mut events());
        }
        let x = f64::from(look(&mut fleet).columns().x[0]);
        let wanted = speed * f64::from(ticks) / f64::from(hertz);
        assert!((x - wanted).abs() < 0.001 * wanted, "{speed} m/s at {hertz} Hz: {x} m for {wanted} m");
    }
}

#[test]
fn a_change_of_speed_keeps_time() {
    let graph = lane(&[(1.01, 1.0), (5.0, 2.0)]);
    let mut fleet = fleet(&graph, free());
    spawn_on(&mut fleet, 0, &[forward(0), forward(1)], Repeat::Once);
    (0..51).for_each(|_| fleet.step(None, &mut events()));
    let frame = look(&mut fleet);
    assert!((frame.columns().x[0] - 1.03).abs() < 1e-5, "{}", frame.columns().x[0]);
    assert_eq!((frame.columns().speed[0], frame.columns().edge[0]), (2.0, 1));
    assert!((frame.columns().s[0] - 0.02).abs() < 1e-5);
}

#[test]
fn a_route_ends_in_the_nodes_pose_and_says_so() {
    let graph = town(3, 7.3);
    let mut fleet = fleet(&graph, free());
    let first = graph.departures(NodeIndex(0))[0];
    let robot = spawn_on(&mut fleet, 0, &[first], Repeat::Once);
    let mut events = events();
    (0..2000).for_each(|_| fleet.step(None, &mut events));
    let frame = look(&mut fleet);
    let end = graph.node(graph.leg_end(first));
    assert_eq!((frame.columns().x[0], frame.columns().y[0]), (end.position.x as f32, end.position.y as f32));
    assert_eq!((frame.columns().speed[0], frame.columns().state[0]), (0.0, RobotState::Idle as u8));
    assert_eq!(frame.columns().edge[0], first.edge.0);
    let [reached, done] = events.records() else { panic!("{:?}", events.records()) };
    assert_eq!((reached.kind, reached.robot, reached.id), (EventKind::ReachedNode as u32, robot, end.id));
    assert_eq!(done.kind, EventKind::RouteDone as u32);
}

#[test]
fn reverse_gear_drives_back_with_the_same_heading() {
    let graph = lane(&[(2.0, 1.0), (2.0, 1.0)]);
    let mut fleet = fleet(&graph, free());
    spawn_on(&mut fleet, 0, &[forward(0), reverse(0)], Repeat::Loop);
    (0..110).for_each(|_| fleet.step(None, &mut events()));
    let frame = look(&mut fleet);
    let columns = frame.columns();
    assert_eq!((columns.theta[0], columns.speed[0], columns.edge[0]), (0.0, -0.5, 0));
    assert!((columns.x[0] - 1.9).abs() < 1e-5 && (columns.s[0] - 1.9).abs() < 1e-5, "{}", columns.x[0]);
    (0..190 + 50).for_each(|_| fleet.step(None, &mut events()));
    assert!((look(&mut fleet).columns().x[0] - 1.0).abs() < 1e-4, "a loop goes on");
}

#[test]
fn walks_never_stop_where_every_node_has_a_way_on() {
    let graph = town(5, 4.0);
    let mut fleet = fleet(&graph, free());
    for node in 0..25 {
        fleet.spawn(Placement::Node(NodeIndex(node)), 0, RouteSource::Random, 0, &mut events()).expect("a node");
    }
    let mut been = vec![false; graph.edges().len()];
    for _ in 0..20_000 {
        fleet.step(None, &mut events());
        let frame = look(&mut fleet);
        frame.columns().edge.iter().for_each(|&edge| been[edge as usize] = true);
        assert_eq!(fleet.robots_by_state(), [0, 25, 0, 0, 0]);
    }
    assert!(been.iter().all(|&been| been), "walks come everywhere");
}

#[test]
fn a_walk_turns_back_only_if_it_must() {
    let graph = town(2, 4.0);
    let mut fleet = fleet(&graph, free());
    fleet.spawn(Placement::Node(NodeIndex(0)), 0, RouteSource::Random, 0, &mut events()).expect("a node");
    let mut nodes = Vec::new();
    let mut events = events();
    (0..20_000).for_each(|_| fleet.step(None, &mut events));
    nodes.extend(events.records().iter().map(|event| event.id));
    assert!(nodes.len() > 50 && nodes.windows(3).all(|way| way[0] != way[2]), "{nodes:?}");
}

#[test]
fn a_dead_end_is_a_fault() {
    let graph = lane(&[(1.0, 1.0)]);
    let mut fleet = fleet(&graph, free());
    let mut events = events();
    fleet.spawn(Placement::Edge(EdgeIndex(0), 0.25), 0, RouteSource::Random, 9, &mut events).expect("an edge");
    assert_eq!(events.records()[0].token, 9);
    (0..100).for_each(|_| fleet.step(None, &mut events));
    assert_eq!(fleet.states(), [RobotState::Faulted as u8]);
    assert_eq!(seen(&events, EventKind::Faulted), 1);
}

#[test]
fn robots_stand_where_they_are_put() {
    let graph = lane(&[(11.0, 1.0)]);
    let mut fleet = fleet(&graph, free());
    let mut put = |placement| fleet.spawn(placement, 0, RouteSource::None, 0, &mut events());
    put(Placement::Edge(EdgeIndex(0), 8.25)).expect("on the edge");
    put(Placement::Edge(EdgeIndex(0), 0.0)).expect("its start");
    put(Placement::Edge(EdgeIndex(0), 11.0)).expect("its end");
    put(Placement::Node(NodeIndex(1))).expect("a node");
    assert!(put(Placement::Edge(EdgeIndex(0), 11.1)).is_err() && put(Placement::Edge(EdgeIndex(0), f32::NAN)).is_err());
    assert!(put(Placement::Edge(EdgeIndex(0), -0.1)).is_err() && put(Placement::Node(NodeIndex(2))).is_err());
    fleet.step(None, &mut events());
    let frame = look(&mut fleet);
    let columns = frame.columns();
    assert_eq!(columns.x, [8.25, 0.0, 11.0, 11.0]);
    assert_eq!(columns.s, [8.25, 0.0, 11.0, 0.0]);
    assert_eq!(columns.edge, [0, 0, 0, NO_EDGE]);
    assert_eq!(columns.state, [RobotState::Idle as u8; 4]);
}

#[test]
fn lowest_free_ids_are_given_first_and_the_tail_is_cut() {
    let graph = lane(&[(1.0, 1.0)]);
    let mut fleet = fleet(&graph, free());
    let spawn = |fleet: &mut Fleet| {
        fleet.spawn(Placement::Node(NodeIndex(0)), 0, RouteSource::None, 0, &mut events()).expect("a node")
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
fn memory_per_robot_is_small() {
    let graph = lane(&[(1.0, 1.0)]);
    let free_fleet = fleet(&graph, free());
    let limited = fleet(&graph, config(vec![robot_type(1.0, 1.0)]));
    assert_eq!((free_fleet.bytes_per_robot(), limited.bytes_per_robot()), (31, 47));
}

#[test]
fn impossible_fleets_are_refused() {
    let graph = lane(&[(1.0, 50.0)]);
    let tracks = std::sync::Arc::new(crate::graph::arc_length::Tracks::compile(&graph));
    let new = |config| Fleet::new(graph.clone(), tracks.clone(), config).map(drop).unwrap_err().to_string();
    assert!(new(super::FleetConfig { tick_period: Duration::from_secs(1), ..free() }).contains("50.0 m"));
    assert!(new(config(vec![robot_type(1.0, 0.0)])).contains("test"));
    assert!(new(config(vec![robot_type(f32::NAN, 1.0)])).contains("test"));
}
