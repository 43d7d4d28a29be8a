//! Spots of frames that are written by hand.

use regatta_plugin::contact::ContactLevel;
use regatta_plugin::frame::{ColumnsMut, FrameHeader, Line, RobotState, frame_lines, stride_lines};

use super::*;

/// Robots as x, y, edge and state, in a frame at a time in seconds.
fn at(secs: f64, robots: &[(f32, f32, u32, RobotState)], use_frame: impl FnOnce(&Frame<'_>)) {
    after_jumps(0, secs, robots, use_frame);
}

fn after_jumps(
    jumps: u64,
    secs: f64,
    robots: &[(f32, f32, u32, RobotState)],
    use_frame: impl FnOnce(&Frame<'_>),
) {
    let header = FrameHeader {
        run_id: 1,
        jumps,
        robots: robots.len() as u32,
        stride_lines: stride_lines(robots.len()) as u32,
        sim_time_nanos: (secs * 1e9) as u64,
        ..FrameHeader::default()
    };
    let mut lines = vec![Line::default(); frame_lines(robots.len())];
    let columns = ColumnsMut::split(&mut lines, robots.len());
    for (i, (x, y, edge, state)) in robots.iter().enumerate() {
        (columns.x[i], columns.y[i], columns.edge[i], columns.state[i]) =
            (*x, *y, *edge, *state as u8);
    }
    use_frame(&Frame::new(&header, &lines).expect("a frame"));
}

fn touching(robots: [u32; 2], x: f32) -> ContactRecord {
    ContactRecord {
        robots,
        x,
        y: 0.0,
        level: ContactLevel::Touching as u32,
        ..ContactRecord::default()
    }
}

#[test]
fn a_platoon_of_four_that_touch_is_one_spot_and_each_robot_counts_once() {
    let platoon = [0.0, 1.2, 2.4, 3.6].map(|x| (x, 0.0, 7, RobotState::Driving));
    // All six pairs, each at the middle of its two robots, as if all of them overlapped.
    let pairs: Vec<_> = (0..4_u32)
        .flat_map(|a| (a + 1..4).map(move |b| touching([a, b], 0.6 * (a + b) as f32)))
        .collect();
    let mut spots = Spots::default();
    for second in 0..=10 {
        at(f64::from(second), &platoon, |frame| spots.add(frame, &pairs));
    }
    let list = spots.list();
    assert_eq!(list.len(), 1, "{list:?}");
    assert!((list[0].contact_secs - 40.0).abs() < 1e-6, "four robots for ten seconds: {list:?}");
    assert_eq!(
        (list[0].standing_secs, list[0].edges().collect::<Vec<_>>(), list[0].seen),
        (0.0, vec![7], [1.0, 10.0])
    );
}

#[test]
fn places_apart_are_spots_of_their_own_ranked_by_lost_time() {
    let waits = |x, edge| (x, 0.0, edge, RobotState::Waiting);
    let robots =
        [waits(0.0, 1), waits(100.0, 2), waits(101.0, 3), (200.0, 0.0, 4, RobotState::Idle)];
    let mut spots = Spots::default();
    for second in 0..=20 {
        at(f64::from(second), &robots, |frame| spots.add(frame, &[]));
    }
    let found: Vec<(f64, Vec<u32>)> = spots
        .list()
        .iter()
        .map(|spot| (spot.lost_secs().round(), spot.edges().collect()))
        .collect();
    assert_eq!(found, [(40.0, vec![2, 3]), (20.0, vec![1])], "an idle robot loses no time");
    let worst = spots.list()[0];
    assert!(
        (worst.x - 100.5).abs() < 1e-3 && worst.y == 0.0 && worst.trend() == Trend::Steady,
        "{worst:?}"
    );
}

#[test]
fn trends_compare_the_last_minute_with_the_time_before() {
    let jam = [(0.0, 0.0, 1, RobotState::Waiting), (0.5, 0.0, 1, RobotState::Waiting)];
    let free = jam.map(|(x, y, edge, _)| (x, y, edge, RobotState::Driving));
    let one = [jam[0], free[1]];
    let mut spots = Spots::default();
    let mut run = |from: u32, to: u32, robots: &[_]| {
        for second in from..to {
            at(f64::from(second), robots, |frame| spots.add(frame, &[]));
        }
        spots.list()[0].trend()
    };
    assert_eq!(run(0, 600, &one), Trend::Steady);
    assert_eq!(run(600, 680, &jam), Trend::Growing);
    assert_eq!(run(680, 1400, &jam), Trend::Steady);
    assert_eq!(run(1400, 1510, &one), Trend::Easing);
    assert_eq!(run(1510, 1800, &free), Trend::Over);
}

#[test]
fn another_run_begins_anew() {
    let jam = [(0.0, 0.0, 1, RobotState::Waiting)];
    let mut spots = Spots::default();
    for second in [10.0, 11.0, 12.0] {
        at(second, &jam, |frame| spots.add(frame, &[]));
    }
    assert_eq!(spots.list().len(), 1);
    at(3.0, &jam, |frame| spots.add(frame, &[]));
    assert!(spots.list().is_empty(), "time went back");
}

#[test]
fn nobody_loses_the_time_of_a_jump() {
    let jam = [(0.0, 0.0, 1, RobotState::Waiting)];
    let mut spots = Spots::default();
    for (jumps, secs) in [(1, 10.0), (1, 12.0), (2, 40.0), (2, 43.0), (3, 43.5), (3, 43.5)] {
        after_jumps(jumps, secs, &jam, |frame| spots.add(frame, &[]));
    }
    assert_eq!(
        spots.list()[0].standing_secs,
        5.0,
        "two seconds before the jump, and three after it"
    );
}

#[test]
fn of_many_cells_the_list_has_the_worst_ones() {
    // Each robot stands alone, so far from the others that it is a spot of its own, and for as many
    // seconds as its number.
    let robots: Vec<_> =
        (0..300).map(|robot| (20.0 * robot as f32, 0.0, robot, RobotState::Broken)).collect();
    let mut spots = Spots::default();
    for second in 0..=300_u32 {
        let standing = robots.iter().map(|robot| {
            let state = if second <= robot.2 { RobotState::Broken } else { RobotState::Driving };
            (robot.0, robot.1, robot.2, state)
        });
        at(f64::from(second), &standing.collect::<Vec<_>>(), |frame| spots.add(frame, &[]));
    }
    let found: Vec<_> =
        spots.list().iter().map(|spot| (spot.standing_secs as u32, spot.edges[0])).collect();
    let expected: Vec<_> = (100..300).rev().map(|robot| (robot, robot)).collect();
    assert_eq!(found, expected);
}

#[test]
fn a_robot_that_moves_on_loses_time_where_it_is_and_a_contact_of_nobody_counts_nowhere() {
    let mut spots = Spots::default();
    for second in 0..=20_u32 {
        let x = if second <= 10 { 0.0 } else { 50.0 };
        let pairs = [touching([0, u32::MAX], x)];
        at(f64::from(second), &[(x, 0.0, 1, RobotState::Waiting)], |frame| {
            spots.add(frame, &pairs)
        });
    }
    let found: Vec<_> =
        spots.list().iter().map(|spot| (spot.x, spot.contact_secs, spot.standing_secs)).collect();
    assert_eq!(found, [(0.0, 10.0, 0.0), (50.0, 10.0, 0.0)]);
}
