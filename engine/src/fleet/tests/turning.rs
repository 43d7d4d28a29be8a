//! Turns on the spot, and headings on edges with an orientation.

use std::f32::consts::{FRAC_PI_2, PI};
use std::sync::Arc;
use std::time::Duration;

use glam::DVec2;
use proptest::prelude::*;
use regatta_layout::{
    CubicBezier, Edge, Ends, Leg, Node, NodeIndex, Orientation, ReadOptions, Rotation, RouteGraph,
    parse,
};
use regatta_motion::Isa;
use regatta_plugin::command::{CommandKind, CommandRecord};
use regatta_plugin::event::EventKind;
use regatta_plugin::frame::RobotState;
use regatta_scenario::{Repeat, RobotType};

use super::support::*;
use crate::fleet::{Fleet, FleetConfig, Placement, RouteSource};

/// Returns straight edges between corners, each driven both ways, in the order of the corners.
fn polyline(corners: &[(f64, f64)], orientation: Orientation) -> Arc<RouteGraph> {
    let at: Vec<_> = corners.iter().map(|&(x, y)| DVec2::new(x, y)).collect();
    let nodes = (100..).zip(&at).map(|(id, &position)| Node::new(id, position, 0.0)).collect();
    let edge = |(number, ends): (u32, &[DVec2])| {
        let path = CubicBezier::straight(ends[0], ends[1]);
        let edge = Edge::new(1000 + number, NodeIndex(number), NodeIndex(number + 1), path, 1.0);
        Edge { orientation, reverse_speed: Some(1.0), ..edge }
    };
    Arc::new(RouteGraph::from_valid_parts(nodes, (0..).zip(at.windows(2)).map(edge).collect()))
}

fn turning_type(acceleration: f32, rotation_speed: f32, rotation_acceleration: f32) -> RobotType {
    RobotType {
        max_rotation_speed: rotation_speed,
        max_rotation_acceleration: rotation_acceleration,
        battery: None,
        ..robot_type(1.0, acceleration)
    }
}

fn fleet_on(graph: &Arc<RouteGraph>, robot_type: RobotType) -> Fleet {
    fleet(graph, FleetConfig { tick_period: Duration::from_millis(10), ..config(vec![robot_type]) })
}

/// The first robot after a tick.
#[derive(Clone, Copy, Debug)]
struct Tick {
    x: f32,
    y: f32,
    theta: f32,
    speed: f32,
    state: u8,
}

fn ticks(fleet: &mut Fleet, count: usize) -> Vec<Tick> {
    let tick = |_| {
        let frame = step(fleet, &mut events());
        let c = frame.columns();
        Tick { x: c.x[0], y: c.y[0], theta: c.theta[0], speed: c.speed[0], state: c.state[0] }
    };
    (0..count).map(tick).collect()
}

fn spawn(fleet: &mut Fleet, legs: &[Leg]) {
    let route = RouteSource::Listed(legs.into(), Repeat::Once);
    fleet.spawn(Placement::Node(NodeIndex(0)), 0, route, 0, &mut events()).expect("a route");
}

fn turns(ticks: &[Tick]) -> Vec<Tick> {
    ticks.iter().copied().filter(|tick| tick.state == RobotState::Turning as u8).collect()
}

const CORNER: [(f64, f64); 3] = [(0.0, 0.0), (2.0, 0.0), (2.0, 2.0)];

#[test]
fn a_robot_drives_sideways_as_the_body_headings_of_a_file_say() {
    // A quarter of a circle, driven with the head to its centre.
    let text = "Vertices:\n- {Id: 1, X: 0, Y: 0, Theta: 0, ThetaHolonomic: 1.5708}\n\
                - {Id: 2, X: 5, Y: 5, Theta: 1.5708, ThetaHolonomic: 3.1416}\n\
                Edges:\n- {Id: 7, Origin_ID: 1, Destination_ID: 2, CurveType: Spline, ParamF: 2.7615, ParamB: 2.7615, \
                VelocityForward: 1}\n";
    let (graph, _) = parse(text, "g", &ReadOptions::default()).expect("a graph");
    let mut fleet = fleet_on(&Arc::new(graph), turning_type(f32::INFINITY, 0.0, f32::INFINITY));
    spawn(&mut fleet, &[forward(0)]);
    let driving = ticks(&mut fleet, 700);
    let off = |tick: &Tick| (tick.theta - (5.0 - tick.y).atan2(-tick.x)).abs();
    let worst = driving.iter().map(|tick| off(tick).min(2.0 * PI - off(tick))).fold(0.0, f32::max);
    assert!(driving.len() == 700 && worst < 2e-3, "{worst}");
}

#[test]
fn a_robot_stops_turns_and_drives_on() {
    let graph = polyline(&CORNER, Orientation::Tangential);
    for acceleration in [f32::INFINITY, 0.5] {
        let mut fleet = fleet_on(&graph, turning_type(acceleration, 0.5, f32::INFINITY));
        spawn(&mut fleet, &[forward(0), forward(1)]);
        let all = ticks(&mut fleet, 1500);
        let turns = turns(&all);
        // 90° at 0.5 rad/s take 3.14 s.
        assert!((312..=315).contains(&turns.len()), "{} ticks", turns.len());
        assert!(turns.iter().all(|tick| (tick.x, tick.y, tick.speed) == (2.0, 0.0, 0.0)));
        assert!(turns.windows(2).all(|pair| (pair[1].theta - pair[0].theta - 0.005).abs() < 1e-5));
        let end = all.last().expect("ticks");
        assert_eq!((end.x, end.y, end.state), (2.0, 2.0, RobotState::Idle as u8));
        assert_eq!(end.theta, FRAC_PI_2, "exactly the heading of the edge");
        assert!(
            all.windows(2).all(|pair| (pair[1].theta - pair[0].theta).abs() <= 0.0051),
            "no jump"
        );
    }
}

#[test]
fn a_type_that_cant_turn_drives_through_the_corner() {
    let graph = polyline(&CORNER, Orientation::Tangential);
    let mut fleet = fleet_on(&graph, robot_type(1.0, f32::INFINITY));
    spawn(&mut fleet, &[forward(0), forward(1)]);
    let all = ticks(&mut fleet, 401);
    assert!(turns(&all).is_empty());
    assert!((all[399].y - 2.0).abs() < 1e-5, "no time is lost");
}

#[test]
fn a_turn_with_limited_acceleration_follows_the_profile() {
    let graph = polyline(&CORNER, Orientation::Tangential);
    let (speed, acceleration) = (1.0, 2.0);
    let mut fleet = fleet_on(&graph, turning_type(f32::INFINITY, speed, acceleration));
    spawn(&mut fleet, &[forward(0), forward(1)]);
    let turns = turns(&ticks(&mut fleet, 1000));
    // Accelerate for 0.5 s, turn at 1 rad/s, brake for 0.5 s: 90° / (1 rad/s) + 0.5 s.
    assert!((205..=212).contains(&turns.len()), "{} ticks", turns.len());
    let rates: Vec<f32> =
        turns.windows(2).map(|pair| (pair[1].theta - pair[0].theta) / 0.01).collect();
    assert!(rates.iter().all(|rate| (0.0..=speed * 1.001).contains(rate)));
    assert!(
        rates.windows(2).all(|pair| (pair[1] - pair[0]).abs() <= acceleration * 0.01 * 1.05),
        "{rates:?}"
    );
}

#[test]
fn the_shorter_way_is_turned() {
    // From east to south-west: 135° clockwise.
    let graph = polyline(&[(0.0, 0.0), (2.0, 0.0), (0.0, -2.0)], Orientation::Tangential);
    let mut fleet = fleet_on(&graph, turning_type(f32::INFINITY, 1.0, f32::INFINITY));
    spawn(&mut fleet, &[forward(0), forward(1)]);
    let turns = turns(&ticks(&mut fleet, 1000));
    assert!(
        (234..=237).contains(&turns.len()) && turns.iter().all(|tick| tick.theta <= 0.0),
        "{}",
        turns.len()
    );
}

#[test]
fn the_edge_says_which_way_is_turned() {
    for (rotation, ticks_of_turn) in [
        (Rotation::CounterClockwise, 156..=159),
        (Rotation::Clockwise, 470..=473),
        (Rotation::None, 0..=0),
    ] {
        let graph = polyline(&CORNER, Orientation::Tangential);
        let rotation_of_edges = Ends { origin: Rotation::Shorter, destination: rotation };
        let edges =
            graph.edges().iter().map(|edge| Edge { rotation: rotation_of_edges, ..edge.clone() });
        let graph = Arc::new(RouteGraph::from_valid_parts(graph.nodes().to_vec(), edges.collect()));
        let mut fleet = fleet_on(&graph, turning_type(f32::INFINITY, 1.0, f32::INFINITY));
        spawn(&mut fleet, &[forward(0), forward(1)]);
        let all = ticks(&mut fleet, 1000);
        assert!(ticks_of_turn.contains(&turns(&all).len()), "{rotation:?}: {}", turns(&all).len());
        assert_eq!(all[999].theta, FRAC_PI_2);
    }
}

#[test]
fn a_robot_turns_around_at_a_dead_end_only_if_it_drives_forward() {
    let graph = polyline(&CORNER[..2], Orientation::Tangential);
    let mut fleet = fleet_on(&graph, turning_type(f32::INFINITY, 1.0, f32::INFINITY));
    spawn(&mut fleet, &[forward(0), reverse(0)]);
    let all = ticks(&mut fleet, 401);
    assert!(
        turns(&all).is_empty() && all.iter().all(|tick| tick.theta == 0.0),
        "reverse gear keeps the heading"
    );
    assert_eq!(all[400].x, 0.0);
}

#[test]
fn orientations_turn_the_heading_and_not_the_path() {
    for (orientation, first, second) in [
        (Orientation::Offset(std::f64::consts::PI), PI, -FRAC_PI_2),
        (Orientation::Offset(1.0), 1.0, FRAC_PI_2 + 1.0),
        (Orientation::Fixed(-2.0), -2.0, -2.0),
    ] {
        let graph = polyline(&CORNER, orientation);
        let mut fleet = fleet_on(&graph, robot_type(1.0, f32::INFINITY));
        spawn(&mut fleet, &[forward(0), forward(1)]);
        let all = ticks(&mut fleet, 399);
        assert!(
            (all[100].theta - first).abs() < 1e-6 && (all[300].theta - second).abs() < 1e-6,
            "{orientation:?}"
        );
        assert_eq!((all[100].y, all[300].x), (0.0, 2.0));
    }
}

#[test]
fn a_fixed_heading_needs_no_turn() {
    let graph = polyline(&CORNER, Orientation::Fixed(0.0));
    let mut fleet = fleet_on(&graph, turning_type(f32::INFINITY, 1.0, f32::INFINITY));
    spawn(&mut fleet, &[forward(0), forward(1)]);
    assert!(turns(&ticks(&mut fleet, 500)).is_empty());
}

#[test]
fn a_turn_is_held_resumed_and_cancelled() {
    let graph = polyline(&CORNER, Orientation::Tangential);
    let mut fleet = fleet_on(&graph, turning_type(f32::INFINITY, 1.0, f32::INFINITY));
    spawn(&mut fleet, &[forward(0), forward(1)]);
    let command = |fleet: &mut Fleet, kind: CommandKind| {
        let mut events = events();
        fleet
            .apply(&[CommandRecord { kind: kind as u32, ..CommandRecord::default() }], &mut events);
        events.records().iter().map(|event| event.kind).collect::<Vec<_>>()
    };
    let before = *ticks(&mut fleet, 280).last().expect("ticks");
    assert_eq!(before.state, RobotState::Turning as u8);
    assert!(command(&mut fleet, CommandKind::Hold).contains(&(EventKind::Held as u32)));
    let held = ticks(&mut fleet, 50);
    assert!(
        held.iter().all(|tick| tick.theta == before.theta && tick.state == RobotState::Held as u8)
    );
    command(&mut fleet, CommandKind::Resume);
    let resumed = ticks(&mut fleet, 10);
    assert!(resumed[9].theta > before.theta && resumed[9].state == RobotState::Turning as u8);
    command(&mut fleet, CommandKind::Cancel);
    let cancelled = ticks(&mut fleet, 10);
    assert_eq!(
        (cancelled[9].state, cancelled[9].theta),
        (RobotState::Idle as u8, resumed[9].theta)
    );
    let legs = [
        CommandRecord { kind: CommandKind::Assign as u32, legs: 1, ..CommandRecord::default() },
        CommandRecord {
            kind: CommandKind::Leg as u32,
            id: 1001,
            released: 1,
            ..CommandRecord::default()
        },
    ];
    fleet.apply(&legs, &mut events());
    let end = *ticks(&mut fleet, 400).last().expect("ticks");
    assert_eq!((end.x, end.y, end.theta), (2.0, 2.0, FRAC_PI_2));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, failure_persistence: None, ..ProptestConfig::default() })]

    /// On any polyline, at any limits, headings never jump, robots turn only where they stand, and
    /// all instruction sets and numbers of threads give the same bits.
    #[test]
    fn headings_never_jump(
        corners in prop::collection::vec((-5.0..5.0, -5.0..5.0), 2..7),
        acceleration in prop_oneof![Just(f32::INFINITY), 0.2f32..3.0],
        rotation_speed in 0.3f32..3.0,
        rotation_acceleration in prop_oneof![Just(f32::INFINITY), 0.5f32..5.0],
        offset in prop_oneof![Just(0.0), -3.0..3.0],
    ) {
        let is_apart = |pair: &[(f64, f64)]| DVec2::from(pair[0]).distance(pair[1].into()) > 0.1;
        prop_assume!(corners.windows(2).all(is_apart));
        let graph = polyline(&corners, Orientation::Offset(offset));
        let robot_type = turning_type(acceleration, rotation_speed, rotation_acceleration);
        let legs: Vec<_> = (0..corners.len() as u32 - 1).map(forward).collect();
        let fleets = |isa, threads| {
            let config = FleetConfig { isa, threads, tick_period: Duration::from_millis(10), ..config(vec![robot_type.clone()]) };
            let mut fleet = fleet(&graph, config);
            spawn(&mut fleet, &legs);
            fleet
        };
        let mut reference = fleets(Isa::Scalar, 1);
        let mut others: Vec<_> =
            Isa::ALL.into_iter().filter(|isa| isa.is_supported()).map(|isa| fleets(isa, 2)).collect();
        let mut before: Option<Tick> = None;
        loop {
            let frame = step(&mut reference, &mut events());
            for other in &mut others {
                let same = step(other, &mut events());
                prop_assert_eq!(bits(&same), bits(&frame));
            }
            let c = frame.columns();
            let now = Tick { x: c.x[0], y: c.y[0], theta: c.theta[0], speed: c.speed[0], state: c.state[0] };
            if let Some(before) = before {
                let turned = (f64::from(now.theta - before.theta) + 3.0 * std::f64::consts::PI)
                    .rem_euclid(std::f64::consts::TAU) - std::f64::consts::PI;
                // Corners of up to 5° are driven through.
                let most = f64::from(rotation_speed * 0.0101).max(0.0874);
                prop_assert!(turned.abs() <= most, "{turned} after {before:?}: {now:?}");
                if now.state == RobotState::Turning as u8 && before.state == RobotState::Turning as u8 {
                    prop_assert_eq!((now.x, now.y, now.speed), (before.x, before.y, 0.0));
                    prop_assert!(turned.abs() <= f64::from(rotation_speed * 0.0101));
                }
            }
            if now.state == RobotState::Idle as u8 {
                break;
            }
            before = Some(now);
        }
    }
}
