//! Closed edges: nobody enters them, everybody else drives on.

use regatta_layout::{EdgeIndex, NodeIndex};
use regatta_plugin::command::{CommandKind, CommandRecord};
use regatta_plugin::event::{EventKind, Refusal};
use regatta_plugin::frame::RobotState;
use regatta_plugin::order::NO_ROBOT;

use super::support::*;
use crate::fleet::{Fleet, Placement, RouteSource};

/// Applies a command about an edge, by its index, and returns its events: kind, robot and id.
fn command(fleet: &mut Fleet, kind: CommandKind, edge: u32) -> Vec<(u32, u32, u32)> {
    let mut events = events();
    let record = CommandRecord {
        kind: kind as u32,
        robot: NO_ROBOT,
        id: 1000 + edge,
        ..CommandRecord::default()
    };
    fleet.apply(&[record], &mut events);
    events.records().iter().map(|event| (event.kind, event.robot, event.id)).collect()
}

fn assign(fleet: &mut Fleet, edges: &[u32]) -> (u32, u32) {
    let leg =
        |edge: &u32| CommandRecord { id: 1000 + edge, released: 1, ..CommandRecord::default() };
    let head = CommandRecord {
        kind: CommandKind::Assign as u32,
        legs: edges.len() as u32,
        ..CommandRecord::default()
    };
    let mut events = events();
    fleet.apply(
        &std::iter::once(head).chain(edges.iter().map(leg)).collect::<Vec<_>>(),
        &mut events,
    );
    (events.records()[0].kind, events.records()[0].detail)
}

/// Steps, and returns the position and the state of the first robot, and how often it began to
/// wait.
fn after(fleet: &mut Fleet, ticks: u32) -> (f32, RobotState, usize) {
    let mut events = events();
    (0..ticks).for_each(|_| fleet.step(None, &mut events));
    let waits = events
        .records()
        .iter()
        .filter(|event| event.kind == EventKind::WaitingForRelease as u32)
        .count();
    let frame = poses(fleet);
    (
        (frame.columns().x[0] * 1e3).round() / 1e3,
        RobotState::from_number(frame.columns().state[0]),
        waits,
    )
}

fn on_chain(acceleration: f32) -> Fleet {
    let graph = chain(&[(2.0, 1.0), (3.0, 1.0), (4.0, 1.0)]);
    let mut fleet = fleet(&graph, config(vec![robot_type(f32::INFINITY, acceleration)]));
    fleet
        .spawn(Placement::Edge(EdgeIndex(0), 1.0), 0, RouteSource::None, 0, &mut events())
        .expect("on the edge");
    fleet
}

#[test]
fn a_robot_waits_before_a_closed_edge_until_it_is_open() {
    for acceleration in [f32::INFINITY, 0.8] {
        let mut fleet = on_chain(acceleration);
        assert_eq!(assign(&mut fleet, &[1, 2]).0, EventKind::Accepted as u32);
        let closed = [(EventKind::Accepted, NO_ROBOT, 0), (EventKind::EdgeClosed, NO_ROBOT, 1002)];
        let closed = closed.map(|(kind, robot, id)| (kind as u32, robot, id));
        after(&mut fleet, 20);
        assert_eq!(command(&mut fleet, CommandKind::CloseEdge, 2), closed);
        assert_eq!(
            command(&mut fleet, CommandKind::CloseEdge, 2),
            closed[..1],
            "it is closed already"
        );
        assert_eq!(
            fleet.closed_edges().iter().map(|closed| closed.edge).collect::<Vec<_>>(),
            [1002]
        );
        assert_eq!(after(&mut fleet, 600), (5.0, RobotState::Waiting, 1));
        assert_eq!(command(&mut fleet, CommandKind::CloseEdge, 0).len(), 2);
        assert_eq!(
            command(&mut fleet, CommandKind::OpenEdge, 0).len(),
            2,
            "another edge doesn't start it"
        );
        assert_eq!(after(&mut fleet, 10), (5.0, RobotState::Waiting, 0));
        assert_eq!(
            command(&mut fleet, CommandKind::OpenEdge, 2)[1],
            (EventKind::EdgeOpened as u32, NO_ROBOT, 1002)
        );
        assert_eq!(after(&mut fleet, 600), (9.0, RobotState::Idle, 0));
        assert!(fleet.closed_edges().is_empty());
    }
}

#[test]
fn a_robot_leaves_a_closed_edge_and_brakes_in_time_before_the_next() {
    let mut fleet = on_chain(0.8);
    assign(&mut fleet, &[1, 2]);
    command(&mut fleet, CommandKind::CloseEdge, 0);
    assert_eq!(after(&mut fleet, 100).1, RobotState::Driving, "it leaves the closed edge");
    command(&mut fleet, CommandKind::CloseEdge, 2);
    let mut last = 1.0_f32;
    for _ in 0..400 {
        let frame = step(&mut fleet, &mut events());
        let speed = frame.columns().speed[0];
        assert!(
            speed >= last - 0.8 * 0.02 - 1e-4 || last == 1.0,
            "{last} to {speed}: it brakes as always"
        );
        last = speed;
    }
    assert_eq!(after(&mut fleet, 1), (5.0, RobotState::Waiting, 0));
}

#[test]
fn no_new_route_leads_along_a_closed_edge() {
    let mut fleet = on_chain(f32::INFINITY);
    command(&mut fleet, CommandKind::CloseEdge, 1);
    assert_eq!(
        assign(&mut fleet, &[1, 2]),
        (EventKind::Refused as u32, Refusal::EdgeClosed as u32)
    );
    assert_eq!(
        command(&mut fleet, CommandKind::OpenEdge, 7),
        [(EventKind::Refused as u32, NO_ROBOT, 1007)]
    );
    command(&mut fleet, CommandKind::OpenEdge, 1);
    assert_eq!(assign(&mut fleet, &[1, 2]).0, EventKind::Accepted as u32);
}

#[test]
fn random_walks_go_round_closed_edges() {
    let graph = town(4, 5.0);
    let mut fleet = fleet(&graph, config(vec![robot_type(f32::INFINITY, f32::INFINITY)]));
    for node in (0..16).cycle().take(64) {
        fleet
            .spawn(Placement::Node(NodeIndex(node)), 0, RouteSource::Random, 0, &mut events())
            .expect("on the node");
    }
    (0..200).for_each(|_| fleet.step(None, &mut events()));
    // Among them all that leave the first node: who is there waits.
    let closed: Vec<u32> = (0..graph.edges().len() as u32)
        .filter(|edge| graph.edge(EdgeIndex(*edge)).origin == NodeIndex(0) || edge % 5 == 0)
        .collect();
    closed
        .iter()
        .for_each(|edge| assert_eq!(command(&mut fleet, CommandKind::CloseEdge, *edge).len(), 2));
    let mut before: Vec<u32> = poses(&mut fleet).columns().edge.to_vec();
    let mut most_waiting = 0;
    for _ in 0..2000 {
        let frame = step(&mut fleet, &mut events());
        let columns = frame.columns();
        for (now, before) in columns.edge.iter().zip(&before).filter(|(now, before)| now != before)
        {
            assert!(!closed.contains(now), "from edge {before} to {now}, which is closed");
        }
        before = columns.edge.to_vec();
        let waiting =
            columns.state.iter().filter(|state| **state == RobotState::Waiting as u8).count();
        assert!(columns.state.iter().all(|state| *state != RobotState::Faulted as u8));
        most_waiting = most_waiting.max(waiting);
    }
    assert!(most_waiting > 0, "nobody came to the node without an exit");
    closed.iter().for_each(|edge| {
        assert_eq!(command(&mut fleet, CommandKind::OpenEdge, *edge)[1].2, 1000 + edge)
    });
    let frame = step(&mut fleet, &mut events());
    assert!(
        frame.columns().state.iter().all(|state| *state == RobotState::Driving as u8),
        "all drive on"
    );
}
