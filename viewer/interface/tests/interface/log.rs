//! The log and its alarms.

use super::*;

/// An entry about a robot.
fn entry(time: u64, kind: Kind, robot: u32, text: &str) -> Entry {
    let severity = Severity::Warning;
    Entry {
        time_nanos: time * 1_000_000_000,
        kind,
        severity,
        robot: Some(robot),
        place: Place::None,
        text: text.into(),
    }
}

#[test]
fn alarms_are_acknowledged_and_entries_filtered_and_jumped_to() {
    let mut fixture = Fixture::new(50);
    fixture.interface.settings.left = Some(LeftPanel::Log);
    let news = vec![
        (entry(3, Kind::Fault, 7, "robot 7 broke down"), AlarmChange::Begins(AlarmKey::Robot(7))),
        (entry(4, Kind::Stop, 9, "robot 9 stalls"), AlarmChange::None),
        (
            Entry {
                robot: None,
                place: Place::Edge(34),
                ..entry(5, Kind::Edge, 0, "edge 34 closed")
            },
            AlarmChange::None,
        ),
    ];
    fixture.interface.log().take(LogReport { news, ..LogReport::default() });
    let mut harness = harness(fixture);
    harness.get_by_label("1 alarm");
    harness.get_by_label("Log 1");
    harness.get_by_label("acknowledge robot 7").click();
    settle(&mut harness);
    assert_eq!(harness.state_mut().interface.log().unacknowledged(), 0);
    harness.get_by_label("1 alarm");
    let over =
        (entry(6, Kind::Fault, 7, "robot 7 repaired"), AlarmChange::Ends(AlarmKey::Robot(7)));
    harness
        .state_mut()
        .interface
        .log()
        .take(LogReport { news: vec![over], ..LogReport::default() });
    settle(&mut harness);
    harness.get_by_label("no alarms");
    harness.get_by_label_contains("robot 9 stalls").click();
    settle(&mut harness);
    assert_eq!(harness.state().interface.selection.item, Some(Item::Robot(9)));
    harness.get_by_label_contains("edge 34 closed").click();
    settle(&mut harness);
    assert_eq!(harness.state().interface.selection.item, Some(Item::Edge(0)));
    harness.get_by_label("text of entries").click();
    settle(&mut harness);
    harness.event(egui::Event::Text("#7".into()));
    settle(&mut harness);
    assert!(harness.query_by_label_contains("robot 9 stalls").is_none());
    harness.get_by_label_contains("robot 7 broke down");
}

#[test]
fn the_log_of_a_recording_jumps_to_its_marks() {
    let mut fixture = replay(1.0);
    fixture.interface.settings.left = Some(LeftPanel::Log);
    let mut harness = harness(fixture);
    harness.get_by_label("2 marks");
    harness.state_mut().recording.as_mut().expect("a recording").0.truncate(1);
    settle(&mut harness);
    harness.get_by_label("1 mark");
    harness.state_mut().recording = replay(1.0).recording;
    settle(&mut harness);
    harness.get_by_label_contains("robot 3 and 1 more broke down").click();
    settle(&mut harness);
    let sought =
        harness.state().requests().into_iter().find(|(kind, ..)| *kind == ControlKind::Seek);
    assert_eq!(sought.map(|(_, time, _)| time), Some(6_000_000_000));
    assert_eq!(harness.state().interface.selection.item, Some(Item::Robot(3)));
}

/// Nobody can do anything about them: they are those of the shown time.
#[test]
fn the_alarms_of_a_recording_go_when_they_are_over() {
    let mut fixture = replay(1.0);
    fixture.interface.settings.left = Some(LeftPanel::Log);
    let take = |fixture: &mut Fixture, change, is_replayed| {
        let news = vec![(entry(3, Kind::Fault, 7, "robot 7 is broken"), change)];
        fixture.interface.log().take(LogReport { news, is_replayed, ..LogReport::default() });
    };
    take(&mut fixture, AlarmChange::Begins(AlarmKey::Robot(7)), Some(true));
    let mut harness = harness(fixture);
    harness.get_by_label("1 alarm");
    harness.get_by_label_contains("robot 7\u{a0}is broken");
    assert!(harness.query_by_label("Acknowledge all").is_none());
    assert!(harness.query_by_label("acknowledge robot 7").is_none());
    take(harness.state_mut(), AlarmChange::Ends(AlarmKey::Robot(7)), None);
    settle(&mut harness);
    harness.get_by_label("no alarms");
}

#[test]
fn an_alarm_leaves_the_buttons_beside_its_tab_where_they_are() {
    let mut harness = harness(Fixture::new(50));
    let before = harness.get_by_label("Plots").rect();
    let news = vec![(
        entry(3, Kind::Fault, 7, "robot 7 broke down"),
        AlarmChange::Begins(AlarmKey::Robot(7)),
    )];
    harness.state_mut().interface.log().take(LogReport { news, ..LogReport::default() });
    settle(&mut harness);
    harness.get_by_label("Log 1");
    assert_eq!(harness.get_by_label("Plots").rect(), before);
}

#[test]
fn alarms_that_hold_come_first_and_are_not_displaced_by_those_that_are_over() {
    let mut fixture = Fixture::new(50);
    let log = fixture.interface.log();
    let take = |log: &mut FleetLog, news| log.take(LogReport { news, ..LogReport::default() });
    let begins = |time, robot| {
        (entry(time, Kind::Fault, robot, "broken"), AlarmChange::Begins(AlarmKey::Robot(robot)))
    };
    let ends = |robot| {
        (entry(5_000, Kind::Fault, robot, "repaired"), AlarmChange::Ends(AlarmKey::Robot(robot)))
    };
    let last = MAX_ALARMS as u32 - 1;
    take(log, (0..=last).map(|robot| begins(robot.into(), robot)).collect());
    take(log, (1..=last).map(ends).collect());
    log.acknowledge(Some(AlarmKey::Robot(0)));
    let keys = |log: &FleetLog| log.alarms().iter().map(|(key, _)| *key).collect::<Vec<_>>();
    assert_eq!(
        keys(log)[..3],
        [0, last, last - 1].map(AlarmKey::Robot),
        "also an acknowledged one that holds"
    );
    take(log, vec![begins(6_000, 7_000)]);
    assert_eq!(keys(log)[..3], [7_000, 0, last].map(AlarmKey::Robot));
    assert_eq!(
        keys(log).last(),
        Some(&AlarmKey::Robot(2)),
        "the oldest one that was over has made room"
    );
    assert_eq!(
        (keys(log).len(), log.losses()),
        (MAX_ALARMS, LogLosses { forgotten: 0, left_out: 1 })
    );
}

/// The fleet manager's, for example: the fleet has no event of it.
#[test]
fn refused_requests_are_told_and_stay_in_the_log() {
    let mut fixture = Fixture::new(50);
    fixture.interface.settings.left = Some(LeftPanel::Log);
    let text = "can't recall robot 7: it was not sent";
    fixture.interface.tell_refusal(UserCommand::Recall(7), text.into(), 5_000_000_000);
    fixture.interface.tell_refusal(
        UserCommand::Close(34),
        "can't close edge 34".into(),
        6_000_000_000,
    );
    let log = fixture.interface.log();
    assert!(
        log.entries()
            .iter()
            .all(|entry| entry.kind == Kind::Order && entry.severity == Severity::Warning)
    );
    assert!(log.alarms().is_empty());
    let mut harness = harness(fixture);
    harness.get_by_label(text);
    harness.get_by_label(&format!("00:05.00 {text}")).click();
    settle(&mut harness);
    assert_eq!(harness.state().interface.selection.item, Some(Item::Robot(7)));
    harness.get_by_label("00:06.00 can't close edge 34").click();
    settle(&mut harness);
    assert_eq!(harness.state().interface.selection.item, Some(Item::Edge(0)));
}
