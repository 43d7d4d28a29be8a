//! What the detector promises beyond being exact: no flicker, an end to what it takes on, totals.

use std::collections::BTreeMap;

use regatta_plugin::contact::{ContactChange, ContactLevel};

use crate::detector::Detector;
use crate::oracle_tests::{Robot, look, types};
use crate::settings::Settings;

fn detector(margin: f32, horizon: f32) -> Detector {
    let mut detector = Detector::new(Settings::new(margin, horizon).expect("sane"));
    detector.set_world(&[], &types());
    detector
}

/// Two robots of 0.9 m, one behind the other, that far apart.
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
fn a_level_is_left_farther_out_than_it_is_reached() {
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
        look(&mut detector, &queue(gap), tick);
        assert_eq!(changes(&detector), expected, "at {gap} m");
    }
    look(&mut detector, &[], 10);
    assert_eq!(changes(&detector), [(TOUCHING, ENDED), (POSSIBLE, ENDED)], "they are gone");
}

#[test]
fn nobody_flickers_at_a_boundary() {
    let mut detector = detector(0.2, 2.0);
    let mut told = 0;
    for tick in 0..1000 {
        // A centimetre to and fro about the margin; and about what is reached within the horizon.
        let jitter = if tick % 2 == 0 { 0.005 } else { -0.005 };
        let [first, second] = queue(0.2 + jitter);
        let third = Robot { x: -10.9 + jitter, speed: 5.0, state: 1, ..Robot::IDLE };
        look(&mut detector, &[first, second, third], tick);
        told += detector.events().len();
    }
    assert_eq!(told, 2, "both begin once");
}

#[test]
fn predictions_come_true_at_the_speed_of_the_robots() {
    let mut detector = detector(0.0, 2.0);
    // 1 m/s towards one that stands: 2.5 m apart, and after half a second 2 m.
    let mut began = None;
    for tick in 0..100 {
        let driven = tick as f32 * 0.01;
        let [ahead, behind] = queue(2.5 - driven).map(|robot| Robot { state: 1, ..robot });
        look(&mut detector, &[Robot { speed: 1.0, ..ahead }, behind], tick);
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
        look(&mut detector, &[ahead, Robot { speed, state, ..behind }], 0);
        detector.levels().to_vec()
    };
    assert_eq!(levels(-1.0, 1), [1.0, 1.0], "backwards into the one behind");
    assert_eq!(levels(1.0, 1), [0.0, 0.0], "away from it");
    assert_eq!(levels(-1.0, 3), [0.0, 0.0], "held");
}

/// Far more robots on one spot than it can take on, and others that have nothing to do with them.
#[test]
fn a_pile_of_everybody_is_capped_and_says_so() {
    let robots = 20_000;
    let mut detector = detector(0.0, 0.0);
    let pile = |spread: f32| -> Vec<_> {
        (0..robots)
            .map(|number| match number {
                0..100 => Robot { x: 100.0 + (number / 2) as f32 * 2.0, y: (number % 2) as f32 * 0.5, ..Robot::IDLE },
                _ => Robot { x: (number % 100) as f32 * spread, y: (number / 100) as f32 * spread, ..Robot::IDLE },
            })
            .collect()
    };
    look(&mut detector, &pile(0.0), 0);
    assert!(detector.is_capped() && detector.tally().is_capped());
    assert!(detector.levels().iter().all(|level| *level == 2.0), "everybody touches somebody");
    let most = 8 * robots + (1 << 16);
    assert!(detector.contacts().len() <= most && detector.contacts().len() > robots / 2);
    let far: Vec<_> = detector.contacts().iter().filter(|contact| contact.robots[0] < 100).collect();
    assert_eq!(far.len(), 50, "those elsewhere are all told");

    let mut open = BTreeMap::new();
    for (tick, spread) in (1..).zip([0.0, 0.0, 0.001, 3.0]) {
        look(&mut detector, &pile(spread), tick);
        for event in detector.events() {
            let key = (event.robots, event.level);
            *open.entry(key).or_insert(0) += if event.change == BEGAN { 1 } else { -1 };
        }
        let mut pairs: Vec<_> = detector.contacts().iter().map(|contact| contact.robots).collect();
        pairs.sort_unstable();
        pairs.dedup();
        assert_eq!(pairs.len(), detector.contacts().len(), "none is told twice");
        assert!(pairs.len() <= most);
        let ended = detector.events().iter().filter(|event| event.change == ENDED).count();
        assert!(spread == 3.0 || ended == 0, "known pairs that go on are not lost: {ended} at {spread}");
    }
    assert!(!detector.is_capped(), "they have dispersed");
    assert_eq!(detector.contacts().len(), 50);
    assert!(open.values().all(|open| (-1..=1).contains(open)), "begins and ends take turns");
}

#[test]
fn another_run_begins_anew() {
    let mut detector = detector(0.0, 0.0);
    look(&mut detector, &queue(-0.1), 5);
    assert_eq!(detector.tally().all().contacts, 1);
    look(&mut detector, &queue(-0.1), 6);
    assert_eq!((changes(&detector).len(), detector.contacts()[0].since_tick), (0, 5));
    look(&mut detector, &queue(-0.1), 2);
    assert_eq!((changes(&detector).len(), detector.contacts()[0].since_tick), (2, 2), "back in time");
    assert_eq!(detector.tally().all().contacts, 1, "totals too");
}

#[test]
fn totals_name_the_worst() {
    let mut detector = detector(0.0, 0.0);
    // Robots 0 and 1 touch three times for a second, 2 and 3 once for four.
    for tick in 0..10_u64 {
        let touch = |apart: bool| if apart { 5.0 } else { -0.1 };
        let [a, b] = queue(touch(tick % 2 == 0 || tick > 5)).map(|robot| Robot { edge: 7, ..robot });
        let [c, d] = queue(touch(!(2..6).contains(&tick))).map(|robot| Robot { y: 50.0, edge: 9, ..robot });
        look(&mut detector, &[a, b, c, d], tick);
    }
    let tally = detector.tally();
    let scores: Vec<_> =
        tally.worst_pairs(10).into_iter().map(|(pair, score)| (pair, score.touching_nanos, score.contacts)).collect();
    assert_eq!(scores, [((2, 3), 4_000_000_000, 1), ((0, 1), 3_000_000_000, 3)]);
    let edges: Vec<_> = tally.worst_edges(1).into_iter().map(|(edge, score)| (edge, score.contacts)).collect();
    assert_eq!(edges, [(9, 1)]);
    assert_eq!(tally.worst_robots(10).len(), 4);
    assert_eq!((tally.all().contacts, tally.all().warnings), (4, 4));
}

#[test]
fn time_counts_for_the_edge_where_it_passed() {
    let mut detector = detector(0.0, 0.0);
    // They touch for four seconds on one edge, for two on the next, and come apart on a third.
    for tick in 0..8_u64 {
        let edge = [7, 8, 9][usize::from(tick >= 4) + usize::from(tick >= 6)];
        let robots = queue(if tick < 6 { -0.1 } else { 5.0 }).map(|robot| Robot { edge, ..robot });
        look(&mut detector, &robots, tick);
    }
    let edges = detector.tally().worst_edges(10).into_iter();
    let edges: Vec<_> = edges.map(|(edge, score)| (edge, score.touching_nanos)).collect();
    assert_eq!(edges, [(7, 4_000_000_000), (8, 2_000_000_000)]);
}
