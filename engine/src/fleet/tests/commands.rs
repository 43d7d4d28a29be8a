//! Commands: their effects, and every reason to refuse them.

use std::sync::Arc;

use regatta_layout::{EdgeIndex, Leg, NodeIndex};
use regatta_plugin::command::{Authority, CommandKind, CommandRecord};
use regatta_plugin::event::{EventKind, Refusal};
use regatta_plugin::frame::RobotState;
use regatta_scenario::Repeat;

use super::support::*;
use crate::fleet::{Fleet, FleetConfig, Placement, RouteSource};

const TOKEN: u64 = 77;

fn command(kind: CommandKind) -> CommandRecord {
    CommandRecord { token: TOKEN, kind: kind as u32, ..CommandRecord::default() }
}

/// Returns the record of a leg along an edge, by its index.
fn leg(edge: u32, released: bool) -> CommandRecord {
    CommandRecord { id: 1000 + edge, released: released.into(), ..command(CommandKind::Leg) }
}

fn route(kind: CommandKind, legs: &[CommandRecord]) -> Vec<CommandRecord> {
    let head = CommandRecord { legs: legs.len() as u32, ..command(kind) };
    std::iter::once(head).chain(legs.iter().copied()).collect()
}

/// Applies a sample of commands and returns its events: kind, id and detail.
fn apply(fleet: &mut Fleet, commands: &[CommandRecord]) -> Vec<(u32, u32, u32)> {
    let mut events = events();
    fleet.apply(commands, &mut events);
    events.records().iter().map(|event| (event.kind, event.id, event.detail)).collect()
}

fn refused(reason: Refusal, id: u32) -> Vec<(u32, u32, u32)> {
    vec![(EventKind::Refused as u32, id, reason as u32)]
}

const ACCEPTED: (u32, u32, u32) = (EventKind::Accepted as u32, 0, 0);

fn on_chain() -> Fleet {
    let graph = chain(&[(2.0, 1.0), (3.0, 1.0), (4.0, 1.0), (5.0, 1.0)]);
    let mut fleet = fleet(&graph, config(vec![robot_type(f32::INFINITY, f32::INFINITY)]));
    fleet
        .spawn(Placement::Edge(EdgeIndex(0), 1.0), 0, RouteSource::None, 0, &mut events())
        .expect("on the edge");
    fleet
}

/// Steps and returns the position and the state of the first robot.
fn after(fleet: &mut Fleet, ticks: u32) -> (f32, u8) {
    (0..ticks).for_each(|_| fleet.step(None, &mut events()));
    let frame = poses(fleet);
    (frame.columns().x[0], frame.columns().state[0])
}

fn near(found: (f32, u8), x: f32, state: RobotState) -> bool {
    (found.0 - x).abs() < 1e-4 && found.1 == state as u8
}

#[test]
fn a_robot_drives_its_base_waits_at_its_end_and_is_extended() {
    let mut fleet = on_chain();
    let assign = route(CommandKind::Assign, &[leg(1, true), leg(2, false)]);
    assert_eq!(apply(&mut fleet, &assign), [ACCEPTED]);
    assert!(
        near(after(&mut fleet, 50), 2.0, RobotState::Driving),
        "the robot finishes its edge first"
    );
    assert!(near(after(&mut fleet, 200), 5.0, RobotState::Waiting));
    assert_eq!(apply(&mut fleet, &route(CommandKind::Extend, &[leg(2, true)])), [ACCEPTED]);
    assert!(near(after(&mut fleet, 100), 7.0, RobotState::Driving));
    let more = route(CommandKind::Extend, &[leg(3, true)]);
    assert_eq!(apply(&mut fleet, &more), [ACCEPTED]);
    assert!(near(after(&mut fleet, 1000), 14.0, RobotState::Idle));
}

#[test]
fn a_cancelled_robot_finishes_its_edge() {
    let mut fleet = on_chain();
    apply(&mut fleet, &route(CommandKind::Assign, &[leg(1, true), leg(2, true)]));
    after(&mut fleet, 100);
    assert_eq!(apply(&mut fleet, &[command(CommandKind::Cancel)]), [ACCEPTED]);
    assert!(near(after(&mut fleet, 1000), 5.0, RobotState::Idle));
    assert_eq!(apply(&mut fleet, &[command(CommandKind::Cancel)]), [ACCEPTED]);
    assert!(near(after(&mut fleet, 10), 5.0, RobotState::Idle));
    apply(&mut fleet, &route(CommandKind::Assign, &[leg(2, false)]));
    assert!(near(after(&mut fleet, 10), 5.0, RobotState::Waiting));
    let done = (EventKind::RouteDone as u32, 0, 0);
    assert_eq!(apply(&mut fleet, &[command(CommandKind::Cancel)]), [ACCEPTED, done]);
}

#[test]
fn a_cancelled_robot_without_a_route_stays() {
    let mut fleet = on_chain();
    apply(
        &mut fleet,
        &[command(CommandKind::Cancel), command(CommandKind::Hold), command(CommandKind::Cancel)],
    );
    apply(&mut fleet, &[command(CommandKind::Resume)]);
    assert!(near(after(&mut fleet, 100), 1.0, RobotState::Idle));
}

#[test]
fn hold_stops_a_robot_and_resume_continues() {
    let mut fleet = on_chain();
    apply(&mut fleet, &route(CommandKind::Assign, &[leg(1, true)]));
    after(&mut fleet, 25);
    let held = (EventKind::Held as u32, 0, 0);
    assert_eq!(apply(&mut fleet, &[command(CommandKind::Hold)]), [ACCEPTED, held]);
    assert_eq!(apply(&mut fleet, &[command(CommandKind::Hold)]), [ACCEPTED]);
    assert!(near(after(&mut fleet, 25), 1.5, RobotState::Held));
    apply(&mut fleet, &route(CommandKind::Assign, &[leg(1, true), leg(2, true)]));
    assert!(near(after(&mut fleet, 25), 1.5, RobotState::Held));
    let resumed = (EventKind::Resumed as u32, 0, 0);
    assert_eq!(apply(&mut fleet, &[command(CommandKind::Resume)]), [ACCEPTED, resumed]);
    assert_eq!(apply(&mut fleet, &[command(CommandKind::Resume)]), [ACCEPTED]);
    assert!(near(after(&mut fleet, 1000), 9.0, RobotState::Idle));
}

#[test]
fn a_hold_between_routes_keeps_a_robot_idle() {
    let mut fleet = on_chain();
    apply(&mut fleet, &route(CommandKind::Assign, &[leg(1, true)]));
    after(&mut fleet, 1000);
    apply(&mut fleet, &[command(CommandKind::Hold)]);
    let resumed = (EventKind::Resumed as u32, 0, 0);
    assert_eq!(apply(&mut fleet, &[command(CommandKind::Resume)]), [ACCEPTED, resumed]);
    assert!(near(after(&mut fleet, 10), 5.0, RobotState::Idle));
}

#[test]
fn listed_routes_and_random_walks_can_be_extended() {
    let graph = chain(&[(2.0, 1.0), (2.0, 1.0), (2.0, 1.0)]);
    let mut fleet = fleet(&graph, config(vec![robot_type(f32::INFINITY, f32::INFINITY)]));
    let lap = RouteSource::Listed([forward(0), reverse(0)].into(), Repeat::Loop);
    fleet.spawn(Placement::Node(NodeIndex(0)), 0, lap, 0, &mut events()).expect("a loop");
    let walk = RouteSource::Random;
    fleet.spawn(Placement::Node(NodeIndex(0)), 0, walk, 0, &mut events()).expect("a walk");
    after(&mut fleet, 10);
    assert_eq!(
        apply(&mut fleet, &route(CommandKind::Extend, &[leg(0, true), leg(1, true)])),
        [ACCEPTED]
    );
    let mut other = route(CommandKind::Extend, &[leg(1, true)]);
    other[0].robot = 1;
    assert_eq!(apply(&mut fleet, &other), [ACCEPTED]);
    (0..2000).for_each(|_| fleet.step(None, &mut events()));
    assert_eq!(poses(&mut fleet).columns().x, [4.0, 4.0]);
    assert_eq!(fleet.robots_by_state(), [2, 0, 0, 0, 0, 0, 0, 0]);
}

#[test]
fn commands_spawn_and_remove() {
    let mut fleet = on_chain();
    let mut events = events();
    let at_node = CommandRecord { id: 102, ..command(CommandKind::SpawnAtNode) };
    let on_edge = CommandRecord { id: 1001, s: 0.5, ..command(CommandKind::SpawnOnEdge) };
    fleet.apply(&[at_node, on_edge, command(CommandKind::Remove)], &mut events);
    let kinds: Vec<_> =
        events.records().iter().map(|event| (event.kind, event.robot, event.token)).collect();
    let (spawned, accepted, removed) =
        (EventKind::Spawned as u32, EventKind::Accepted as u32, EventKind::Removed as u32);
    let pairs =
        [(spawned, 1), (accepted, 1), (spawned, 2), (accepted, 2), (accepted, 0), (removed, 0)];
    assert_eq!(kinds, pairs.map(|(kind, robot)| (kind, robot, TOKEN)));
    assert_eq!(poses(&mut fleet).columns().x[1..], [5.0, 2.5]);
    assert_eq!(poses(&mut fleet).columns().state[0], RobotState::Absent as u8);
}

#[test]
fn commands_that_cannot_be_carried_out_are_refused() {
    let mut fleet = on_chain();
    let robot = |robot, command: CommandRecord| [CommandRecord { robot, ..command }];
    for kind in [CommandKind::Cancel, CommandKind::Hold, CommandKind::Resume, CommandKind::Remove] {
        assert_eq!(apply(&mut fleet, &robot(5, command(kind))), refused(Refusal::UnknownRobot, 5));
    }
    let mut assign = |legs: &[CommandRecord]| apply(&mut fleet, &route(CommandKind::Assign, legs));
    assert_eq!(assign(&[leg(1, true), leg(9, true)]), refused(Refusal::UnknownEdge, 1009));
    assert_eq!(assign(&[leg(2, true)]), refused(Refusal::NotConnected, 1002));
    assert_eq!(assign(&[leg(1, true), leg(3, true)]), refused(Refusal::NotConnected, 1003));
    assert_eq!(assign(&[]), refused(Refusal::MalformedRoute, 0));
    assert_eq!(assign(&[leg(1, false), leg(2, true)]), refused(Refusal::MalformedRoute, 0));
    let spawn = |id, s, robot_type| {
        [CommandRecord { id, s, robot_type, ..command(CommandKind::SpawnOnEdge) }]
    };
    assert_eq!(apply(&mut fleet, &spawn(9, 0.0, 0)), refused(Refusal::UnknownEdge, 9));
    assert_eq!(apply(&mut fleet, &spawn(1000, 2.5, 0)), refused(Refusal::DistanceOutOfRange, 1000));
    assert_eq!(
        apply(&mut fleet, &spawn(1000, f32::NAN, 0)),
        refused(Refusal::DistanceOutOfRange, 1000)
    );
    assert_eq!(apply(&mut fleet, &spawn(1000, 0.0, 1)), refused(Refusal::UnknownRobotType, 1));
    assert_eq!(
        apply(&mut fleet, &spawn(1000, 0.0, 1 << 20)),
        refused(Refusal::UnknownRobotType, 1 << 20)
    );
    let at_node = CommandRecord { id: 9, ..command(CommandKind::SpawnAtNode) };
    assert_eq!(apply(&mut fleet, &[at_node]), refused(Refusal::UnknownNode, 9));
    assert!(near(after(&mut fleet, 100), 1.0, RobotState::Idle), "refused commands change nothing");
}

#[test]
fn a_command_for_a_removed_robot_below_others_is_refused() {
    let mut fleet = on_chain();
    let at_node = CommandRecord { id: 100, ..command(CommandKind::SpawnAtNode) };
    apply(&mut fleet, &[at_node, command(CommandKind::Remove)]);
    assert_eq!(apply(&mut fleet, &[command(CommandKind::Hold)]), refused(Refusal::UnknownRobot, 0));
}

#[test]
fn reverse_gear_is_refused_where_it_is_not_allowed() {
    let graph = town(2, 5.0);
    let reversible = |edge: &usize| graph.edges()[*edge].reverse_speed.is_some();
    let edge = (0..8).find(|edge| !reversible(edge)).expect("one without") as u32;
    let mut fleet = fleet(&graph, config(vec![robot_type(f32::INFINITY, f32::INFINITY)]));
    let end = Placement::Edge(EdgeIndex(edge), 1.0);
    fleet.spawn(end, 0, RouteSource::None, 0, &mut events()).expect("an edge");
    let back = CommandRecord { reverse: 1, ..leg(edge, true) };
    assert_eq!(
        apply(&mut fleet, &route(CommandKind::Assign, &[back])),
        refused(Refusal::NoReverse, 1000 + edge)
    );
}

#[test]
fn spawns_into_a_full_fleet_are_refused() {
    let graph = chain(&[(2.0, 1.0)]);
    let types = vec![robot_type(f32::INFINITY, f32::INFINITY)];
    let mut fleet = fleet(&graph, FleetConfig { most_robots: 1, ..config(types) });
    let spawn = CommandRecord { id: 100, ..command(CommandKind::SpawnAtNode) };
    assert_eq!(apply(&mut fleet, &[spawn]).len(), 2);
    assert_eq!(apply(&mut fleet, &[spawn]), refused(Refusal::FleetFull, 100));
}

#[test]
fn stray_legs_and_malformed_commands_are_refused_once() {
    let mut fleet = on_chain();
    let strays = [leg(1, true), leg(2, true), command(CommandKind::Hold)];
    assert_eq!(apply(&mut fleet, &strays)[0], refused(Refusal::MalformedCommand, 1001)[0]);
    assert_eq!(apply(&mut fleet, &strays).len(), 2);
    let unknown = CommandRecord { kind: 99, ..command(CommandKind::Hold) };
    assert_eq!(apply(&mut fleet, &[unknown]), refused(Refusal::MalformedCommand, 0));
    let short = [
        CommandRecord { legs: 3, ..command(CommandKind::Assign) },
        leg(1, true),
        command(CommandKind::Resume),
    ];
    let answers = apply(&mut fleet, &short);
    assert_eq!(answers[0], refused(Refusal::MalformedCommand, 0)[0]);
    assert_eq!(answers[1], ACCEPTED, "the command after it is carried out");
}

/// Returns the legs ahead of the first robot as edge indices: the one that it is on, its base, its
/// horizon.
fn ahead(fleet: &Fleet) -> (Option<u32>, Vec<u32>, Vec<u32>) {
    let numbers = |legs: &[Leg]| legs.iter().map(|leg| leg.edge.0).collect();
    let ahead = fleet.ahead(0).expect("a robot");
    assert_eq!(ahead.legs().count(), ahead.len());
    (ahead.on.map(|leg| leg.edge.0), numbers(ahead.base), numbers(ahead.horizon))
}

#[test]
fn ahead_lists_the_current_leg_the_base_and_the_horizon() {
    let mut fleet = on_chain();
    assert_eq!(ahead(&fleet), (None, vec![], vec![]), "on an edge, but without a route");
    assert_eq!(fleet.ahead(1), None);
    apply(&mut fleet, &route(CommandKind::Assign, &[leg(1, true), leg(2, false), leg(3, false)]));
    assert_eq!(ahead(&fleet), (Some(0), vec![1], vec![2, 3]), "it finishes its edge first");
    after(&mut fleet, 100);
    assert_eq!(ahead(&fleet), (Some(1), vec![], vec![2, 3]));
    after(&mut fleet, 1000);
    assert_eq!(ahead(&fleet), (None, vec![], vec![2, 3]), "it waits at the end of its base");
    apply(&mut fleet, &route(CommandKind::Extend, &[leg(2, true)]));
    assert_eq!(ahead(&fleet), (Some(2), vec![], vec![]), "the horizon was dropped");
    apply(&mut fleet, &[command(CommandKind::Cancel)]);
    assert_eq!(ahead(&fleet), (Some(2), vec![], vec![]));
    after(&mut fleet, 1000);
    assert_eq!(ahead(&fleet), (None, vec![], vec![]));
}

#[test]
fn ahead_is_one_lap_of_a_loop_and_one_leg_of_a_random_walk() {
    let there_and_back: Arc<[Leg]> = [forward(0), reverse(0)].into();
    let mut fleet =
        fleet(&chain(&[(2.0, 1.0)]), config(vec![robot_type(f32::INFINITY, f32::INFINITY)]));
    let listed = RouteSource::Listed(there_and_back, Repeat::Loop);
    fleet.spawn(Placement::Node(NodeIndex(0)), 0, listed, 0, &mut events()).expect("on the node");
    for _ in 0..3 {
        assert_eq!(ahead(&fleet), (Some(0), vec![0], vec![]));
        assert_eq!(fleet.ahead(0).expect("a robot").on, Some(forward(0)));
        after(&mut fleet, 110);
        assert_eq!(ahead(&fleet), (Some(0), vec![], vec![0]));
        assert_eq!(fleet.ahead(0).expect("a robot").on, Some(reverse(0)));
        // Half as fast in reverse gear.
        after(&mut fleet, 200);
    }
    fleet.remove(0, &mut events()).expect("there");
    let start = Placement::Edge(EdgeIndex(0), 1.0);
    fleet.spawn(start, 0, RouteSource::Random, 0, &mut events()).expect("on the edge");
    assert_eq!(ahead(&fleet), (Some(0), vec![], vec![]));
    assert!(fleet.drives_on(0));
}

#[test]
fn a_random_walk_takes_the_legs_that_are_ahead_of_it() {
    let mut fleet = fleet(&town(5, 3.0), config(vec![robot_type(f32::INFINITY, f32::INFINITY)]));
    fleet
        .spawn(Placement::Edge(EdgeIndex(0), 0.1), 0, RouteSource::Random, 0, &mut events())
        .expect("on the edge");
    let drawn: Vec<_> = fleet.walk_ahead(0).take(16).collect();
    let mut driven = vec![fleet.ahead(0).expect("a robot").on.expect("a leg")];
    while driven.len() <= drawn.len() {
        after(&mut fleet, 1);
        let on = fleet.ahead(0).expect("a robot").on.expect("a leg");
        if driven.last() != Some(&on) {
            driven.push(on);
        }
    }
    assert_eq!(driven[1..], drawn);
    apply(&mut fleet, &[command(CommandKind::Cancel)]);
    assert_eq!((fleet.walk_ahead(0).count(), fleet.drives_on(0)), (0, false), "it ends its leg");
}

#[test]
fn only_the_owner_moves_robots_and_others_may_do_all_else() {
    let mut fleet = on_chain();
    let (before, mut events) = (after(&mut fleet, 0), events());
    let release = CommandRecord { id: 1001, s: f32::INFINITY, ..command(CommandKind::Release) };
    let movement = [
        route(CommandKind::Assign, &[leg(1, true)]),
        route(CommandKind::Extend, &[leg(1, true)]),
        vec![release],
        vec![command(CommandKind::Cancel)],
    ];
    let others = [CommandKind::Hold, CommandKind::Resume, CommandKind::Break, CommandKind::Repair];
    fleet.apply_of(Authority::WithoutMovement, &movement.concat(), &mut events);
    let answers: Vec<_> = events.records().iter().map(|event| (event.kind, event.detail)).collect();
    assert_eq!(answers, [(EventKind::Refused as u32, Refusal::NotOwner as u32); 4]);
    assert_eq!(after(&mut fleet, 50), before, "it stands where it stood");
    events.clear();
    fleet.apply_of(Authority::WithoutMovement, &others.map(command), &mut events);
    let refused = events.records().iter().filter(|event| event.kind == EventKind::Refused as u32);
    assert_eq!(refused.count(), 0);
}
