//! Readers that are killed, stopped, come and go: the engine must not notice.

use std::time::Duration;

use rustix::process::Signal;

use crate::fleet::{Fleet, eventually};

/// How often something is tried until it costs no late tick: a test machine that builds something meanwhile may be
/// late by itself, but an engine that waits for a reader is late every time.
const ATTEMPTS: usize = 6;

/// Runs something beside an engine, and asserts that not a single tick is late for it.
pub fn costs_no_late_tick(test: &str, disturb: impl Fn(&Fleet)) {
    // A deadline of 20 ms: far above what a reader costs, far below how long one is stopped.
    let fleet = Fleet::start(test, "thirty.yaml", &["--rate", "50"]);
    fleet.let_ticks_pass(20);
    let late: Vec<_> = (0..ATTEMPTS)
        .map(|_| {
            let before = fleet.late_ticks();
            disturb(&fleet);
            fleet.let_ticks_pass(20);
            fleet.late_ticks() - before
        })
        .take_while(|late| *late > 0)
        .collect();
    assert!(late.len() < ATTEMPTS, "late ticks each time: {late:?}");
    assert!(fleet.engine.interrupt().status.success());
}

#[test]
fn a_killed_reader() {
    costs_no_late_tick("kill-reader", |fleet| {
        let reader = fleet.plugin("hello");
        fleet.let_ticks_pass(20);
        reader.signal(Signal::KILL);
    });
}

#[test]
fn a_stopped_reader_goes_on_where_the_fleet_is() {
    costs_no_late_tick("stop-reader", |fleet| {
        let reader = fleet.plugin("hello");
        fleet.let_ticks_pass(20);
        reader.signal(Signal::STOP);
        // Long enough for any queue of wake-ups to fill.
        fleet.let_ticks_pass(300);
        reader.signal(Signal::CONT);
        fleet.let_ticks_pass(50);
        let resumed = fleet.tick() - 50;
        let output = reader.interrupt();
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        let last = text
            .lines()
            .filter_map(|line| line.strip_prefix("tick ")?.split(':').next()?.parse::<u64>().ok())
            .next_back();
        assert!(output.status.success() && last.is_some_and(|tick| tick >= resumed), "last tick {last:?} of {resumed}");
    });
}

#[test]
fn ten_readers_come_and_go() {
    costs_no_late_tick("ten-readers", |fleet| {
        let readers: Vec<_> = (0..10).map(|_| fleet.plugin("hello")).collect();
        fleet.let_ticks_pass(30);
        for reader in readers {
            let output = reader.interrupt();
            assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        }
    });
}

#[test]
fn a_late_joiner_gets_world_and_frame_of_a_paused_fleet() {
    let fleet = Fleet::start("late-joiner", "thirty.yaml", &[]);
    fleet.let_ticks_pass(10);
    fleet.tell(&["pause"]);
    std::thread::sleep(Duration::from_millis(50));
    let mut reader = fleet.subscriber();
    let robots = eventually("the last frame", || reader.latest().expect("readable").map(|frame| frame.len()));
    assert_eq!(robots, 30);
    let mut worlds = regatta_plugin::WorldReader::open(&fleet.name).expect("opened");
    let edges = eventually("the world", || worlds.latest().expect("readable").map(|world| world.edges().len()));
    assert!(edges >= 60, "{edges} edges");
}
