//! Releases by distance: bases that end within a leg.

use proptest::prelude::*;
use regatta_layout::{EdgeIndex, Gear, Leg, NodeIndex, RouteGraph};
use regatta_plugin::command::{CommandKind, CommandRecord};
use regatta_plugin::event::{EventKind, Refusal};
use regatta_plugin::frame::RobotState;

use super::support::*;
use crate::fleet::{Fleet, Placement, RouteSource};

fn command(kind: CommandKind) -> CommandRecord {
    CommandRecord { kind: kind as u32, ..CommandRecord::default() }
}

fn release(edge: u32, s: f32) -> [CommandRecord; 1] {
    [CommandRecord { id: 1000 + edge, s, ..command(CommandKind::Release) }]
}

/// Returns a command with legs along these edges: index, and whether it is released.
fn route(kind: CommandKind, legs: &[(u32, bool)]) -> Vec<CommandRecord> {
    let leg = |&(edge, released): &(u32, bool)| CommandRecord {
        id: 1000 + edge,
        released: released.into(),
        ..command(CommandKind::Leg)
    };
    let head = CommandRecord { legs: legs.len() as u32, ..command(kind) };
    std::iter::once(head).chain(legs.iter().map(leg)).collect()
}

/// Applies commands and returns the kinds and details of their events.
fn apply(fleet: &mut Fleet, commands: &[CommandRecord]) -> Vec<(u32, u32)> {
    let mut events = events();
    fleet.apply(commands, &mut events);
    events.records().iter().map(|event| (event.kind, event.detail)).collect()
}

const ACCEPTED: (u32, u32) = (EventKind::Accepted as u32, 0);
const WAITING: (u32, u32) = (EventKind::WaitingForRelease as u32, 0);
const DONE: (u32, u32) = (EventKind::RouteDone as u32, 0);

fn refused(reason: Refusal) -> Vec<(u32, u32)> {
    vec![(EventKind::Refused as u32, reason as u32)]
}

/// Steps and returns the position and the state of the first robot, and the kinds of the events but
/// `ReachedNode`.
fn after(fleet: &mut Fleet, ticks: u32) -> (f32, u8, Vec<u32>) {
    let mut events = events();
    (0..ticks).for_each(|_| fleet.step(None, &mut events));
    let frame = poses(fleet);
    let kinds = events
        .records()
        .iter()
        .map(|event| event.kind)
        .filter(|kind| *kind != EventKind::ReachedNode as u32);
    (frame.columns().x[0], frame.columns().state[0], kinds.collect())
}

fn assert_stands(fleet: &mut Fleet, x: f32, state: RobotState) {
    let found = after(fleet, 0);
    assert!((found.0 - x).abs() < 2e-6 && found.1 == state as u8, "{found:?}, not {x} {state:?}");
}

/// A robot 1 m along the first of four edges of 2, 3, 20 and 5 m.
fn on_chain(acceleration: f32) -> Fleet {
    let graph = chain(&[(2.0, 1.0), (3.0, 1.0), (20.0, 1.0), (5.0, 1.0)]);
    let mut fleet = fleet(&graph, config(vec![robot_type(f32::INFINITY, acceleration)]));
    fleet
        .spawn(Placement::Edge(EdgeIndex(0), 1.0), 0, RouteSource::None, 0, &mut events())
        .expect("on the edge");
    fleet
}

const ACCELERATIONS: [f32; 2] = [f32::INFINITY, 0.5];

#[test]
fn a_robot_stops_where_its_base_ends_and_goes_on_when_it_grows() {
    for acceleration in ACCELERATIONS {
        let mut fleet = on_chain(acceleration);
        assert_eq!(
            apply(&mut fleet, &route(CommandKind::Assign, &[(1, true), (2, false), (3, false)])),
            [ACCEPTED]
        );
        // Beyond a piece of 8 m.
        assert_eq!(apply(&mut fleet, &release(2, 11.25)), [ACCEPTED]);
        assert_eq!(after(&mut fleet, 2000).2, [EventKind::WaitingForRelease as u32]);
        assert_stands(&mut fleet, 16.25, RobotState::Waiting);
        for s in [0.0, 3.0, 11.25] {
            assert_eq!(apply(&mut fleet, &release(2, s)), [ACCEPTED], "nothing is taken back");
            assert_eq!(after(&mut fleet, 50).2, [] as [u32; 0]);
        }
        assert_stands(&mut fleet, 16.25, RobotState::Waiting);
        apply(&mut fleet, &release(2, 11.26));
        after(&mut fleet, 2000);
        assert_stands(&mut fleet, 16.26, RobotState::Waiting);
        apply(&mut fleet, &release(3, 0.0));
        after(&mut fleet, 2000);
        assert_stands(&mut fleet, 25.0, RobotState::Waiting);
        apply(&mut fleet, &release(3, f32::INFINITY));
        assert_eq!(after(&mut fleet, 2000).2, [EventKind::RouteDone as u32]);
        assert_stands(&mut fleet, 30.0, RobotState::Idle);
    }
}

#[test]
fn what_is_not_ahead_is_refused() {
    let mut fleet = on_chain(f32::INFINITY);
    assert_eq!(apply(&mut fleet, &release(1, 1.0)), refused(Refusal::NotAhead), "without a route");
    apply(&mut fleet, &route(CommandKind::Assign, &[(1, true), (2, false)]));
    assert_eq!(apply(&mut fleet, &release(1, 1.0)), refused(Refusal::NotAhead), "released already");
    assert_eq!(apply(&mut fleet, &release(3, 1.0)), refused(Refusal::NotAhead), "not on the route");
    assert_eq!(apply(&mut fleet, &release(9, 1.0)), refused(Refusal::UnknownEdge));
    for s in [-1.0, f32::NAN] {
        assert_eq!(apply(&mut fleet, &release(2, s)), refused(Refusal::DistanceOutOfRange));
    }
    let reverse = CommandRecord { reverse: 1, ..release(2, 1.0)[0] };
    assert_eq!(apply(&mut fleet, &[reverse]), refused(Refusal::NotAhead), "in the other gear");
    let other = CommandRecord { robot: 1, ..release(2, 1.0)[0] };
    assert_eq!(apply(&mut fleet, &[other]), refused(Refusal::UnknownRobot));
}

#[test]
fn the_base_of_an_idle_robot_within_an_edge_ends_where_it_stands() {
    for acceleration in ACCELERATIONS {
        let mut fleet = on_chain(acceleration);
        assert_eq!(
            apply(&mut fleet, &route(CommandKind::Assign, &[(1, false)])),
            [ACCEPTED, WAITING]
        );
        after(&mut fleet, 100);
        assert_stands(&mut fleet, 1.0, RobotState::Waiting);
        apply(&mut fleet, &release(0, 1.5));
        after(&mut fleet, 1000);
        assert_stands(&mut fleet, 1.5, RobotState::Waiting);
        assert_eq!(apply(&mut fleet, &[command(CommandKind::Cancel)]), [ACCEPTED, DONE]);
        assert!(fleet.ahead(0).expect("a robot").is_empty());
        apply(&mut fleet, &release(0, 1.75));
        after(&mut fleet, 1000);
        assert_stands(&mut fleet, 1.75, RobotState::Idle);
        apply(&mut fleet, &route(CommandKind::Assign, &[(1, true)]));
        after(&mut fleet, 1000);
        assert_stands(&mut fleet, 5.0, RobotState::Idle);
    }
}

#[test]
fn commands_keep_the_limit_unless_they_release_a_leg() {
    for acceleration in ACCELERATIONS {
        let planned = route(CommandKind::Assign, &[(1, false), (2, false)]);
        let on_second = || {
            let mut fleet = on_chain(acceleration);
            apply(&mut fleet, &planned);
            apply(&mut fleet, &release(1, 1.5));
            after(&mut fleet, 120);
            fleet
        };
        for (commands, x, state) in [
            (vec![], 3.5, RobotState::Waiting),
            (vec![command(CommandKind::Cancel)], 3.5, RobotState::Idle),
            (route(CommandKind::Extend, &[(2, false)]), 3.5, RobotState::Waiting),
            (route(CommandKind::Assign, &[(2, false)]), 3.5, RobotState::Waiting),
            (route(CommandKind::Extend, &[(2, true)]), 25.0, RobotState::Idle),
            (route(CommandKind::Assign, &[(2, true)]), 25.0, RobotState::Idle),
        ] {
            let mut fleet = on_second();
            assert!(apply(&mut fleet, &commands).iter().all(|answer| *answer == ACCEPTED));
            after(&mut fleet, 3000);
            assert_stands(&mut fleet, x, state);
        }
    }
}

#[test]
fn a_held_robot_keeps_its_limit() {
    for acceleration in ACCELERATIONS {
        let mut fleet = on_chain(acceleration);
        apply(&mut fleet, &route(CommandKind::Assign, &[(1, false)]));
        apply(&mut fleet, &release(1, 0.5));
        apply(&mut fleet, &[command(CommandKind::Hold)]);
        apply(&mut fleet, &release(1, 2.0));
        after(&mut fleet, 50);
        assert_stands(&mut fleet, 1.0, RobotState::Held);
        apply(&mut fleet, &[command(CommandKind::Resume)]);
        after(&mut fleet, 1000);
        assert_stands(&mut fleet, 4.0, RobotState::Waiting);
        apply(&mut fleet, &[command(CommandKind::Hold)]);
        let resumed = (EventKind::Resumed as u32, 0);
        assert_eq!(
            apply(&mut fleet, &[command(CommandKind::Resume)]),
            [ACCEPTED, resumed, WAITING]
        );
    }
}

#[test]
fn a_limit_that_grows_in_time_doesnt_slow_the_robot() {
    let mut fleet = on_chain(0.5);
    apply(&mut fleet, &route(CommandKind::Assign, &[(1, true), (2, false)]));
    let mut speed = 0.0;
    for tick in 0..600 {
        // Braking from 1 m/s takes 1 m.
        let x = poses(&mut fleet).columns().x[0];
        let s = (x + 1.2 - 5.0).max(0.1);
        assert_eq!(apply(&mut fleet, &release(2, s)), [ACCEPTED]);
        let now = step(&mut fleet, &mut events()).columns().speed[0];
        assert!(now >= speed && (tick < 110 || now == 1.0), "{now} after {speed} in tick {tick}");
        speed = now;
    }
}

#[test]
fn a_leg_in_reverse_gear_is_released_from_the_edges_destination() {
    for acceleration in ACCELERATIONS {
        let graph = chain(&[(2.0, 1.0), (20.0, 1.0)]);
        let mut fleet = fleet(&graph, config(vec![robot_type(f32::INFINITY, acceleration)]));
        fleet
            .spawn(Placement::Node(NodeIndex(2)), 0, RouteSource::None, 0, &mut events())
            .expect("a node");
        let mut assign = route(CommandKind::Assign, &[(1, false), (0, false)]);
        assign[1..].iter_mut().for_each(|leg| leg.reverse = 1);
        apply(&mut fleet, &assign);
        apply(&mut fleet, &[CommandRecord { reverse: 1, ..release(1, 13.5)[0] }]);
        after(&mut fleet, 3000);
        assert_stands(&mut fleet, 8.5, RobotState::Waiting);
        apply(&mut fleet, &[CommandRecord { reverse: 1, ..release(0, 0.5)[0] }]);
        after(&mut fleet, 3000);
        assert_stands(&mut fleet, 1.5, RobotState::Waiting);
    }
}

#[test]
fn ahead_tells_how_much_of_the_last_released_leg_is_released() {
    let mut fleet = on_chain(f32::INFINITY);
    let ahead = |fleet: &Fleet| {
        let ahead = fleet.ahead(0).expect("a robot");
        (ahead.released(), ahead.released_metres, ahead.len())
    };
    apply(&mut fleet, &route(CommandKind::Assign, &[(1, false), (2, false)]));
    assert_eq!(ahead(&fleet), (1, 1.0, 3));
    apply(&mut fleet, &release(1, 1.5));
    assert_eq!(ahead(&fleet), (2, 1.5, 3));
    after(&mut fleet, 1000);
    assert_eq!(ahead(&fleet), (1, 1.5, 2));
    apply(&mut fleet, &release(1, 99.0));
    assert_eq!(ahead(&fleet), (1, f32::INFINITY, 2));
}

/// A random command for a robot.
#[derive(Clone, Copy, Debug)]
enum Act {
    Assign { legs: usize, released: usize },
    Extend { legs: usize, released: usize },
    Release { leg: usize, part: f32 },
    Cancel,
    Hold,
    Resume,
}

fn act() -> impl Strategy<Value = Act> {
    let part = prop_oneof![Just(0.0f32), Just(1.0), 0.0f32..1.0, 0.0f32..0.01];
    prop_oneof![
        2 => (1usize..6, 0usize..3).prop_map(|(legs, released)| Act::Assign { legs, released }),
        1 => (1usize..6, 0usize..3).prop_map(|(legs, released)| Act::Extend { legs, released }),
        8 => (0usize..4, part).prop_map(|(leg, part)| Act::Release { leg, part }),
        1 => Just(Act::Cancel),
        1 => Just(Act::Hold),
        2 => Just(Act::Resume),
    ]
}

/// Returns the records of an act that fits where the robot is.
fn records(fleet: &Fleet, graph: &RouteGraph, act: Act) -> Vec<CommandRecord> {
    let ahead = fleet.ahead(0).expect("a robot");
    let record = |leg: Leg| CommandRecord {
        id: graph.edge(leg.edge).id,
        reverse: u32::from(leg.gear == Gear::Reverse),
        ..command(CommandKind::Leg)
    };
    let drive = |kind, mut node, legs: usize, released: usize| {
        let mut all = vec![CommandRecord { legs: legs as u32, ..command(kind) }];
        for number in 0..legs {
            let exits = graph.departures(node);
            let leg = exits[(number * 7 + released * 3 + node.0 as usize) % exits.len()];
            node = graph.leg_end(leg);
            all.push(CommandRecord { released: u32::from(number < released), ..record(leg) });
        }
        all
    };
    match act {
        Act::Assign { legs, released } => {
            drive(CommandKind::Assign, fleet.node_ahead(0), legs, released)
        }
        Act::Extend { legs, released } => {
            let end =
                ahead.base.last().map_or_else(|| fleet.node_ahead(0), |leg| graph.leg_end(*leg));
            drive(CommandKind::Extend, end, legs, released)
        }
        Act::Release { leg, part } => {
            let last =
                ahead.released().checked_sub(1).filter(|_| ahead.released_metres.is_finite());
            let Some(leg) = ahead.legs().nth(last.unwrap_or(ahead.released()) + leg) else {
                return vec![];
            };
            let s = part * graph.edge(leg.edge).path.polyline_length(64) as f32;
            vec![CommandRecord { kind: CommandKind::Release as u32, s, ..record(leg) }]
        }
        Act::Cancel => vec![command(CommandKind::Cancel)],
        Act::Hold => vec![command(CommandKind::Hold)],
        Act::Resume => vec![command(CommandKind::Resume)],
    }
}

/// Makes a tick and checks that the robot is still within what was released before it.
fn step_within_base(fleet: &mut Fleet, lengths: &[f32]) -> f32 {
    let ahead = fleet.ahead(0).expect("a robot");
    let released: Vec<Leg> = ahead.legs().take(ahead.released()).collect();
    let limit = ahead.released_metres;
    let before = poses(fleet);
    let frame = step(fleet, &mut events());
    let (edge, s, speed) =
        (frame.columns().edge[0], frame.columns().s[0], frame.columns().speed[0]);
    let place = |frame: &Frame| (frame.columns().x[0], frame.columns().y[0]);
    if place(&frame) != place(&before) {
        let number =
            released.iter().position(|leg| leg.edge.0 == edge).expect("it drives a released leg");
        if number + 1 == released.len() && limit.is_finite() {
            let reverse = released[number].gear == Gear::Reverse;
            let driven = if reverse { lengths[edge as usize] - s } else { s };
            assert!(driven <= limit + 2e-6, "{driven} m of {limit} m");
        }
    }
    speed.abs()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn no_robot_drives_beyond_its_base(
        acts in prop::collection::vec((act(), 1u32..120), 1..40),
        acceleration in prop_oneof![Just(f32::INFINITY), 0.2f32..5.0],
        other_is_limited in any::<bool>(),
        spacing in 1.0f64..20.0,
    ) {
        let graph = town(3, spacing);
        let tracks = crate::arc_length::compile(&graph);
        let edges = 0..graph.edges().len() as u32;
        let lengths: Vec<_> = edges.map(|edge| tracks.edge_length(EdgeIndex(edge)) as f32).collect();
        let other = robot_type(f32::INFINITY, if other_is_limited { 1.0 } else { f32::INFINITY });
        let mut fleet = fleet(&graph, config(vec![robot_type(f32::INFINITY, acceleration), other]));
        let place = Placement::Edge(EdgeIndex(0), 0.5);
        fleet.spawn(place, 0, RouteSource::None, 0, &mut events()).expect("an edge");
        fleet.spawn(Placement::Node(NodeIndex(4)), 1, RouteSource::Random, 0, &mut events()).expect("a node");
        let change = acceleration * 0.02 * 1.001 + 1e-5 + (2.0 * acceleration / (1u32 << 26) as f32).sqrt();
        let mut speed = 0.0;
        for (act, ticks) in acts {
            let commands = records(&fleet, &graph, act);
            let answers = apply(&mut fleet, &commands);
            prop_assert!(answers.iter().all(|answer| answer.0 != EventKind::Refused as u32), "{answers:?} to {act:?}");
            // These may take away road that the robot needs to brake on.
            let may_brake_hard = matches!(act, Act::Assign { .. } | Act::Extend { .. } | Act::Cancel);
            for tick in 0..ticks {
                let now = step_within_base(&mut fleet, &lengths);
                let is_hard = may_brake_hard && now < speed;
                prop_assert!(is_hard || (now - speed).abs() <= change, "{speed} to {now} in tick {tick} after {act:?}");
                speed = now;
            }
        }
    }
}
