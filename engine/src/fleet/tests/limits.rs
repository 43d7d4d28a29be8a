//! Acceleration limits: the speed at every tick, on random graphs and with commands.

use std::time::Duration;

use proptest::prelude::*;
use regatta_layout::NodeIndex;
use regatta_plugin::command::{CommandKind, CommandRecord};
use regatta_plugin::event::EventKind;
use regatta_plugin::frame::RobotState;
use regatta_scenario::Repeat;

use super::support::*;
use crate::fleet::{Fleet, FleetConfig, Placement, RouteSource};

/// The first robot after a tick.
#[derive(Clone, Copy, Debug)]
struct Tick {
    x: f32,
    speed: f32,
    edge: u32,
    state: u8,
}

fn tick(fleet: &mut Fleet) -> Tick {
    let frame = step(fleet, &mut events());
    let columns = frame.columns();
    Tick {
        x: columns.x[0],
        speed: columns.speed[0].abs(),
        edge: columns.edge[0],
        state: columns.state[0],
    }
}

fn on_chain(parts: &[(f64, f64)], max_speed: f32, acceleration: f32, hertz: u32) -> Fleet {
    let config = config(vec![robot_type(max_speed, acceleration)]);
    fleet(&chain(parts), FleetConfig { tick_period: Duration::from_secs(1) / hertz, ..config })
}

/// Spawns the first robot with a route along the chain from its start.
fn drive(fleet: &mut Fleet, edges: std::ops::Range<u32>) {
    let legs: Vec<_> = edges.map(forward).collect();
    let route = RouteSource::Listed(legs.into(), Repeat::Once);
    fleet.spawn(Placement::Node(NodeIndex(0)), 0, route, 0, &mut events()).expect("a route");
}

fn extend(edge: u32) -> [CommandRecord; 2] {
    let command =
        CommandRecord { kind: CommandKind::Extend as u32, legs: 1, ..CommandRecord::default() };
    let leg = CommandRecord {
        kind: CommandKind::Leg as u32,
        id: 1000 + edge,
        released: 1,
        ..CommandRecord::default()
    };
    [command, leg]
}

fn command(fleet: &mut Fleet, kind: CommandKind) {
    fleet.apply(&[CommandRecord { kind: kind as u32, ..CommandRecord::default() }], &mut events());
}

/// Steps until the robot stands and checks every change of speed until then. Over two units of
/// distance, an acceleration makes a difference of √(2 a 2⁻²⁶): the last change may deviate by that
/// much.
fn step_until_it_stands(
    fleet: &mut Fleet,
    parts: &[(f64, f64)],
    max_speed: f32,
    change: f32,
) -> Vec<Tick> {
    let acceleration = fleet.types()[0].max_acceleration;
    let tolerance = 1e-5 + (2.0 * acceleration / (1u32 << 26) as f32).sqrt();
    let mut ticks: Vec<Tick> = Vec::new();
    let mut before = poses(fleet).columns().speed[0];
    loop {
        let now = tick(fleet);
        let limit = max_speed.min(parts[now.edge as usize].1 as f32);
        assert!(now.speed <= limit, "{now:?} is faster than {limit}");
        let difference = (now.speed - before).abs();
        assert!(
            difference <= change * 1.001 + tolerance,
            "{difference} after {before} m/s: {now:?}, {change} allowed"
        );
        before = now.speed;
        ticks.push(now);
        if now.speed == 0.0 {
            return ticks;
        }
        assert!(ticks.len() < 3_000_000, "it never reaches its end: {now:?}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 150, failure_persistence: None, ..ProptestConfig::default() })]

    /// On any edges, including those shorter than a step or a braking distance, no edge is driven
    /// too fast, no change of speed is too large, and the robot stops at the very end.
    #[test]
    fn speeds_stay_within_all_limits(
        parts in prop::collection::vec((prop_oneof![0.002..0.1, 0.1..2.0, 2.0..15.0], 0.1..5.0), 1..15),
        max_speed in prop_oneof![Just(f32::INFINITY), 0.1f32..3.0],
        acceleration in prop_oneof![0.05f32..0.3, 0.3f32..3.0, 3.0f32..500.0],
        hertz in prop_oneof![Just(10u32), Just(60), Just(1000)],
    ) {
        let mut fleet = on_chain(&parts, max_speed, acceleration, hertz);
        drive(&mut fleet, 0..parts.len() as u32);
        let ticks = step_until_it_stands(&mut fleet, &parts, max_speed, acceleration / hertz as f32);
        let end = ticks.last().expect("ticks");
        let length: f64 = parts.iter().map(|part| part.0).sum();
        prop_assert_eq!((end.x, end.state), (length as f32, RobotState::Idle as u8));
        // It is never slower than a robot that brakes half as hard and drives half as fast.
        let fastest = parts.iter().map(|part| part.1.min(f64::from(max_speed))).fold(f64::INFINITY, f64::min) / 2.0;
        let slowest = length / fastest + 2.0 * fastest / f64::from(acceleration) + 20.0 / f64::from(hertz);
        prop_assert!((ticks.len() as f64) < slowest * f64::from(hertz) + 1.0, "{} ticks, {slowest} s", ticks.len());
    }
}

#[test]
fn a_trapezoidal_profile_takes_the_expected_time() {
    let parts = [(10.0, 2.0)];
    let mut fleet = on_chain(&parts, f32::INFINITY, 0.5, 100);
    drive(&mut fleet, 0..1);
    let ticks = step_until_it_stands(&mut fleet, &parts, f32::INFINITY, 0.005);
    // Accelerating to 2 m/s takes 4 s and 4 m, braking likewise; the 2 m between take 1 s.
    assert!((ticks.len() as f32 * 0.01 - 9.0).abs() < 0.1, "{} ticks", ticks.len());
    let top = ticks.iter().map(|tick| tick.speed).fold(0.0, f32::max);
    assert_eq!(top, 2.0);
}

#[test]
fn braking_starts_before_short_edges() {
    // 20 edges of 0.1 m, then one that allows 0.1 m/s only: braking from 2 m/s takes 2 m and begins
    // before them.
    let mut parts = vec![(6.0, 2.0)];
    parts.extend([(0.1, 2.0); 20]);
    parts.push((0.5, 0.1));
    let mut fleet = on_chain(&parts, f32::INFINITY, 1.0, 100);
    drive(&mut fleet, 0..22);
    let ticks = step_until_it_stands(&mut fleet, &parts, f32::INFINITY, 0.01);
    let entry = ticks.iter().find(|tick| tick.edge == 21).expect("it reaches the last edge");
    assert!(entry.speed <= 0.1 && entry.speed > 0.08, "{entry:?}");
    assert!(ticks.iter().any(|tick| tick.speed == 2.0));
}

#[test]
fn an_extension_in_time_doesnt_slow_the_robot() {
    let parts = [(8.0, 1.0), (8.0, 1.0), (8.0, 1.0)];
    let mut fleet = on_chain(&parts, f32::INFINITY, 0.5, 50);
    drive(&mut fleet, 0..2);
    let mut slowed = false;
    while tick(&mut fleet).x < 14.9 {}
    fleet.apply(&extend(2), &mut events());
    loop {
        let now = tick(&mut fleet);
        if now.x > 22.5 {
            break;
        }
        slowed |= now.speed < 1.0;
    }
    assert!(!slowed);
}

#[test]
fn a_late_extension_makes_the_robot_accelerate_again() {
    let parts = [(8.0, 1.0), (8.0, 1.0)];
    let mut fleet = on_chain(&parts, f32::INFINITY, 0.5, 50);
    drive(&mut fleet, 0..1);
    while tick(&mut fleet).x < 7.5 {}
    let braking = tick(&mut fleet).speed;
    assert!(braking < 0.9 && braking > 0.3);
    fleet.apply(&extend(1), &mut events());
    let later = (0..10).map(|_| tick(&mut fleet)).last().expect("ticks");
    assert!((later.speed - braking - 0.1).abs() < 1e-4, "{} after {braking}", later.speed);
}

#[test]
fn a_hold_brakes_and_a_resume_accelerates() {
    let parts = [(50.0, 2.0)];
    let mut fleet = on_chain(&parts, f32::INFINITY, 0.5, 50);
    drive(&mut fleet, 0..1);
    while tick(&mut fleet).speed < 2.0 {}
    let start = tick(&mut fleet).x;
    command(&mut fleet, CommandKind::Hold);
    let ticks = step_until_held(&mut fleet);
    let end = ticks.last().expect("ticks");
    assert!((end.x - start - 4.0).abs() < 0.05, "braking takes v²/2a: {}", end.x - start);
    (0..10).for_each(|_| assert_eq!(tick(&mut fleet).x, end.x));
    command(&mut fleet, CommandKind::Resume);
    assert!((tick(&mut fleet).speed - 0.01).abs() < 1e-6);
    assert_eq!(
        step_until_it_stands(&mut fleet, &parts, f32::INFINITY, 0.01).last().expect("ticks").x,
        50.0
    );
}

fn step_until_held(fleet: &mut Fleet) -> Vec<Tick> {
    let mut ticks = Vec::new();
    let mut events = events();
    while events.records().iter().all(|event| event.kind != EventKind::Held as u32) {
        let frame = step(fleet, &mut events);
        let columns = frame.columns();
        assert_eq!(columns.state[0], RobotState::Held as u8);
        ticks.push(Tick {
            x: columns.x[0],
            speed: columns.speed[0],
            edge: columns.edge[0],
            state: columns.state[0],
        });
        assert!(ticks.len() < 10_000);
    }
    assert_eq!(ticks.last().expect("ticks").speed, 0.0);
    ticks
}

#[test]
fn a_robot_held_near_the_end_of_its_base_stops_at_the_end() {
    let parts = [(5.0, 2.0)];
    let mut fleet = on_chain(&parts, f32::INFINITY, 0.5, 50);
    drive(&mut fleet, 0..1);
    while tick(&mut fleet).x < 4.5 {}
    command(&mut fleet, CommandKind::Hold);
    assert_eq!(step_until_held(&mut fleet).last().expect("ticks").x, 5.0);
    command(&mut fleet, CommandKind::Resume);
    assert_eq!(tick(&mut fleet).state, RobotState::Idle as u8);
}

#[test]
fn a_cancelled_leg_is_not_entered_even_if_braking_is_too_late() {
    let parts = [(5.0, 2.0), (5.0, 2.0)];
    let mut fleet = on_chain(&parts, f32::INFINITY, 0.5, 50);
    drive(&mut fleet, 0..2);
    while tick(&mut fleet).x < 4.9 {}
    command(&mut fleet, CommandKind::Cancel);
    let furthest = (0..200).map(|_| tick(&mut fleet)).last().expect("ticks");
    assert_eq!((furthest.x, furthest.state, furthest.edge), (5.0, RobotState::Idle as u8, 0));
}

#[test]
fn a_robot_stops_before_it_changes_gear() {
    let parts = [(5.0, 2.0)];
    let mut fleet = on_chain(&parts, f32::INFINITY, 0.5, 50);
    let lap = RouteSource::Listed([forward(0), reverse(0)].into(), Repeat::Loop);
    fleet.spawn(Placement::Node(NodeIndex(0)), 0, lap, 0, &mut events()).expect("a loop");
    let mut before = 0.0;
    let mut reversals = 0;
    for _ in 0..5000 {
        let frame = step(&mut fleet, &mut events());
        let speed = frame.columns().speed[0];
        assert!((speed - before).abs() <= 0.01 * 1.001 + 1e-6, "{before} to {speed}");
        reversals += i32::from(speed * before < 0.0);
        assert!(reversals == 0, "the robot is at rest for a tick between the gears");
        before = speed;
    }
}

#[test]
fn random_walks_never_stop_and_respect_limits() {
    let graph = town(4, 3.0);
    let mut fleet =
        fleet(&graph, config(vec![robot_type(1.5, 0.8), robot_type(f32::INFINITY, f32::INFINITY)]));
    for node in 0..32 {
        let robot_type = (node % 2) as u16;
        fleet
            .spawn(
                Placement::Node(NodeIndex(node % 16)),
                robot_type,
                RouteSource::Random,
                0,
                &mut events(),
            )
            .expect("a node");
    }
    let mut before = poses(&mut fleet);
    for _ in 0..5000 {
        let now = step(&mut fleet, &mut events());
        for robot in 0..32 {
            let (speed, edge) = (now.columns().speed[robot], now.columns().edge[robot]);
            let limit = graph.edges()[edge as usize].speed as f32;
            assert!(speed > 0.0 && speed <= limit);
            if robot % 2 == 0 {
                let change = (speed - before.columns().speed[robot]).abs();
                assert!(change <= 0.016 * 1.001 + 1e-5 && speed <= 1.5, "{change}");
            } else {
                assert_eq!(speed, limit);
            }
        }
        before = now;
    }
}

/// A random walk has no end at which the search for places to brake at would stop.
#[test]
fn a_tiny_acceleration_on_an_endless_route_ends_the_look_ahead() {
    let graph = town(4, 3.0);
    let mut fleet = fleet(&graph, config(vec![robot_type(1.5, 1e-12)]));
    fleet
        .spawn(Placement::Node(NodeIndex(0)), 0, RouteSource::Random, 0, &mut events())
        .expect("a node");
    let speed = step(&mut fleet, &mut events()).columns().speed[0];
    assert!((0.0..1e-12).contains(&speed), "{speed}");
}
