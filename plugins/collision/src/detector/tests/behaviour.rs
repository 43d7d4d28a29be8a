//! Guarantees of the detector beyond exactness: hysteresis, limits, totals.

use std::collections::BTreeMap;

use regatta_plugin::contact::{ContactChange, ContactLevel};
use regatta_plugin::frame::RobotState;
use regatta_plugin::route::RouteResponse;
use regatta_plugin::world::{CurveRecord, EdgeRecord, RobotTypeRecord, WorldData};

use super::fleet::{Robot, robot_types, update};
use crate::criteria::Settings;
use crate::detector::Detector;
use crate::geometry_reference::world;

fn detector(margin: f32, horizon: f32) -> Detector {
    let mut detector = Detector::new(Settings::new(margin, horizon).expect("valid settings"));
    detector
        .set_world(&WorldData { robot_types: robot_types(), ..WorldData::default() }.view(1, 1));
    detector
}

/// Returns two robots of 0.9 m, one behind the other, with a gap in metres between them.
fn queue(gap: f32) -> [Robot; 2] {
    [Robot::IDLE, Robot { x: 0.9 + gap, ..Robot::IDLE }]
}

fn changes(detector: &Detector) -> Vec<(u32, u32)> {
    detector.events().iter().map(|event| (event.level, event.change)).collect()
}

const POSSIBLE: u32 = ContactLevel::Possible as u32;
const TOUCHING: u32 = ContactLevel::Touching as u32;
const BEGAN: u32 = ContactChange::Began as u32;
const ENDED: u32 = ContactChange::Ended as u32;

#[test]
fn a_level_is_left_at_a_larger_distance_than_it_is_reached() {
    let mut detector = detector(0.2, 0.0);
    let steps: [(f32, &[(u32, u32)]); 9] = [
        (0.21, &[]),
        (0.19, &[(POSSIBLE, BEGAN)]),
        (0.21, &[]),
        (-0.01, &[(TOUCHING, BEGAN)]),
        (0.01, &[]),
        (0.03, &[(TOUCHING, ENDED)]),
        (0.01, &[]),
        (0.23, &[(POSSIBLE, ENDED)]),
        (-0.5, &[(POSSIBLE, BEGAN), (TOUCHING, BEGAN)]),
    ];
    for (tick, (gap, expected)) in (1..).zip(steps) {
        update(&mut detector, &queue(gap), tick);
        assert_eq!(changes(&detector), expected, "at {gap} m");
    }
    update(&mut detector, &[], 10);
    assert_eq!(changes(&detector), [(TOUCHING, ENDED), (POSSIBLE, ENDED)], "both robots have left");
}

#[test]
fn robots_on_different_levels_never_touch() {
    let mut data = WorldData { robot_types: robot_types(), ..WorldData::default() };
    for name in ["L1", "L2", ""] {
        let level = data.texts.add(name);
        let edge = EdgeRecord { level, ..EdgeRecord::default() };
        data.add_edge(edge, [CurveRecord::straight([0.0, 0.0], [9.0, 0.0])]);
    }
    let mut detector = detector(0.2, 2.0);
    detector.set_world(&data.view(1, 1));
    let cases = [([0, 0], 1), ([0, 1], 0), ([1, 2], 1), ([0, u32::MAX], 1), ([1, 0], 0)];
    for (tick, (edges, touching)) in (1..).zip(cases) {
        let [first, second] = queue(-0.2);
        let robots = [Robot { edge: edges[0], ..first }, Robot { edge: edges[1], ..second }];
        update(&mut detector, &robots, tick);
        assert_eq!(detector.touching(), touching, "on the edges {edges:?}");
    }
}

#[test]
fn pairs_do_not_flicker_at_a_boundary() {
    let mut detector = detector(0.2, 2.0);
    let mut events = 0;
    for tick in 0..1000 {
        // A centimetre back and forth around the margin, and around the distance that is driven
        // within the horizon.
        let jitter = if tick % 2 == 0 { 0.005 } else { -0.005 };
        let [first, second] = queue(0.2 + jitter);
        let third = Robot { x: -10.9 + jitter, speed: 5.0, state: 1, ..Robot::IDLE };
        update(&mut detector, &[first, second, third], tick);
        events += detector.events().len();
    }
    assert_eq!(events, 2, "both begin once");
}

#[test]
fn a_collision_is_predicted_when_it_is_within_the_horizon() {
    let mut detector = detector(0.0, 2.0);
    // A robot drives at 1 m/s towards one at rest: they are 2.5 m apart, and 2 m after half a
    // second.
    let mut began = None;
    for tick in 0..100 {
        let driven = tick as f32 * 0.01;
        let [ahead, behind] = queue(2.5 - driven).map(|robot| Robot { state: 1, ..robot });
        update(&mut detector, &[Robot { speed: 1.0, ..ahead }, behind], tick);
        if !detector.events().is_empty() {
            began = began.or(Some(tick));
        }
    }
    assert!(began.is_some_and(|tick| (50..=51).contains(&tick)), "{began:?}");
}

#[test]
fn held_robots_stay_put_and_reversing_ones_go_backwards() {
    let [ahead, behind] = queue(1.0);
    let levels = |speed: f32, state: u8| {
        let mut detector = detector(0.0, 2.0);
        update(&mut detector, &[ahead, Robot { speed, state, ..behind }], 0);
        detector.levels().to_vec()
    };
    assert_eq!(levels(-1.0, 1), [1.0, 1.0], "backwards into the one behind");
    assert_eq!(levels(1.0, 1), [0.0, 0.0], "away from it");
    assert_eq!(levels(-1.0, 3), [0.0, 0.0], "held");
}

/// Robots of 0.9 m that brake at 0.8 m/s² on a fork: edge 0 leads 10 m to the east, from there edge
/// 1 on to the east and edge 2 to the north.
fn fork() -> Detector {
    let edge = |origin, destination, [from, to]: [[f32; 2]; 2]| {
        let edge =
            EdgeRecord { origin, destination, length: 10.0, speed: 1.5, ..EdgeRecord::default() };
        (edge, CurveRecord::straight(from, to).control_points)
    };
    let limited = RobotTypeRecord { max_speed: 1.5, max_acceleration: 0.8, ..robot_types()[0] };
    let mut detector = Detector::new(Settings::new(0.0, 2.0).expect("valid settings"));
    let middle = [10.0, 0.0];
    let edges = [
        edge(0, 1, [[0.0, 0.0], middle]),
        edge(1, 2, [middle, [20.0, 0.0]]),
        edge(1, 3, [middle, [10.0, 10.0]]),
    ];
    detector.set_world(&WorldData { robot_types: vec![limited], ..world(edges) }.view(1, 1));
    detector
}

/// Returns a robot at a distance along edge 0 of the fork.
fn on_fork(x: f32, speed: f32, state: RobotState) -> Robot {
    Robot { x, s: x, edge: 0, speed, state: state as u8, ..Robot::IDLE }
}

#[test]
fn a_held_robot_that_brakes_is_possible_until_it_hits() {
    // It is held at 1.5 m/s, 0.68 m before another, and needs 1.4 m to stop.
    let (mut detector, mut x, mut speed) = (fork(), 3.0, 1.5_f32);
    let standing = on_fork(3.0 + 0.9 + 0.68, 0.0, RobotState::Idle);
    for tick in 0..100 {
        update(&mut detector, &[on_fork(x, speed, RobotState::Held), standing], tick);
        let level = if x + 0.9 < standing.x { 1.0 } else { 2.0 };
        assert_eq!(detector.levels(), [level; 2], "after {tick} ticks, at {x} m");
        if level == 2.0 {
            assert!((1.0..1.2).contains(&speed), "it hits at {speed} m/s");
            return;
        }
        (x, speed) = (x + (speed - 0.004) * 0.01, speed - 0.008);
    }
    panic!("it never hits");
}

#[test]
fn a_held_robot_that_stops_in_time_is_clear() {
    let mut detector = fork();
    let standing = on_fork(3.0 + 0.9 + 1.45, 0.0, RobotState::Idle);
    for (state, level) in [(RobotState::Held, 0.0), (RobotState::Driving, 1.0)] {
        update(&mut detector, &[on_fork(3.0, 1.5, state), standing], 0);
        assert_eq!(detector.levels(), [level; 2], "{state:?}");
    }
}

#[test]
fn a_robot_whose_route_turns_away_is_clear_and_one_whose_route_turns_towards_is_possible() {
    let driving = on_fork(8.5, 1.5, RobotState::Driving);
    let in_the_east = Robot { x: 11.5, ..Robot::IDLE };
    let in_the_north = Robot { x: 10.0, y: 1.5, ..Robot::IDLE };
    let levels = |legs: Option<&[u32]>, released: usize, other: Robot| {
        let mut detector = fork();
        update(&mut detector, &[driving, other], 1);
        if let Some(legs) = legs {
            let edges = legs.iter().map(|edge| (*edge, false));
            let answer = RouteResponse::unknown(1, 1, 0).with_legs(released, legs.len(), edges);
            detector.routes_mut().learn(&answer);
        }
        update(&mut detector, &[driving, other], 2);
        detector.levels()[0]
    };
    assert_eq!(
        [in_the_east, in_the_north].map(|other| levels(Some(&[0, 2]), 2, other)),
        [0.0, 1.0],
        "to the north"
    );
    assert_eq!(
        [in_the_east, in_the_north].map(|other| levels(Some(&[0, 1]), 2, other)),
        [1.0, 0.0],
        "to the east"
    );
    assert_eq!(
        [in_the_east, in_the_north].map(|other| levels(None, 0, other)),
        [1.0, 1.0],
        "any way"
    );
    assert_eq!(
        [in_the_east, in_the_north].map(|other| levels(Some(&[0, 1]), 1, other)),
        [0.0, 0.0],
        "not released"
    );
}

/// Far more robots on one spot than the limits allow, and others far from them.
#[test]
fn a_pile_of_all_robots_is_capped_and_reported_so() {
    let robots = 20_000;
    let mut detector = detector(0.0, 0.0);
    let pile = |spread: f32| -> Vec<_> {
        (0..robots)
            .map(|number| match number {
                0..100 => Robot {
                    x: 100.0 + (number / 2) as f32 * 2.0,
                    y: (number % 2) as f32 * 0.5,
                    ..Robot::IDLE
                },
                _ => Robot {
                    x: (number % 100) as f32 * spread,
                    y: (number / 100) as f32 * spread,
                    ..Robot::IDLE
                },
            })
            .collect()
    };
    update(&mut detector, &pile(0.0), 0);
    assert!(detector.is_capped() && detector.totals().is_capped());
    assert!(detector.levels().iter().all(|level| *level == 2.0), "each robot touches another");
    let max_pairs = 8 * robots + (1 << 16);
    assert!(detector.contacts().len() <= max_pairs && detector.contacts().len() > robots / 2);
    let far: Vec<_> =
        detector.contacts().iter().filter(|contact| contact.robots[0] < 100).collect();
    assert_eq!(far.len(), 50, "all pairs elsewhere are listed");

    let mut open = BTreeMap::new();
    for (tick, spread) in (1..).zip([0.0, 0.0, 0.001, 3.0]) {
        update(&mut detector, &pile(spread), tick);
        for event in detector.events() {
            let key = (event.robots, event.level);
            *open.entry(key).or_insert(0) += if event.change == BEGAN { 1 } else { -1 };
        }
        let mut pairs: Vec<_> = detector.contacts().iter().map(|contact| contact.robots).collect();
        pairs.sort_unstable();
        pairs.dedup();
        assert_eq!(pairs.len(), detector.contacts().len(), "no pair is listed twice");
        assert!(pairs.len() <= max_pairs);
        let ended = detector.events().iter().filter(|event| event.change == ENDED).count();
        assert!(
            spread == 3.0 || ended == 0,
            "pairs that still touch are kept: {ended} at {spread}"
        );
    }
    assert!(!detector.is_capped(), "they have dispersed");
    assert_eq!(detector.contacts().len(), 50);
    assert!(open.values().all(|open| (-1..=1).contains(open)), "begins and ends alternate");
}

#[test]
fn another_run_resets_the_detector() {
    let mut detector = detector(0.0, 0.0);
    update(&mut detector, &queue(-0.1), 5);
    assert_eq!(detector.totals().all().contacts, 1);
    update(&mut detector, &queue(-0.1), 6);
    assert_eq!((changes(&detector).len(), detector.contacts()[0].since_tick), (0, 5));
    update(&mut detector, &queue(-0.1), 2);
    assert_eq!(
        (changes(&detector).len(), detector.contacts()[0].since_tick),
        (2, 2),
        "a tick before the last one"
    );
    assert_eq!(detector.totals().all().contacts, 1, "totals are reset, too");
}

#[test]
fn totals_list_the_worst_first() {
    let mut detector = detector(0.0, 0.0);
    // Robots 0 and 1 touch three times for a second each, 2 and 3 once for four seconds.
    for tick in 0..10_u64 {
        let touch = |apart: bool| if apart { 5.0 } else { -0.1 };
        let [a, b] =
            queue(touch(tick % 2 == 0 || tick > 5)).map(|robot| Robot { edge: 7, ..robot });
        let [c, d] =
            queue(touch(!(2..6).contains(&tick))).map(|robot| Robot { y: 50.0, edge: 9, ..robot });
        update(&mut detector, &[a, b, c, d], tick);
    }
    let totals = detector.totals();
    let scores: Vec<_> = totals
        .worst_pairs(10)
        .into_iter()
        .map(|(pair, score)| (pair, score.touching_nanos, score.contacts))
        .collect();
    assert_eq!(scores, [([2, 3], 4_000_000_000, 1), ([0, 1], 3_000_000_000, 3)]);
    let edges: Vec<_> =
        totals.worst_edges(1).into_iter().map(|(edge, score)| (edge, score.contacts)).collect();
    assert_eq!(edges, [(9, 1)]);
    assert_eq!(totals.worst_robots(10).len(), 4);
    assert_eq!((totals.all().contacts, totals.all().warnings), (4, 4));
}

#[test]
fn touching_time_counts_for_the_edge_on_which_it_passed() {
    let mut detector = detector(0.0, 0.0);
    // The robots touch for four seconds on one edge, for two on the next, and part on a third.
    for tick in 0..8_u64 {
        let edge = [7, 8, 9][usize::from(tick >= 4) + usize::from(tick >= 6)];
        let robots = queue(if tick < 6 { -0.1 } else { 5.0 }).map(|robot| Robot { edge, ..robot });
        update(&mut detector, &robots, tick);
    }
    let edges = detector.totals().worst_edges(10).into_iter();
    let edges: Vec<_> = edges.map(|(edge, score)| (edge, score.touching_nanos)).collect();
    assert_eq!(edges, [(7, 4_000_000_000), (8, 2_000_000_000)]);
}
