//! Readers that are killed, stopped, started and ended cause no late tick of the engine.

use std::time::Duration;

use rustix::process::Signal;

use crate::fleet::{Fleet, eventually};

/// The number of attempts: a busy test machine causes late ticks itself, but an engine that waits
/// for a reader is late in every attempt, and more often than without the reader.
const ATTEMPTS: usize = 12;

/// Runs `disturb` beside an engine, and asserts that it causes no late tick.
pub fn costs_no_late_tick(test: &str, disturb: impl Fn(&Fleet)) {
    // The deadline of 20 ms is much longer than the cost of a reader, and much shorter than the
    // time a reader is stopped.
    let fleet = Fleet::start(test, "thirty.yaml", &["--rate", "50"]);
    fleet.let_ticks_pass(20);
    let late: Vec<_> = (0..ATTEMPTS)
        .map(|_| {
            let start = fleet.tick();
            let late = late_during(&fleet, || {
                disturb(&fleet);
                fleet.let_ticks_pass(20);
            });
            let ticks = fleet.tick() - start;
            let undisturbed =
                if late == 0 { 0 } else { late_during(&fleet, || fleet.let_ticks_pass(ticks)) };
            (late, undisturbed)
        })
        .take_while(|(late, undisturbed)| late > undisturbed)
        .collect();
    assert!(
        late.len() < ATTEMPTS,
        "late ticks each time, with and without the disturbance: {late:?}"
    );
    assert!(fleet.engine.interrupt().status.success());
}

/// Returns how many ticks were late while `wait` ran.
fn late_during(fleet: &Fleet, wait: impl FnOnce()) -> u64 {
    let before = fleet.late_ticks();
    wait();
    fleet.late_ticks() - before
}

#[test]
fn a_killed_reader_causes_no_late_tick() {
    costs_no_late_tick("kill-reader", |fleet| {
        let reader = fleet.plugin("hello");
        fleet.let_ticks_pass(20);
        reader.signal(Signal::KILL);
    });
}

#[test]
fn a_stopped_reader_continues_with_the_newest_frame() {
    costs_no_late_tick("stop-reader", |fleet| {
        let reader = fleet.plugin("hello");
        fleet.let_ticks_pass(20);
        reader.signal(Signal::STOP);
        // Long enough for a queue of wake-ups to fill up.
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
        assert!(
            output.status.success() && last.is_some_and(|tick| tick >= resumed),
            "last tick {last:?} of {resumed}"
        );
    });
}

#[test]
fn ten_readers_that_start_and_end_cause_no_late_tick() {
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
fn waiting_without_a_limit_ends_with_the_next_frame() {
    let fleet = Fleet::start("wait-for-ever", "thirty.yaml", &[]);
    let mut reader = fleet.subscriber();
    for _ in 0..2 {
        assert!(reader.wait(Duration::MAX).expect("readable").is_some());
    }
}

#[test]
fn a_late_joiner_gets_the_world_and_the_last_frame_of_a_paused_fleet() {
    let fleet = Fleet::start("late-joiner", "thirty.yaml", &[]);
    fleet.let_ticks_pass(10);
    fleet.control(&["pause"]);
    std::thread::sleep(Duration::from_millis(50));
    let mut reader = fleet.subscriber();
    let robots = eventually("the last frame", || {
        reader.latest().expect("readable").map(|frame| frame.len())
    });
    assert_eq!(robots, 30);
    let mut worlds = regatta_plugin::WorldReader::open(&fleet.name).expect("opened");
    let edges = eventually("the world", || {
        worlds.latest().expect("readable").map(|world| world.edges().len())
    });
    assert!(edges >= 60, "{edges} edges");
}
