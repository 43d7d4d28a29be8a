use std::collections::BTreeSet;

use proptest::prelude::*;
use ratatui::Terminal;
use ratatui::backend::TestBackend;
use regatta_plugin::activity::Activity;
use regatta_plugin::contact::ContactRecord;
use regatta_plugin::frame::RobotState;

use super::*;
use crate::durations::{DurationRecorder, DurationStats};
use crate::snapshot::{Collisions, IntervalStats, Snapshot};
use crate::testing;

fn stats(seconds: f64) -> DurationStats {
    let mut recorder = DurationRecorder::default();
    recorder.observe(seconds);
    recorder.take_stats()
}

/// Returns the view of a fleet that has run for a while.
fn view(snapshot: Snapshot) -> View {
    let mut view = View::new(&snapshot.fleet);
    for k in 0..200 {
        let cost = 50e-6 * (1.0 + (f64::from(k) * 0.3).sin());
        let interval =
            IntervalStats { tick_cost: stats(cost), jitter: stats(2e-3), frame_age: stats(70e-6) };
        view.history.add(&interval, &snapshot);
    }
    view.snapshot = snapshot;
    view
}

/// Returns the screen as text.
fn drawn(view: &mut View, width: u16, height: u16) -> String {
    let mut terminal = Terminal::new(TestBackend::new(width, height)).expect("a terminal");
    terminal.draw(|frame| draw(frame, view)).expect("drawn");
    let buffer = terminal.backend().buffer();
    let rows = buffer.content.chunks(usize::from(width.max(1)));
    rows.map(|row| row.iter().map(|cell| cell.symbol()).collect::<String>() + "\n").collect()
}

fn shows(screen: &str, wanted: &[&str]) {
    for text in wanted {
        assert!(screen.contains(text), "{text} in\n{screen}");
    }
}

#[test]
fn everything_is_visible_at_80_by_24() {
    let screen = drawn(&mut view(testing::snapshot()), 80, 24);
    shows(
        &screen,
        &[
            "running",
            "×1",
            "t 20:34.56",
            "tick 123,456",
            "tick cost",
            "real time",
            "frame age",
            "█",
        ],
    );
    shows(
        &screen,
        &["0.998 of ×1", "70 µs", "robots", "1,000", "carrying", "614", "fetching", "waiting"],
    );
    shows(&screen, &["late ticks", "2.00 ms", "mean speed", "1.23 m/s", "frames", "61,728"]);
    shows(
        &screen,
        &["12 touching, 30 possible", "touching", "0 10000", "0.0, -1.5", "0.8", "4.6 s"],
    );
    shows(
        &screen,
        &[
            "orders",
            "58 open, 4,321 finished, 450 an hour",
            "■ 614 carrying  ■ 201 fetching  ■ 30 handling  ■ 90 waiting",
        ],
    );
    shows(&screen, &["service 61 55 120 300 s", "until assigned 8.4 6.0 40 96 s"]);
    shows(&screen, &["processes", "engine", "4000000", "12 %", "34 MB", "metrics"]);
    shows(&screen, &["space pause", "q quit"]);
}

#[test]
fn figures_of_the_run_are_none_since_top_began_and_robots_have_one_vocabulary() {
    let snapshot = testing::snapshot();
    let screen = drawn(&mut view(snapshot.clone()), 160, 50);
    for own in ["driven", "98.77 km", "frames read", "12,345", "frames skipped"] {
        assert!(!screen.contains(own), "{own} in\n{screen}");
    }
    assert!(!screen.contains("812"), "a number of robots by state:\n{screen}");
    shows(&screen, &["since top began: "]);
    let mut few = snapshot.clone();
    if let Some(work) = &mut few.work {
        work.robots = [44, 201, 614, 0, 90, 0, 0, 0, 0, 0, 0, 0, 0];
    }
    let screen = drawn(&mut view(few), 80, 24);
    shows(&screen, &["carrying █", "614", "fetching █", "201", "idle", "44"]);
    assert!(!screen.contains("■ 614"), "each number is shown once:\n{screen}");
    let unmanaged = Snapshot { work: None, ..snapshot };
    shows(&drawn(&mut view(unmanaged), 80, 24), &["moving", "812", "idle", "held", "faulted"]);
}

#[test]
fn a_list_of_processes_that_is_too_long_says_so() {
    let mut snapshot = testing::snapshot();
    let process = snapshot.processes[0].clone();
    snapshot.processes = vec![process; 60];
    let screen = drawn(&mut view(snapshot.clone()), 80, 24);
    let shown = screen.matches(" metrics ").count();
    assert!(shown > 1 && shown < 60, "{shown} in\n{screen}");
    shows(&screen, &[&format!("{shown} of 60")]);
    snapshot.processes.truncate(shown);
    let screen = drawn(&mut view(snapshot), 80, 24);
    assert!(screen.contains("processes") && !screen.contains(&format!("of {shown} ")), "{screen}");
}

#[test]
fn the_list_of_collisions_scrolls_only_to_its_end() {
    let mut view = view(testing::snapshot());
    view.scroll_by(10);
    let screen = drawn(&mut view, 80, 24);
    shows(&screen, &["10 10010", "possible"]);
    assert!(!screen.contains("9 10009"), "{screen}");
    view.scroll_by(isize::MAX);
    shows(&drawn(&mut view, 80, 24), &["41 10041"]);
    view.scroll_by(-1);
    let screen = drawn(&mut view, 80, 24);
    assert!(!screen.contains("41 10041"), "scrolling up by one line moves one line:\n{screen}");
    view.snapshot.collisions = testing::collisions(1, 0);
    shows(&drawn(&mut view, 80, 24), &["0 10000"]);
    assert_eq!(view.scroll, 0);
}

#[test]
fn missing_parts_are_reported_with_advice() {
    let mut lonely = view(testing::without_engine());
    shows(
        &drawn(&mut lonely, 80, 24),
        &["No engine runs the fleet 'default'", "regatta run ", "engine"],
    );
    lonely.process_error = Some("can't list processes".to_owned());
    shows(&drawn(&mut lonely, 80, 24), &["can't list processes"]);
    let mut unchecked = view(testing::snapshot());
    unchecked.snapshot.collisions = Collisions::default();
    shows(&drawn(&mut unchecked, 80, 24), &["No checker runs", "regatta plugin"]);
    unchecked.snapshot.collisions = testing::collisions(0, 0);
    shows(&drawn(&mut unchecked, 80, 24), &["0 touching, 0 possible", "No robots touch"]);
    shows(&drawn(&mut unchecked, 60, 12), &["too small"]);
}

#[test]
fn without_a_manager_the_collisions_have_its_room() {
    let snapshot = Snapshot { work: None, ..testing::snapshot() };
    let screen = drawn(&mut view(snapshot), 80, 24);
    assert!(!screen.contains("orders") && !screen.contains("until assigned 8.4"), "{screen}");
    shows(&screen, &["5 10005"]);
}

#[test]
fn outcomes_and_help_are_shown() {
    let mut view = view(testing::snapshot());
    view.outcome = Some(Err("the engine has not answered".to_owned()));
    view.help = true;
    let screen = drawn(&mut view, 80, 24);
    shows(&screen, &["the engine has not answered", "pause or resume", "scroll the collisions"]);
}

proptest! {
    #[test]
    fn no_terminal_size_panics(width in 1_u16..260, height in 1_u16..80, help in any::<bool>(), touching in 0_u32..60, waits in any::<bool>()) {
        let snapshot = if waits { testing::without_engine() } else { testing::snapshot() };
        let mut view = view(snapshot);
        view.help = help;
        view.snapshot.collisions = testing::collisions(touching, 5);
        view.scroll = 40;
        drawn(&mut view, width, height);
    }
}

#[test]
fn edges_with_jams_replace_the_collisions() {
    let mut view = view(testing::snapshot());
    view.shows_jams = true;
    let screen = drawn(&mut view, 80, 26);
    shows(
        &screen,
        &["edges with jams", "robots/h", "567", "456.0 s", "1,234", "2.5", "25 %", "8 dock 3"],
    );
    view.snapshot.jams = Some([].into());
    shows(&drawn(&mut view, 80, 24), &["No robot has waited."]);
    view.snapshot.jams = None;
    shows(&drawn(&mut view, 120, 24), &["start `regatta plugin traffic`"]);
}

/// The numbers on a screen.
fn numbers(screen: &str) -> BTreeSet<String> {
    let parts = screen.split(|c: char| !(c.is_ascii_digit() || ".,:-".contains(c)));
    let numbers = parts.map(|part| part.trim_matches(|c| ".,:-".contains(c)).to_owned());
    numbers.filter(|part| part.len() > 1).collect()
}

/// Returns a snapshot of long numbers.
fn of_long_numbers() -> Snapshot {
    let mut snapshot = testing::snapshot();
    let pairs: Vec<_> = (0..9)
        .map(|number| ContactRecord {
            robots: [1_000_014 + number, 1_000_814 + number],
            x: 14_214.2 + number as f32,
            y: -12_345.6 - number as f32,
            relative_speed: 14.2,
            ..snapshot.collisions.list[0]
        })
        .collect();
    snapshot.collisions.list = pairs.into();
    for (number, process) in snapshot.processes.iter_mut().enumerate() {
        process.name = format!("a-plugin-with-a-long-name-{number}");
        process.resident_bytes = 14_200_000_000;
        process.cpu_cores = 14.2;
    }
    if let Some(work) = &mut snapshot.work {
        work.robots = [142_857; Activity::COUNT];
        work.orders.finished = 14_285_714;
        work.orders.since_secs = Some(14_285.7);
        let times = [&mut work.orders.service, &mut work.orders.waiting];
        for time in times {
            (time.p50, time.p99, time.longest) = (14_285.0, 142_857.0, 1_428_571.0);
        }
    }
    if let Some(run) = &mut snapshot.run {
        (run.tick, run.late_ticks) = (14_285_714_285, 1_428_571);
        run.state_counts.by_state = [1_428_571; RobotState::COUNT];
    }
    snapshot
}

#[test]
fn no_number_is_cut() {
    let whole = numbers(&drawn(&mut view(of_long_numbers()), 400, 100));
    assert!(whole.contains("14214.2") && whole.contains("1,428,571"), "{whole:?}");
    for (width, height) in [(80, 24), (100, 30), (160, 50)] {
        let screen = drawn(&mut view(of_long_numbers()), width, height);
        let cut: Vec<_> = numbers(&screen).difference(&whole).cloned().collect();
        assert!(cut.is_empty(), "{cut:?} at {width} × {height}:\n{screen}");
    }
}
