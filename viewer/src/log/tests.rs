//! The bounds of the log, its alarms and its filter.

use regatta_interface::log::*;
use regatta_plugin::contact::{ContactChange, ContactEvent, ContactLevel};
use regatta_plugin::event::{EventKind, EventRecord, Refusal};
use regatta_plugin::order::NO_ROBOT;

use super::entries::{of_contact, of_event};
use super::health::about_fleet;
use super::{MOST_OF_A_KIND, thin_out};

fn event(kind: EventKind, robot: u32) -> (Entry, AlarmChange) {
    of_event(&EventRecord { kind: kind as u32, robot, id: 5, ..EventRecord::default() }, 7)
        .expect("an entry")
}

fn log(news: Vec<(Entry, AlarmChange)>) -> FleetLog {
    let mut log = FleetLog::default();
    log.take(LogReport { news, ..LogReport::default() });
    log
}

#[test]
fn an_alarm_stays_until_it_is_acknowledged_and_over() {
    let mut log = log(vec![event(EventKind::BrokenDown, 3), event(EventKind::BrokenDown, 4)]);
    assert_eq!((log.alarms().len(), log.unacknowledged()), (2, 2));
    log.take(LogReport { news: vec![event(EventKind::Repaired, 3)], ..LogReport::default() });
    assert!(
        log.alarms().iter().any(|(key, alarm)| *key == AlarmKey::Robot(3) && !alarm.is_active),
        "it was missed"
    );
    log.acknowledge(Some(AlarmKey::Robot(3)));
    log.acknowledge(Some(AlarmKey::Robot(4)));
    assert_eq!((log.alarms().len(), log.unacknowledged()), (1, 0), "robot 4 is still broken");
    log.take(LogReport { news: vec![event(EventKind::Repaired, 4)], ..LogReport::default() });
    assert!(log.alarms().is_empty() && log.entries().len() == 4);
    log.take(LogReport { news: vec![event(EventKind::BrokenDown, 4)], ..LogReport::default() });
    assert_eq!(log.unacknowledged(), 1, "it broke again");
    log.take(LogReport { is_new_run: true, ..LogReport::default() });
    assert!(log.alarms().is_empty() && log.entries().is_empty());
}

#[test]
fn entries_and_alarms_are_bounded() {
    let robots = (MAX_ENTRIES + 10) as u32;
    let log = log((0..robots).map(|robot| event(EventKind::BrokenDown, robot)).collect());
    assert_eq!((log.entries().len(), log.alarms().len()), (MAX_ENTRIES, MAX_ALARMS));
    let left_out = u64::from(robots) - MAX_ALARMS as u64;
    assert_eq!(log.losses(), LogLosses { forgotten: 10, left_out });
    assert_eq!(log.entries()[0].robot, Some(10), "the oldest are forgotten");
}

#[test]
fn entries_are_filtered_by_kind_robot_and_text() {
    let (broken, closed) =
        (event(EventKind::BrokenDown, 31).0, event(EventKind::EdgeClosed, NO_ROBOT).0);
    assert_eq!(
        (closed.robot, closed.place, closed.text.as_str()),
        (None, Place::Edge(5), "edge 5 closed")
    );
    let shows = |kind, text: &str| {
        let filter = LogFilter { kind, text: text.into() };
        [filter.shows(&broken), filter.shows(&closed)]
    };
    assert_eq!(shows(None, ""), [true, true]);
    assert_eq!(shows(Some(Kind::Edge), ""), [false, true]);
    assert_eq!(shows(None, " #31"), [true, false]);
    assert_eq!(shows(None, "#3"), [false, false], "the whole number");
    assert_eq!(shows(None, "CLOSED"), [false, true]);
    assert!(
        of_event(&EventRecord { kind: EventKind::ReachedNode as u32, ..EventRecord::default() }, 0)
            .is_none()
    );
}

#[test]
fn a_refusal_tells_its_reason() {
    let refused = |robot| {
        let detail = Refusal::EdgeClosed as u32;
        let kind = EventKind::Refused as u32;
        let event = EventRecord { kind, robot, id: 9, detail, ..EventRecord::default() };
        of_event(&event, 7).expect("an entry").0.text
    };
    assert_eq!(refused(5), "robot 5: command refused: edge 9 is closed");
    assert_eq!(refused(NO_ROBOT), "a command was refused: edge 9 is closed");
}

#[test]
fn only_robots_that_touch_are_an_alarm() {
    let contact = |level: ContactLevel, change: ContactChange| ContactEvent {
        robots: [2, 9],
        level: level as u32,
        change: change as u32,
        x: 4.0,
        ..ContactEvent::default()
    };
    assert!(of_contact(&contact(ContactLevel::Possible, ContactChange::Began)).is_none());
    let (entry, change) =
        of_contact(&contact(ContactLevel::Touching, ContactChange::Began)).expect("an entry");
    assert_eq!(
        (entry.place, change),
        (Place::At { x: 4.0, y: 0.0 }, AlarmChange::Begins(AlarmKey::Contact([2, 9])))
    );
    let (_, change) =
        of_contact(&contact(ContactLevel::Touching, ContactChange::Ended)).expect("an entry");
    assert_eq!(change, AlarmChange::Ends(AlarmKey::Contact([2, 9])));
}

#[test]
fn many_entries_at_once_are_counted() {
    let entry = |number: usize| {
        (about_fleet(number as u64, Severity::Info, String::new()), AlarmChange::None)
    };
    let mut news: Vec<_> = (0..1_000).map(entry).collect();
    news[900].1 = AlarmChange::Begins(AlarmKey::Standstill);
    thin_out(&mut news);
    assert_eq!(news.len(), MOST_OF_A_KIND + 2, "an alarm is never left out");
    assert!(
        news.last().is_some_and(|(entry, _)| entry.text.starts_with("800 more")),
        "{:?}",
        news.last()
    );
}
