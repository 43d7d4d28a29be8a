//! Robots that stall and break down.

use regatta_layout::NodeIndex;
use regatta_plugin::command::{CommandKind, CommandRecord};
use regatta_plugin::event::EventKind;
use regatta_plugin::frame::RobotState;
use regatta_scenario::Repeat;

use super::support::*;
use crate::fleet::{Fleet, Placement, RouteSource};

/// Returns a fleet of one robot that drives 50 m at 1 m/s.
fn driving(acceleration: f32) -> Fleet {
    let mut fleet = fleet(
        &chain(&[(50.0, 1.0), (5.0, 1.0)]),
        config(vec![robot_type(f32::INFINITY, acceleration)]),
    );
    let route = RouteSource::Listed([forward(0)].into(), Repeat::Once);
    fleet.spawn(Placement::Node(NodeIndex(0)), 0, route, 0, &mut events()).expect("a route");
    (0..200).for_each(|_| fleet.step(None, &mut events()));
    fleet
}

/// Applies a command and returns the kinds of its events.
fn apply(fleet: &mut Fleet, kind: CommandKind) -> Vec<u32> {
    let mut events = events();
    fleet.apply(&[CommandRecord { kind: kind as u32, ..CommandRecord::default() }], &mut events);
    events.records().iter().map(|event| event.kind).collect()
}

/// Steps and returns the position, the speed and the state.
fn after(fleet: &mut Fleet, ticks: u32) -> (f32, f32, RobotState) {
    (0..ticks).for_each(|_| fleet.step(None, &mut events()));
    let frame = poses(fleet);
    let columns = frame.columns();
    (columns.x[0], columns.speed[0], RobotState::from_number(columns.state[0]))
}

#[test]
fn a_broken_robot_brakes_stands_and_goes_on_when_it_is_repaired() {
    for acceleration in [f32::INFINITY, 0.5] {
        let mut fleet = driving(acceleration);
        let before = after(&mut fleet, 0).0;
        let (accepted, broken) = (EventKind::Accepted as u32, EventKind::BrokenDown as u32);
        assert_eq!(apply(&mut fleet, CommandKind::Break), [accepted, broken]);
        assert_eq!(apply(&mut fleet, CommandKind::Break), [accepted], "it is broken already");
        let (x, speed, state) = after(&mut fleet, 200);
        assert_eq!((speed, state), (0.0, RobotState::Broken));
        // Braking from 1 m/s takes 1 m.
        let metres = if acceleration.is_finite() { 1.0 } else { 0.0 };
        assert!((x - before - metres).abs() < 0.05, "{before} to {x}");
        assert_eq!(apply(&mut fleet, CommandKind::Repair), [accepted, EventKind::Repaired as u32]);
        assert_eq!(apply(&mut fleet, CommandKind::Repair), [accepted]);
        assert_eq!(after(&mut fleet, 4000).0, 50.0);
        assert_eq!(after(&mut fleet, 0).2, RobotState::Idle);
    }
}

#[test]
fn commands_for_an_impaired_robot_take_effect_afterwards() {
    let mut fleet = driving(0.5);
    fleet.stall(0, &mut events());
    assert_eq!(after(&mut fleet, 200).2, RobotState::Stalled);
    apply(&mut fleet, CommandKind::Hold);
    assert_eq!(after(&mut fleet, 10).2, RobotState::Stalled);
    let mut restored = events();
    fleet.recover(0, &mut restored);
    let kinds: Vec<_> = restored.records().iter().map(|event| event.kind).collect();
    assert_eq!(kinds, [EventKind::Recovered as u32, EventKind::Held as u32]);
    assert_eq!(after(&mut fleet, 10).1, 0.0);
    fleet.stall(0, &mut events());
    assert_eq!(
        apply(&mut fleet, CommandKind::Resume),
        [EventKind::Accepted as u32, EventKind::Resumed as u32]
    );
    assert_eq!(after(&mut fleet, 10), (after(&mut fleet, 0).0, 0.0, RobotState::Stalled));
    apply(&mut fleet, CommandKind::Cancel);
    let legs =
        CommandRecord { kind: CommandKind::Assign as u32, legs: 1, ..CommandRecord::default() };
    let leg = CommandRecord { id: 1001, released: 1, ..CommandRecord::default() };
    fleet.apply(&[legs, leg], &mut events());
    assert_eq!(after(&mut fleet, 10).2, RobotState::Stalled);
    fleet.recover(0, &mut events());
    assert_eq!(after(&mut fleet, 4000).0, 55.0);
}

#[test]
fn a_robot_that_stalls_and_breaks_needs_both_to_end() {
    let mut fleet = driving(f32::INFINITY);
    fleet.stall(0, &mut events());
    fleet.break_down(0, &mut events());
    fleet.recover(0, &mut events());
    assert_eq!(after(&mut fleet, 10).2, RobotState::Broken);
    fleet.repair(0, &mut events());
    assert_eq!(after(&mut fleet, 10).2, RobotState::Driving);
}

#[test]
fn an_idle_robot_is_idle_after_a_stall_and_a_removed_one_leaves_nothing() {
    let mut fleet = driving(f32::INFINITY);
    after(&mut fleet, 4000);
    fleet.stall(0, &mut events());
    assert_eq!(after(&mut fleet, 1).2, RobotState::Stalled);
    fleet.recover(0, &mut events());
    assert_eq!(after(&mut fleet, 1).2, RobotState::Idle);
    fleet.break_down(0, &mut events());
    fleet.remove(0, &mut events()).expect("a robot");
    fleet.repair(0, &mut events());
    let place = Placement::Node(NodeIndex(0));
    fleet.spawn(place, 0, RouteSource::None, 0, &mut events()).expect("a node");
    assert_eq!(after(&mut fleet, 1).2, RobotState::Idle);
}

#[test]
fn speeds_vary_by_robot_and_edge_within_the_limit() {
    let graph = town(3, 6.0);
    let mut fleet = fleet(&graph, config(vec![robot_type(f32::INFINITY, f32::INFINITY)]));
    fleet.vary_speeds(0.1, 7);
    for _ in 0..40 {
        fleet
            .spawn(Placement::Node(NodeIndex(4)), 0, RouteSource::Random, 0, &mut events())
            .expect("a node");
    }
    let frame = step(&mut fleet, &mut events());
    let columns = frame.columns();
    let share = |robot: usize| {
        columns.speed[robot] / graph.edges()[columns.edge[robot] as usize].speed as f32
    };
    let shares: Vec<_> = (0..40).map(share).collect();
    assert!(shares.iter().all(|share| (0.9..=1.0).contains(share)), "{shares:?}");
    assert!(shares.iter().any(|share| *share < 0.94) && shares.iter().any(|share| *share > 0.96));
}
