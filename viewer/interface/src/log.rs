//! The log of a fleet: events of robots, edges and the fleet manager, and alarms to acknowledge.
//! Its size is limited.

use std::collections::{BTreeMap, VecDeque};

use regatta_plugin::recording::{MarkKind, RecordingMark};

use crate::text::thousands;

/// The maximum number of kept entries, about 2 MB. The oldest are dropped.
pub const MAX_ENTRIES: usize = 10_000;
/// The largest number of kept alarms. Further alarms replace those that are over, or become only
/// entries and are counted.
pub const MAX_ALARMS: usize = 1_000;

/// The kind of an entry.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// Breakdowns, faults and repairs.
    Fault,
    /// Holds, stalls and their ends.
    Stop,
    /// Robots that touch.
    Contact,
    /// Failed transport orders, and refused commands.
    Order,
    /// Edges that were closed or opened.
    Edge,
    /// Robots that came or went.
    Robot,
    /// The fleet manager, and standstills.
    Fleet,
    /// Notes in a recording.
    Note,
}

/// The severity of an entry.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// Good to know.
    Info,
    /// Something is slower than it should be.
    Warning,
    /// The user has to look.
    Alarm,
}

/// The place of an entry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Place {
    /// The place of the robot, or none.
    None,
    /// An edge, by id.
    Edge(u32),
    /// A place on the ground.
    At {
        /// Metres east.
        x: f32,
        /// Metres north.
        y: f32,
    },
}

impl Kind {
    /// All kinds.
    pub const ALL: [Self; 8] = [
        Self::Fault,
        Self::Stop,
        Self::Contact,
        Self::Order,
        Self::Edge,
        Self::Robot,
        Self::Fleet,
        Self::Note,
    ];

    /// The name, for the user.
    pub fn name(self) -> &'static str {
        match self {
            Self::Fault => "faults",
            Self::Stop => "stops",
            Self::Contact => "contacts",
            Self::Order => "orders",
            Self::Edge => "edges",
            Self::Robot => "robots",
            Self::Fleet => "fleet",
            Self::Note => "notes",
        }
    }
}

/// Something that happened.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// Simulated time in nanoseconds.
    pub time_nanos: u64,
    /// The kind.
    pub kind: Kind,
    /// The severity.
    pub severity: Severity,
    /// The robot, or the first of several.
    pub robot: Option<u32>,
    /// The place.
    pub place: Place,
    /// The text for the user.
    pub text: String,
}

/// The cause of an alarm: a robot that breaks down again is the same alarm.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum AlarmKey {
    /// A robot is broken, or can't continue.
    Robot(u32),
    /// Two robots touch.
    Contact([u32; 2]),
    /// An edge is closed, by its id.
    Edge(u32),
    /// No robot moves.
    Standstill,
    /// The fleet manager is silent.
    Manager,
}

/// An alarm. It stays until it is acknowledged and over; in a recording, until it is over.
#[derive(Clone, Debug, PartialEq)]
pub struct Alarm {
    /// The entry that began it.
    pub entry: Entry,
    /// Whether the alarm still holds.
    pub is_active: bool,
    /// Whether a user has acknowledged it.
    pub is_acknowledged: bool,
}

/// The effect of an entry on alarms.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AlarmChange {
    /// Nothing.
    None,
    /// An alarm begins.
    Begins(AlarmKey),
    /// It ends.
    Ends(AlarmKey),
}

/// The news for the log.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LogReport {
    /// Whether another run has begun. Previous entries belong to the old run.
    pub is_new_run: bool,
    /// Whether a fleet manager steers the robots, if that has changed.
    pub is_managed: Option<bool>,
    /// Whether a recording is replayed, if that has changed.
    pub is_replayed: Option<bool>,
    /// The entries in order, with their effects on alarms.
    pub news: Vec<(Entry, AlarmChange)>,
}

/// The numbers of entries and alarms that are not kept.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LogLosses {
    /// Entries that were forgotten.
    pub forgotten: u64,
    /// Alarms that there was no room for.
    pub left_out: u64,
}

/// The entries and the alarms of a fleet.
#[derive(Clone, Debug, Default)]
pub struct FleetLog {
    entries: VecDeque<Entry>,
    alarms: BTreeMap<AlarmKey, Alarm>,
    losses: LogLosses,
    /// Whether a fleet manager steers the robots.
    is_managed: bool,
    /// Whether a recording is replayed, whose alarms need no acknowledgement.
    is_replayed: bool,
    /// Counts the changes.
    revision: u64,
}

impl FleetLog {
    /// Takes the report of the thread.
    pub fn take(&mut self, report: LogReport) {
        if report.is_new_run {
            *self =
                Self { revision: self.revision, is_replayed: self.is_replayed, ..Self::default() };
        }
        self.is_replayed = report.is_replayed.unwrap_or(self.is_replayed);
        self.is_managed = report.is_managed.unwrap_or(self.is_managed);
        for (entry, change) in report.news {
            self.change(&entry, change);
            self.entries.push_back(entry);
        }
        let surplus = self.entries.len().saturating_sub(MAX_ENTRIES);
        self.entries.drain(..surplus);
        self.losses.forgotten += surplus as u64;
        self.revision += 1;
    }

    fn change(&mut self, entry: &Entry, change: AlarmChange) {
        match change {
            AlarmChange::None => {}
            AlarmChange::Begins(key) if !self.has_room(key) => self.losses.left_out += 1,
            AlarmChange::Begins(key) => {
                let alarm = Alarm { entry: entry.clone(), is_active: true, is_acknowledged: false };
                self.alarms.insert(key, alarm);
            }
            AlarmChange::Ends(key) => {
                if let Some(alarm) = self.alarms.get_mut(&key) {
                    alarm.is_active = false;
                    if alarm.is_acknowledged || self.is_replayed {
                        self.alarms.remove(&key);
                    }
                }
            }
        }
    }

    /// Whether there is room for an alarm. The oldest one that is over makes room for it.
    fn has_room(&mut self, key: AlarmKey) -> bool {
        if self.alarms.len() < MAX_ALARMS || self.alarms.contains_key(&key) {
            return true;
        }
        let over = self.alarms.iter().filter(|(_, alarm)| !alarm.is_active);
        let Some(oldest) =
            over.min_by_key(|(_, alarm)| alarm.entry.time_nanos).map(|(key, _)| *key)
        else {
            return false;
        };
        self.losses.left_out += 1;
        self.alarms.remove(&oldest).is_some()
    }

    /// Acknowledges an alarm, or with `None` all. Those that are over disappear.
    pub fn acknowledge(&mut self, key: Option<AlarmKey>) {
        for (other, alarm) in &mut self.alarms {
            alarm.is_acknowledged |= key.is_none_or(|key| key == *other);
        }
        self.alarms.retain(|_, alarm| alarm.is_active || !alarm.is_acknowledged);
        self.revision += 1;
    }

    /// The entries, the oldest first.
    pub fn entries(&self) -> &VecDeque<Entry> {
        &self.entries
    }

    /// The alarms: first those that hold, then those that are over but not acknowledged; the newest
    /// of each first.
    pub fn alarms(&self) -> Vec<(AlarmKey, &Alarm)> {
        let mut alarms: Vec<_> = self.alarms.iter().map(|(key, alarm)| (*key, alarm)).collect();
        alarms.sort_by_key(|(_, alarm)| {
            (!alarm.is_active, core::cmp::Reverse(alarm.entry.time_nanos))
        });
        alarms
    }

    /// The number of unacknowledged alarms.
    pub fn unacknowledged(&self) -> usize {
        self.alarms.values().filter(|alarm| !alarm.is_acknowledged).count()
    }

    /// The numbers of dropped entries and alarms.
    pub fn losses(&self) -> LogLosses {
        self.losses
    }

    /// Whether a fleet manager steers the robots.
    pub fn is_managed(&self) -> bool {
        self.is_managed
    }

    /// A number that changes with the contents.
    pub fn revision(&self) -> u64 {
        self.revision
    }
}

/// The conditions that shown entries meet.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LogFilter {
    /// Only this kind.
    pub kind: Option<Kind>,
    /// Only those whose texts contain this, whatever the case; `#7` is robot 7.
    pub text: String,
}

impl LogFilter {
    /// Whether an entry is shown.
    pub fn shows(&self, entry: &Entry) -> bool {
        let text = self.text.trim().to_lowercase();
        let is_found = match text.strip_prefix('#').map(str::parse::<u32>) {
            Some(robot) => robot.is_ok_and(|robot| entry.robot == Some(robot)),
            None => entry.text.to_lowercase().contains(&text),
        };
        is_found && self.kind.is_none_or(|kind| kind == entry.kind)
    }
}

/// An entry that stands for itself and for those right before it that differ in numbers alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Repeated {
    /// The place of the newest of them in the log.
    pub place: usize,
    /// The number of the others.
    pub more: u32,
}

/// Returns the entries that a filter shows, the newest first. Repeats are put together, so that an
/// entry of another kind is seen among many; a filter by text shows each.
pub fn repeated(entries: &VecDeque<Entry>, filter: &LogFilter) -> Vec<Repeated> {
    let mut shown: Vec<Repeated> = Vec::new();
    for (place, entry) in entries.iter().enumerate().rev().filter(|(_, entry)| filter.shows(entry))
    {
        match shown.last_mut() {
            Some(last) if filter.text.is_empty() && is_repeat(&entries[last.place], entry) => {
                last.more += 1;
            }
            _ => shown.push(Repeated { place, more: 0 }),
        }
    }
    shown
}

/// Whether two entries differ in times, places and numbers alone.
fn is_repeat(one: &Entry, other: &Entry) -> bool {
    one.kind == other.kind
        && one.severity == other.severity
        && without_numbers(&one.text).eq(without_numbers(&other.text))
}

fn without_numbers(text: &str) -> impl Iterator<Item = char> {
    text.chars().filter(|letter| !letter.is_ascii_digit())
}

/// Returns the entry of a mark of a recording.
pub fn of_mark(mark: &RecordingMark) -> Option<Entry> {
    let (robot, count) = (mark.robot, mark.count);
    let more = if count > 1 {
        format!(" and {} more", thousands(u64::from(count) - 1))
    } else {
        String::new()
    };
    let (kind, severity, text) = match mark.kind()? {
        MarkKind::Contact => {
            (Kind::Contact, Severity::Alarm, format!("robot {robot} touches another{more}"))
        }
        MarkKind::Fault => {
            (Kind::Fault, Severity::Alarm, format!("robot {robot}{more} broke down"))
        }
        MarkKind::Stop => (Kind::Stop, Severity::Warning, format!("robot {robot}{more} stopped")),
        MarkKind::Note => (Kind::Note, Severity::Info, "note".to_owned()),
    };
    let robot = Some(robot).filter(|_| kind != Kind::Note);
    Some(Entry { time_nanos: mark.time_nanos, kind, severity, robot, place: Place::None, text })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entry(kind: Kind, text: &str) -> Entry {
        let (severity, place) = (Severity::Info, Place::None);
        Entry { time_nanos: 0, kind, severity, robot: None, place, text: text.to_owned() }
    }

    #[test]
    fn repeats_are_put_together_so_that_another_entry_is_seen() {
        let order = |number: u32| entry(Kind::Order, &format!("order {number} was reassigned"));
        let mut entries: VecDeque<Entry> = (0..37).map(order).collect();
        entries.push_back(entry(Kind::Edge, "edge 7 was closed"));
        entries.extend([order(90), entry(Kind::Order, "order 91 has failed")]);
        let shown = repeated(&entries, &LogFilter::default());
        let rows: Vec<_> = shown.iter().map(|row| (row.place, row.more)).collect();
        assert_eq!(rows, [(39, 0), (38, 0), (37, 0), (36, 36)]);
        let filter = LogFilter { text: "reassigned".to_owned(), ..LogFilter::default() };
        assert_eq!(repeated(&entries, &filter).len(), 38, "a text shows each");
    }
}
