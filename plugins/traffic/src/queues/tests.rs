use regatta_plugin::frame::{ColumnsMut, Line, frame_lines};

use super::*;

const DRIVING: RobotState = RobotState::Driving;
const WAITING: RobotState = RobotState::Waiting;
const IDLE: RobotState = RobotState::Idle;

/// A robot in a frame: edge, metres along it, speed, and what it does.
type Robot = (u32, f32, f32, RobotState);

/// Edges of 10 m from each node to the next.
fn line(edges: u32) -> Vec<Track> {
    (0..edges).map(|index| Track { origin: index, destination: index + 1, length: 10.0 }).collect()
}

fn add(queues: &mut Queues, robots: &[Robot], sim_secs: f64) {
    let mut lines = vec![Line::default(); frame_lines(robots.len())];
    let columns = ColumnsMut::split(&mut lines, robots.len());
    for (row, (edge, s, speed, state)) in robots.iter().enumerate() {
        (columns.edge[row], columns.s[row]) = (*edge, *s);
        (columns.speed[row], columns.state[row]) = (*speed, *state as u8);
    }
    queues.add(&Columns::split(&lines, robots.len()).expect("lines"), sim_secs);
}

/// Robots stand for ten seconds, then each drives on where it wants to.
fn caused(tracks: Vec<Track>, standing: &[Robot], next: &[u32]) -> Vec<f64> {
    let mut queues = Queues::new(tracks);
    (0..100).for_each(|tick| add(&mut queues, standing, f64::from(tick) / 10.0));
    let moving: Vec<Robot> = next.iter().map(|edge| (*edge, 1.0, 1.0, DRIVING)).collect();
    add(&mut queues, &moving, 10.0);
    queues.caused_secs()
}

#[test]
fn a_queue_over_several_edges_waits_for_what_its_head_is_kept_out_of() {
    // A slow robot is on edge 3; the queue before it goes back to edge 0.
    let standing = [
        (3, 5.0, 0.2, DRIVING),
        (2, 10.0, 0.0, WAITING),
        (2, 8.0, 0.0, WAITING),
        (1, 9.0, 0.0, WAITING),
        (0, 9.0, 0.0, WAITING),
    ];
    assert_eq!(caused(line(5), &standing, &[4, 3, 3, 2, 1]), [0.0, 0.0, 0.0, 40.0, 0.0]);
}

#[test]
fn a_robot_that_moves_up_is_still_in_the_queue() {
    // Robot 1 moves up on edge 1 behind robot 0, and waits again.
    let mut queues = Queues::new(line(4));
    let head = (1, 10.0, 0.0, WAITING);
    add(&mut queues, &[head, (1, 6.0, 0.5, DRIVING), (0, 9.0, 0.0, WAITING)], 0.0);
    add(&mut queues, &[head, (1, 9.0, 0.0, WAITING), (0, 9.0, 0.0, WAITING)], 0.5);
    add(
        &mut queues,
        &[(2, 1.0, 1.0, DRIVING), (2, 0.5, 1.0, DRIVING), (1, 1.0, 1.0, DRIVING)],
        0.9,
    );
    assert_eq!(queues.caused_secs(), [0.0, 0.0, 2.0, 0.0], "robots 0 and 2 in the only sample");
}

#[test]
fn a_robot_at_a_stop_keeps_others_out_of_its_place() {
    // It stands at the end of edge 1, where it loads. The next ones are on the same edge and on the
    // one before.
    let standing = [(1, 10.0, 0.0, IDLE), (1, 8.5, 0.0, WAITING), (0, 9.0, 0.0, WAITING)];
    assert_eq!(caused(line(3), &standing, &[2, 2, 1]), [0.0, 20.0, 0.0]);
}

#[test]
fn a_robot_on_a_junction_keeps_others_from_it() {
    // Edges 0 and 1 end at node 9, from which 2 and 3 lead away. Robot 0 stands on the node, and
    // waits for edge 3.
    let edge = |origin, destination| Track { origin, destination, length: 10.0 };
    let tracks = vec![edge(0, 9), edge(1, 9), edge(9, 2), edge(9, 3)];
    let standing = [(0, 10.0, 0.0, WAITING), (1, 9.2, 0.0, WAITING), (3, 4.0, 0.1, DRIVING)];
    assert_eq!(caused(tracks, &standing, &[3, 2, 3]), [0.0, 0.0, 0.0, 20.0]);
}

#[test]
fn reverse_gear_turns_an_edge_round() {
    // Both came backwards along edge 1 to its origin, and go on to edge 0.
    let mut queues = Queues::new(line(2));
    add(&mut queues, &[(1, 3.0, -1.0, DRIVING), (1, 5.0, -1.0, DRIVING)], 0.0);
    (0..30).for_each(|tick| {
        add(
            &mut queues,
            &[(1, 0.0, 0.0, WAITING), (1, 2.0, 0.0, WAITING)],
            1.0 + f64::from(tick) / 10.0,
        );
    });
    add(&mut queues, &[(0, 9.0, -1.0, DRIVING), (0, 9.5, -1.0, DRIVING)], 4.0);
    assert_eq!(queues.caused_secs(), [6.0, 0.0]);
}

#[test]
fn robots_that_wait_for_each_other_and_for_ever_are_counted_once() {
    let ring = |edges: u32| -> Vec<Track> {
        (0..edges)
            .map(|index| Track { origin: index, destination: (index + 1) % edges, length: 10.0 })
            .collect()
    };
    let standing = [(0, 10.0, 0.0, WAITING), (1, 10.0, 0.0, WAITING), (2, 10.0, 0.0, WAITING)];
    assert_eq!(caused(ring(3), &standing, &[1, 2, 0]).iter().sum::<f64>(), 30.0);
    assert_eq!(
        caused(ring(3), &standing, &[0, 1, 2]).iter().sum::<f64>(),
        30.0,
        "none has ever driven on"
    );
}

#[test]
fn a_long_run_needs_no_more_room() {
    let robots: Vec<Robot> = (0..50_000).map(|_| (0, 5.0, 0.0, WAITING)).collect();
    let mut queues = Queues::new(line(1));
    (0..100).for_each(|second| add(&mut queues, &robots, f64::from(second)));
    assert!(queues.rows <= MAX_ROWS && queues.sample_secs > 1.0, "{} rows", queues.rows);
    let secs = queues.samples.len() as f64 * queues.sample_secs;
    assert!((80.0..=130.0).contains(&secs), "{secs} s are counted");
}
