//! The log: contacts that begin or end, and what becomes of the clock.

use regatta_messages::scene;
use regatta_messages::schema::foxglove::log::Level;
use regatta_plugin::contact::{ContactChange, ContactEvent, ContactLevel};
use regatta_plugin::frame::{ClockState, FrameHeader};

use crate::channel::Channel;
use crate::hub::Hub;

/// Contacts of a tick that are told one by one; the others are counted.
const MOST_LINES: usize = 20;

/// Tells what a frame says about the clock that the one before didn't.
pub(crate) fn tell_clock(hub: &Hub, before: &FrameHeader, now: &FrameHeader) {
    let nanos = now.sim_time_nanos;
    if before.run_id != now.run_id {
        let text = format!("run {:016x} with {} robots", now.run_id, now.robots);
        return publish(hub, Level::Info, "clock", text, nanos);
    }
    if before.clock != now.clock {
        let text = if now.clock == ClockState::Running as u32 { "running" } else { "paused" };
        publish(hub, Level::Info, "clock", text.to_owned(), nanos);
    }
    let late = now.late_ticks.saturating_sub(before.late_ticks);
    if late > 0 {
        publish(hub, Level::Warning, "clock", format!("late ticks: {late} more"), nanos);
    }
}

/// Tells the changes of contacts in a tick.
pub(crate) fn tell_contacts(hub: &Hub, events: &[ContactEvent]) {
    for event in events.iter().take(MOST_LINES) {
        let (level, text) = line(event);
        publish(hub, level, "collision", text, event.sim_time_nanos);
    }
    if let Some(more) = events.len().checked_sub(MOST_LINES).filter(|more| *more > 0) {
        let nanos = events[0].sim_time_nanos;
        publish(hub, Level::Warning, "collision", format!("and {more} more changes"), nanos);
    }
}

fn line(event: &ContactEvent) -> (Level, String) {
    let is_touching = event.level == ContactLevel::Touching as u32;
    let has_begun = event.change == ContactChange::Began as u32;
    let [one, other] = event.robots;
    let (x, y) = (event.x, event.y);
    let what = match (is_touching, has_begun) {
        (true, true) => "touch",
        (true, false) => "touch no more",
        (false, true) => "may touch",
        (false, false) => "are clear of each other",
    };
    let level = match (is_touching, has_begun) {
        (true, true) => Level::Error,
        (false, true) => Level::Warning,
        (_, false) => Level::Info,
    };
    (level, format!("robots {one} and {other} {what}, at ({x:.1}, {y:.1})"))
}

fn publish(hub: &Hub, level: Level, name: &str, text: String, nanos: u64) {
    hub.publish(Channel::Log, nanos, scene::log(level, name, text, nanos));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn contacts_are_told_with_robots_and_place() {
        let event = ContactEvent {
            robots: [3, 8],
            level: ContactLevel::Touching as u32,
            change: ContactChange::Began as u32,
            x: 1.25,
            y: -2.0,
            ..ContactEvent::default()
        };
        let told = line(&event);
        assert_eq!(told, (Level::Error, "robots 3 and 8 touch, at (1.2, -2.0)".to_owned()));
        let possible = ContactEvent { level: ContactLevel::Possible as u32, ..event };
        assert_eq!(line(&possible).0, Level::Warning);
        let ended = ContactEvent { change: ContactChange::Ended as u32, ..possible };
        assert_eq!(line(&ended).0, Level::Info);
    }
}
