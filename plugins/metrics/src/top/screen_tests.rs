use proptest::prelude::*;
use ratatui::Terminal;
use ratatui::backend::TestBackend;

use super::*;
use crate::histogram::{Measure, Spread};
use crate::snapshot::Lap;
use crate::testing;

fn spread(seconds: f64) -> Spread {
    let mut measure = Measure::default();
    measure.observe(seconds);
    measure.take_spread()
}

/// A view of a fleet that has run for a while.
fn view(snapshot: Snapshot) -> View {
    let mut view = View::new(&snapshot.fleet);
    for k in 0..200 {
        let cost = 50e-6 * (1.0 + (f64::from(k) * 0.3).sin());
        let lap = Lap { tick_cost: spread(cost), jitter: spread(2e-3), frame_age: spread(70e-6) };
        view.history.add(&lap, &snapshot);
    }
    view.snapshot = snapshot;
    view
}

/// The screen as text.
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
fn everything_is_seen_at_80_by_24() {
    let screen = drawn(&mut view(testing::snapshot()), 80, 24);
    shows(&screen, &["running", "×1", "t 20:34.56", "tick 123,456", "tick cost", "real time", "frame age", "█"]);
    shows(
        &screen,
        &["0.998 of ×1", "70 µs", "robots", "1,000", "driving", "812", "idle", "waiting", "held", "faulted"],
    );
    shows(&screen, &["late ticks", "2.00 ms", "mean speed", "1.23 m/s", "98.77 km", "12,345"]);
    shows(&screen, &["12 touching, 30 possible", "touching", "0 10000", "0.0, -1.5", "0.8", "4.6 s"]);
    shows(&screen, &["processes", "engine", "4000000", "12 %", "34 MB", "metrics"]);
    shows(&screen, &["space pause", "q quit"]);
}

#[test]
fn the_list_of_collisions_scrolls_to_its_end_and_no_further() {
    let mut view = view(testing::snapshot());
    view.scroll_by(10);
    let screen = drawn(&mut view, 80, 24);
    shows(&screen, &["10 10010", "possible"]);
    assert!(!screen.contains("9 10009"), "{screen}");
    view.scroll_by(isize::MAX);
    shows(&drawn(&mut view, 80, 24), &["41 10041"]);
    view.scroll_by(-1);
    let screen = drawn(&mut view, 80, 24);
    assert!(!screen.contains("41 10041"), "one line up is one line up:\n{screen}");
    view.snapshot.collisions = testing::collisions(1, 0);
    shows(&drawn(&mut view, 80, 24), &["0 10000"]);
    assert_eq!(view.scroll, 0);
}

#[test]
fn what_is_missing_is_told_with_what_to_do() {
    let mut lonely = view(testing::without_engine());
    shows(&drawn(&mut lonely, 80, 24), &["No engine runs the fleet 'default'", "regatta run ", "engine"]);
    lonely.process_error = Some("can't list processes".to_owned());
    shows(&drawn(&mut lonely, 80, 24), &["can't list processes"]);
    let mut unchecked = view(testing::snapshot());
    unchecked.snapshot.collisions = Collisions::default();
    shows(&drawn(&mut unchecked, 80, 24), &["Nobody checks", "regatta plugin"]);
    unchecked.snapshot.collisions = testing::collisions(0, 0);
    shows(&drawn(&mut unchecked, 80, 24), &["0 touching, 0 possible", "No robots touch"]);
    shows(&drawn(&mut unchecked, 60, 12), &["too small"]);
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
    fn no_size_of_a_terminal_panics(width in 1_u16..260, height in 1_u16..80, help in any::<bool>(), touching in 0_u32..60, waits in any::<bool>()) {
        let snapshot = if waits { testing::without_engine() } else { testing::snapshot() };
        let mut view = view(snapshot);
        view.help = help;
        view.snapshot.collisions = testing::collisions(touching, 5);
        view.scroll = 40;
        drawn(&mut view, width, height);
    }
}
