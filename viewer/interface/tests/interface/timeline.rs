//! Recordings, the past of a live run, and notes.

use super::*;

#[test]
fn a_replay_has_its_files_name_and_no_slider_for_robots() {
    let mut harness = harness(replay(4.0));
    assert_eq!(
        harness.get_all_by_label("morning.mcap").count(),
        2,
        "in the top bar and at the timeline"
    );
    harness.get_by_label("recording");
    harness.get_by_label("00:00.00\u{a0}– 00:10.00");
    assert!(harness.query_by_label("robots").is_none(), "a replay would refuse another number");
    press(&mut harness, Key::K);
    harness.get_by_label("the number of robots of a recording can't be changed");
    assert_eq!(harness.state().requests(), []);
    harness.state_mut().recording = None;
    settle(&mut harness);
    harness.get_by_label("robots");
    assert!(harness.query_by_label("morning.mcap").is_none());
}

#[test]
fn the_bar_and_the_marks_go_to_times() {
    let mut harness = harness(replay(4.0));
    let bar = harness.get_by_label("Timeline").rect();
    harness.drag_at(bar.center());
    settle(&mut harness);
    harness.drop_at(bar.center());
    settle(&mut harness);
    let requests = harness.state().requests();
    let (kind, time, _) = requests[0];
    assert_eq!((kind, requests.len()), (ControlKind::Seek, 1), "{requests:?}");
    assert!(time.abs_diff(5_000_000_000) < 20_000_000, "the middle: {time}");
    harness.state_mut().actions.clear();
    press(&mut harness, Key::X);
    press(&mut harness, Key::Z);
    // The mark's frame is shown, which lies a little before the mark.
    harness.state_mut().recording.as_mut().expect("a recording").1 = 1.95;
    harness.get_by_label("Next mark").click();
    settle(&mut harness);
    press(&mut harness, Key::Comma);
    let seek = |time| (ControlKind::Seek, time, 0.0);
    let wanted = [
        seek(6_000_000_000),
        seek(2_000_000_000),
        seek(6_000_000_000),
        (ControlKind::Pause, 0, 0.0),
        seek(1_949_999_999),
    ];
    let requests = harness.state().requests();
    assert!(
        requests
            .iter()
            .zip(wanted)
            .all(|(one, other)| one.0 == other.0 && one.1.abs_diff(other.1) < 200),
        "{requests:?}"
    );
    assert_eq!(requests.len(), wanted.len());
}

#[test]
fn a_part_is_repeated_until_it_is_ended() {
    let mut harness = harness(replay(3.0));
    let go = |harness: &mut Harness<'_, Fixture>, now, run| {
        harness.state_mut().recording.as_mut().expect("a recording").1 = now;
        harness.state_mut().header.run_id = run;
        settle(harness);
    };
    press(&mut harness, Key::Y);
    go(&mut harness, 5.0, 1);
    press(&mut harness, Key::Y);
    settle(&mut harness);
    let back = (ControlKind::Seek, 3_000_000_000, 0.0);
    assert_eq!(harness.state().requests(), [back], "once, although many pictures were drawn");
    go(&mut harness, 3.0, 2);
    assert_eq!(harness.state().requests(), [back]);
    go(&mut harness, 5.1, 2);
    assert_eq!(harness.state().requests(), [back, back]);
    // Whoever goes elsewhere stays there.
    go(&mut harness, 8.0, 3);
    assert_eq!(harness.state().requests(), [back, back]);
    harness.get_by_label("end the loop").click();
    settle(&mut harness);
    go(&mut harness, 5.2, 3);
    assert_eq!(harness.state().requests(), [back, back]);
}

#[test]
fn a_part_that_is_chosen_while_the_clock_stands_is_repeated_when_it_runs() {
    let mut fixture = replay(3.0);
    let clock = |fixture: &mut Fixture, engine, clock: ClockState| {
        (fixture.engine, fixture.header.clock) = (engine, clock as u32);
    };
    clock(&mut fixture, EngineState::Paused, ClockState::Paused);
    let mut harness = harness(fixture);
    press(&mut harness, Key::Y);
    harness.state_mut().recording.as_mut().expect("a recording").1 = 5.0;
    settle(&mut harness);
    press(&mut harness, Key::Y);
    settle(&mut harness);
    assert!(harness.state().requests().is_empty(), "the clock stands");
    clock(harness.state_mut(), EngineState::Running, ClockState::Running);
    settle(&mut harness);
    assert_eq!(harness.state().requests(), [(ControlKind::Seek, 3_000_000_000, 0.0)]);
}

#[test]
fn at_its_end_a_recording_is_played_again_and_a_fleet_that_has_ended_is_greyed() {
    let mut fixture = replay(10.0);
    (fixture.engine, fixture.header.clock) = (EngineState::Paused, ClockState::Paused as u32);
    let mut harness = harness(fixture);
    press(&mut harness, Key::Space);
    assert_eq!(
        harness.state().requests(),
        [(ControlKind::Seek, 0, 0.0), (ControlKind::Resume, 0, 0.0)]
    );
    assert!(harness.query_by_label("The replay has ended").is_none());
    harness.state_mut().engine = EngineState::Gone;
    settle(&mut harness);
    harness.get_by_label("The replay has ended");
    harness.state_mut().recording = None;
    settle(&mut harness);
    harness.get_by_label("The engine has ended");
    harness.get_by_label(
        "this is its last picture, at 01:23.46; the next engine is shown as soon as it runs",
    );
}

#[test]
fn the_past_of_a_live_run_is_looked_at_and_left() {
    let mut harness = harness(Fixture::new(5));
    assert!(harness.query_by_label("Timeline").is_none(), "the bar has to be asked for");
    press(&mut harness, Key::U);
    harness.get_by_label_contains("of the run are kept: ten minutes, or less of a large fleet.");
    let bar = harness.get_by_label("Timeline").rect();
    harness.drag_at(bar.center());
    settle(&mut harness);
    harness.drop_at(bar.center());
    settle(&mut harness);
    let looked = |harness: &Harness<'_, Fixture>| match harness.state().actions.last() {
        Some(Action::LookBack(time)) => *time,
        other => panic!("{other:?}"),
    };
    assert!(
        looked(&harness).is_some_and(|time| time.abs_diff(78_456_000_000) < 20_000_000),
        "{:?}",
        looked(&harness)
    );
    assert_eq!(harness.state().requests(), [], "the engine isn't asked for anything");
    harness.state_mut().is_past = true;
    harness.state_mut().interface.settings.right = Some(RightPanel::Selection);
    harness.state_mut().interface.select(Some(Item::Robot(3)));
    settle(&mut harness);
    harness.get_by_label_contains("Of the past, only poses, states and activities");
    harness.state_mut().interface.select(None);
    harness.state_mut().interface.settings.right = None;
    settle(&mut harness);
    harness.get_by_label("past");
    harness.get_by_label("robots");
    harness.get_by_label("back to live").click();
    settle(&mut harness);
    assert_eq!(looked(&harness), None);
    press(&mut harness, Key::Comma);
    assert_eq!(looked(&harness), Some(83_455_999_999), "before the shown frame");
}

/// Returns the commands that were given.
#[test]
fn notes_of_a_live_run_are_marks_that_are_gone_to() {
    let mut harness = harness(Fixture::new(5));
    harness.key_press_modifiers(Modifiers::SHIFT, Key::N);
    settle(&mut harness);
    harness.event(egui::Event::Text("jam at dock 1".into()));
    settle(&mut harness);
    press(&mut harness, Key::Enter);
    harness.get_by_label("jam at dock 1");
    let note = harness.state().header.sim_time_nanos;
    // Five seconds later.
    harness.state_mut().header.sim_time_nanos += 5_000_000_000;
    settle(&mut harness);
    harness.get_by_label("Previous mark").click();
    settle(&mut harness);
    assert_eq!(harness.state().actions, [Action::LookBack(Some(note))]);
    harness.state_mut().actions.clear();
    (harness.state_mut().is_past, harness.state_mut().header.sim_time_nanos) =
        (true, note - 1_000_000_000);
    settle(&mut harness);
    assert!(harness.query_by_label("jam at dock 1").is_none(), "before the note");
    // The times of the fixture end with its frame.
    harness.state_mut().header.sim_time_nanos = note;
    press(&mut harness, Key::Z);
    assert!(harness.state().actions.is_empty(), "there is none before it");
    harness.get_by_label("no mark before this");
    harness.state_mut().header.run_id = 2;
    settle(&mut harness);
    assert!(harness.query_by_label("jam at dock 1").is_none(), "another run has other notes");
}

#[test]
fn a_note_of_a_recording_is_written_and_escape_drops_one() {
    let mut harness = harness(replay(3.0));
    harness.get_by_label("note").click();
    settle(&mut harness);
    harness.event(egui::Event::Text(" they meet  here".into()));
    settle(&mut harness);
    assert!(
        harness.state().requests().is_empty(),
        "letters typed into a field trigger no shortcuts"
    );
    press(&mut harness, Key::Enter);
    let written = Action::Note { time: 3_000_000_000, text: "they meet  here".to_owned() };
    assert_eq!(harness.state().actions, [written]);
    harness.state_mut().actions.clear();
    for key in [Key::Escape, Key::Enter] {
        harness.key_press_modifiers(Modifiers::SHIFT, Key::N);
        settle(&mut harness);
        harness.get_by_label("text of the note");
        if key == Key::Escape {
            harness.event(egui::Event::Text("never mind".into()));
            settle(&mut harness);
        }
        press(&mut harness, key);
        assert!(harness.query_by_label("text of the note").is_none(), "{key:?}");
    }
    assert!(
        harness.state().actions.is_empty(),
        "neither one that was dropped, nor one without a text"
    );
}
