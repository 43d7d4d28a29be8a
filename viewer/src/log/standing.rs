//! Alarms that hold now, even if their beginning was missed. They are found by comparing the state
//! of the fleet with its events.

use std::collections::BTreeMap;

use regatta_interface::log::{AlarmChange, AlarmKey, Entry, Kind, Place, Severity};
use regatta_plugin::contact::{ContactLevel, ContactRecord};
use regatta_plugin::frame::{Frame, RobotState};
use regatta_plugin::{
    ClosureReader, ContactReader, Participant, ReadError, RecordingReader, Result,
};

/// The known alarms of robots, contacts and edges.
#[derive(Clone, Debug, Default)]
pub(super) struct Standing(BTreeMap<AlarmKey, Told>);

/// The last report of an alarm.
#[derive(Clone, Copy, Debug)]
struct Told {
    is_active: bool,
    tick: u64,
}

/// The reason why the beginning of an alarm wasn't seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Unseen {
    /// It began before this window opened.
    Opened,
    /// Its events were missed.
    Missed,
    /// A jump in a recording left it out.
    Jumped,
}

/// Readers of the current state, beside the frame.
#[derive(Debug)]
pub(super) struct Now {
    contacts: ContactReader,
    closures: ClosureReader,
    recording: RecordingReader,
    is_replayed: bool,
}

impl Unseen {
    /// Returns a remark for the user.
    fn remark(self) -> &'static str {
        match self {
            Self::Opened => "since before this window opened",
            Self::Missed => "the start was missed",
            Self::Jumped => "since before the shown time",
        }
    }
}

impl Standing {
    /// Takes the change that an event of a tick reports.
    pub fn tell(&mut self, change: AlarmChange, tick: u64) {
        let (key, is_active) = match change {
            AlarmChange::Begins(key) => (key, true),
            AlarmChange::Ends(key) => (key, false),
            AlarmChange::None => return,
        };
        if matches!(key, AlarmKey::Robot(_) | AlarmKey::Contact(_) | AlarmKey::Edge(_)) {
            self.0.insert(key, Told { is_active, tick });
        }
    }

    /// Compares the alarms of a kind with those that hold at a tick, which are sorted. Returns the
    /// changes that no event has reported. Events of that tick and later ones take precedence,
    /// because the state may be older.
    pub fn compare(
        &mut self,
        is_kind: fn(&AlarmKey) -> bool,
        holding: &[AlarmKey],
        tick: u64,
    ) -> Vec<AlarmChange> {
        let is_older = |told: &Told| told.tick < tick;
        let is_untold =
            |key: &&AlarmKey| self.0.get(key).is_none_or(|told| !told.is_active && is_older(told));
        let begun = holding.iter().filter(is_untold).copied().map(AlarmChange::Begins);
        let known =
            self.0.iter().filter(|(key, told)| is_kind(key) && told.is_active && is_older(told));
        let over = known
            .map(|(key, _)| *key)
            .filter(|key| holding.binary_search(key).is_err())
            .map(AlarmChange::Ends);
        let changes: Vec<_> = begun.chain(over).collect();
        self.0.retain(|key, told| !is_kind(key) || told.is_active || !is_older(told));
        for change in &changes {
            self.tell(*change, tick);
        }
        changes
    }
}

fn is_robot(key: &AlarmKey) -> bool {
    matches!(key, AlarmKey::Robot(_))
}

fn is_contact(key: &AlarmKey) -> bool {
    matches!(key, AlarmKey::Contact(_))
}

fn is_edge(key: &AlarmKey) -> bool {
    matches!(key, AlarmKey::Edge(_))
}

/// The alarms of robots that are broken or can't continue, sorted.
pub(super) fn robots(frame: &Frame<'_>) -> Vec<AlarmKey> {
    let out = [RobotState::Broken as u8, RobotState::Faulted as u8];
    let robots = (0..).zip(frame.columns().state).filter(|(_, state)| out.contains(state));
    robots.map(|(robot, _)| AlarmKey::Robot(robot)).collect()
}

/// The alarms of robots that touch, sorted.
pub(super) fn contacts(pairs: &[ContactRecord]) -> Vec<AlarmKey> {
    let touching = pairs.iter().filter(|pair| pair.level == ContactLevel::Touching as u32);
    let mut keys: Vec<_> = touching.map(|pair| AlarmKey::Contact(pair.robots)).collect();
    keys.sort_unstable();
    keys
}

/// Returns the entry of a robot's change that no event has reported, seen at a simulated time in
/// nanoseconds.
pub(super) fn robot_entry(change: AlarmChange, frame: &Frame<'_>, unseen: Unseen) -> Option<Entry> {
    let (AlarmChange::Begins(AlarmKey::Robot(robot)) | AlarmChange::Ends(AlarmKey::Robot(robot))) =
        change
    else {
        return None;
    };
    let text = match (change, frame.state_of(robot as usize)) {
        (AlarmChange::Begins(_), RobotState::Faulted) => {
            format!("robot {robot} can't continue, {}", unseen.remark())
        }
        (AlarmChange::Begins(_), _) => format!("robot {robot} is broken, {}", unseen.remark()),
        _ => format!("robot {robot} can drive again"),
    };
    let entry = seen(change, frame.header().sim_time_nanos, Kind::Fault, Severity::Alarm);
    Some(Entry { robot: Some(robot), text, ..entry })
}

/// Returns the entry of a contact that no event has reported. Its start is known.
pub(super) fn contact_entry(
    change: AlarmChange,
    pairs: &[ContactRecord],
    now_nanos: u64,
) -> Option<Entry> {
    let (AlarmChange::Begins(AlarmKey::Contact(robots))
    | AlarmChange::Ends(AlarmKey::Contact(robots))) = change
    else {
        return None;
    };
    let [one, other] = robots;
    let pair =
        pairs.iter().find(|pair| pair.robots == robots && matches!(change, AlarmChange::Begins(_)));
    let text = match pair {
        Some(_) => format!("robots {one} and {other} touch"),
        None => format!("robots {one} and {other} are apart again"),
    };
    let time = pair.map_or(now_nanos, |pair| pair.since_nanos);
    let place = pair.map_or(Place::None, |pair| Place::At { x: pair.x, y: pair.y });
    Some(Entry {
        robot: Some(one),
        place,
        text,
        ..seen(change, time, Kind::Contact, Severity::Alarm)
    })
}

/// Returns the entry of an edge's change that no event has reported, seen at a simulated time in
/// nanoseconds.
pub(super) fn edge_entry(change: AlarmChange, now_nanos: u64, unseen: Unseen) -> Option<Entry> {
    let (AlarmChange::Begins(AlarmKey::Edge(id)) | AlarmChange::Ends(AlarmKey::Edge(id))) = change
    else {
        return None;
    };
    let text = match change {
        AlarmChange::Begins(_) => format!("edge {id} is closed, {}", unseen.remark()),
        _ => format!("edge {id} is open"),
    };
    Some(Entry {
        place: Place::Edge(id),
        text,
        ..seen(change, now_nanos, Kind::Edge, Severity::Warning)
    })
}

fn seen(change: AlarmChange, time_nanos: u64, kind: Kind, severity: Severity) -> Entry {
    let severity = if matches!(change, AlarmChange::Begins(_)) { severity } else { Severity::Info };
    Entry { time_nanos, kind, severity, robot: None, place: Place::None, text: String::new() }
}

impl Now {
    /// Opens the ports of a fleet.
    ///
    /// # Errors
    /// If the fleet can't be read.
    pub fn open(participant: &Participant) -> Result<Self> {
        Ok(Self {
            contacts: ContactReader::open_on(participant)?,
            closures: ClosureReader::open_on(participant)?,
            recording: RecordingReader::open_on(participant)?,
            is_replayed: false,
        })
    }

    /// Takes the newest.
    ///
    /// # Errors
    /// [`ReadError`] if the fleet can't be read.
    pub fn update(&mut self) -> Result<(), ReadError> {
        self.contacts.latest()?;
        self.closures.take()?;
        self.recording.take().map(drop)
    }

    /// Returns whether a recording is replayed in a run, if that has changed.
    pub fn change_of_replay(&mut self, run_id: u64) -> Option<bool> {
        let is_replayed =
            self.recording.current().is_some_and(|recording| recording.header.run_id == run_id);
        (std::mem::replace(&mut self.is_replayed, is_replayed) != is_replayed)
            .then_some(is_replayed)
    }

    /// Whether a recording is replayed.
    pub fn is_replayed(&self) -> bool {
        self.is_replayed
    }

    /// Returns the alarms that have begun or ended without an event.
    pub fn compare(
        &self,
        standing: &mut Standing,
        frame: &Frame<'_>,
        unseen: Unseen,
    ) -> Vec<(Entry, AlarmChange)> {
        let (run, tick, time) = (frame.run_id(), frame.tick(), frame.header().sim_time_nanos);
        let mut news = Vec::new();
        for change in standing.compare(is_robot, &robots(frame), tick) {
            news.extend(robot_entry(change, frame, unseen).map(|entry| (entry, change)));
        }
        if let Some(list) = self.contacts.current().filter(|list| list.header.run_id == run) {
            for change in standing.compare(is_contact, &contacts(list.pairs), list.header.tick) {
                let entry = contact_entry(change, list.pairs, list.header.sim_time_nanos);
                news.extend(entry.map(|entry| (entry, change)));
            }
        }
        let closed: Vec<_> =
            self.closures.closed(run).iter().map(|closed| AlarmKey::Edge(closed.edge)).collect();
        for change in standing.compare(is_edge, &closed, tick) {
            news.extend(edge_entry(change, time, unseen).map(|entry| (entry, change)));
        }
        news
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use AlarmChange::{Begins, Ends};

    const BROKEN: AlarmKey = AlarmKey::Robot(7);

    #[test]
    fn what_holds_without_having_been_told_is_told_once() {
        let mut standing = Standing::default();
        standing.tell(Begins(AlarmKey::Edge(7)), 1);
        assert_eq!(standing.compare(is_robot, &[BROKEN], 10), [Begins(BROKEN)]);
        assert!(standing.compare(is_robot, &[BROKEN], 20).is_empty());
        assert_eq!(
            standing.compare(is_robot, &[], 30),
            [Ends(BROKEN)],
            "its repair was missed; the edge is another matter"
        );
        assert!(standing.compare(is_robot, &[], 40).is_empty());
        assert_eq!(standing.compare(is_edge, &[], 50), [Ends(AlarmKey::Edge(7))]);
    }

    /// Events come before the frame of their tick.
    #[test]
    fn an_event_is_believed_until_a_later_frame_is_seen() {
        let mut standing = Standing::default();
        standing.tell(Begins(BROKEN), 10);
        assert!(
            standing.compare(is_robot, &[], 9).is_empty()
                && standing.compare(is_robot, &[], 10).is_empty()
        );
        assert!(standing.compare(is_robot, &[BROKEN], 11).is_empty());
        standing.tell(Ends(BROKEN), 20);
        assert!(standing.compare(is_robot, &[BROKEN], 19).is_empty());
        assert_eq!(
            standing.compare(is_robot, &[BROKEN], 21),
            [Begins(BROKEN)],
            "it broke again, and nobody told"
        );
    }
}
