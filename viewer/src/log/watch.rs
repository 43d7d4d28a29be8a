//! The thread that collects the log.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use regatta_plugin::frame::{Frame, RobotState};
use regatta_plugin::{
    ColumnReader, ContactEventReader, EventReader, FleetName, Participant, ReadError, Result, Subscriber, TaskReader,
};

use super::entries::{of_contact, of_event, of_task};
use super::{AlarmChange, AlarmKey, Entry, Kind, LogReport, Place, Severity};

/// The time between two looks. Events of some tens of ticks are kept for a reader.
const EVERY: Duration = Duration::from_millis(40);
/// The number of looks between two at whether anybody moves, and whether the manager is there: a second.
const CHECK_EVERY: u32 = 25;
/// The most entries of one kind that one look adds; the rest is counted in one entry.
const MOST_OF_A_KIND: usize = 200;
/// The simulated time for which robots that want to drive all stand, until that is an alarm, in nanoseconds.
const STANDSTILL_NANOS: u64 = 30_000_000_000;
/// The simulated time after which a fleet manager that says nothing is silent, in nanoseconds.
const SILENCE_NANOS: u64 = 5_000_000_000;

/// A running thread that collects the log. Dropping it ends the thread.
#[derive(Debug)]
pub struct LogWatch {
    is_over: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl LogWatch {
    /// Starts the thread. `report` gets what it finds, and returns whether it wants more.
    ///
    /// # Errors
    /// If the system can't start a thread.
    pub fn start(
        fleet: &FleetName,
        mut report: impl FnMut(Result<LogReport>) -> bool + Send + 'static,
    ) -> std::io::Result<Self> {
        let is_over = Arc::new(AtomicBool::new(false));
        let (fleet, stop) = (fleet.clone(), is_over.clone());
        let thread = std::thread::Builder::new().name("log".into()).spawn(move || {
            if let Err(error) = run(&fleet, &stop, &mut |found| report(Ok(found))) {
                report(Err(error));
            }
        })?;
        Ok(Self { is_over, thread: Some(thread) })
    }
}

impl Drop for LogWatch {
    fn drop(&mut self) {
        self.is_over.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            // The result is an error only if the thread panicked, and the panic has been printed.
            let _ = thread.join();
        }
    }
}

fn run(fleet: &FleetName, is_over: &AtomicBool, report: &mut dyn FnMut(LogReport) -> bool) -> Result {
    let mut collector = LogCollector::open(&Participant::join(fleet, "viewer-log")?)?;
    while !is_over.load(Ordering::Relaxed) {
        let found = collector.poll()?;
        if found != LogReport::default() && !report(found) {
            break;
        }
        std::thread::sleep(EVERY);
    }
    Ok(())
}

/// Collects the log of a fleet.
#[derive(Debug)]
pub struct LogCollector {
    frames: Subscriber,
    events: EventReader,
    contacts: ContactEventReader,
    tasks: TaskReader,
    /// The fleet manager publishes it with each frame that it has seen.
    goals: ColumnReader,
    run_id: u64,
    looks: u32,
    health: Health,
}

/// What is not told by events.
#[derive(Clone, Copy, Debug, Default)]
struct Health {
    /// When robots that want to drive were last seen to move, in simulated nanoseconds.
    moved: u64,
    stands: bool,
    /// When the fleet manager last told of a frame, in simulated nanoseconds; `None` if there was none in this run.
    managed: Option<u64>,
    is_silent: bool,
    is_managed: bool,
}

impl LogCollector {
    /// Opens what a fleet tells.
    ///
    /// # Errors
    /// If the fleet can't be read.
    pub fn open(participant: &Participant) -> Result<Self> {
        Ok(Self {
            frames: Subscriber::open_on(participant)?,
            events: EventReader::open_on(participant)?,
            contacts: ContactEventReader::open_on(participant)?,
            tasks: TaskReader::open_on(participant)?,
            goals: ColumnReader::open_on(participant, "goal")?,
            run_id: 0,
            looks: 0,
            health: Health::default(),
        })
    }

    /// Returns what has happened since the last call.
    ///
    /// # Errors
    /// [`ReadError`] if the fleet can't be read.
    pub fn poll(&mut self) -> Result<LogReport, ReadError> {
        self.frames.latest()?;
        let mut found = LogReport::default();
        let Self { frames, events, contacts, tasks, goals, run_id, looks, health } = self;
        let Some(frame) = frames.current()? else { return Ok(found) };
        if frame.run_id() != *run_id {
            found.is_new_run = *run_id != 0;
            *run_id = frame.run_id();
            *health = Health { moved: frame.header().sim_time_nanos, ..Health::default() };
        }
        let now = Clock::of(&frame);
        let mut missed = 0;
        events.take(|tick| {
            missed += tick.missed;
            let records = tick.records.iter().filter(|_| tick.header.run_id == *run_id);
            found.news.extend(records.filter_map(|event| of_event(event, now.time_of(tick.header.tick))));
            Ok::<_, ReadError>(())
        })?;
        contacts.take(|tick| {
            found.news.extend(tick.records.iter().filter_map(of_contact));
            Ok::<_, ReadError>(())
        })?;
        tasks.take(|tick| {
            let time = now.time_of(tick.header.tick);
            found.news.extend(tick.records.iter().filter_map(|task| of_task(task, time)));
            Ok::<_, ReadError>(())
        })?;
        thin_out(&mut found.news);
        if missed > 0 {
            let text = format!("events of {missed} ticks were missed: the fleet is faster than this viewer");
            found.news.push((about_fleet(now.sim_nanos, Severity::Info, text), AlarmChange::None));
        }
        *looks += 1;
        if looks.is_multiple_of(CHECK_EVERY) {
            goals.latest()?;
            let told = goals.current()?.filter(|column| column.header.run_id == *run_id);
            let told = told.map(|column| now.time_of(column.header.tick));
            found.news.extend(health.see_manager(now.sim_nanos, told));
            found.is_managed = health.change_of_management();
            found.news.extend(health.see_motion(now.sim_nanos, is_stuck(&frame)));
        }
        Ok(found)
    }
}

/// The simulated time of ticks, as of a frame.
struct Clock {
    tick: u64,
    sim_nanos: u64,
    period_nanos: u64,
}

impl Clock {
    fn of(frame: &Frame<'_>) -> Self {
        let header = frame.header();
        Self { tick: header.tick, sim_nanos: header.sim_time_nanos, period_nanos: header.tick_period_nanos }
    }

    fn time_of(&self, tick: u64) -> u64 {
        let apart = self.tick.abs_diff(tick).saturating_mul(self.period_nanos);
        if tick > self.tick { self.sim_nanos.saturating_add(apart) } else { self.sim_nanos.saturating_sub(apart) }
    }
}

impl Health {
    /// Takes when a fleet manager last told of a frame.
    fn see_manager(&mut self, now: u64, told: Option<u64>) -> Option<(Entry, AlarmChange)> {
        self.managed = told.or(self.managed);
        let is_silent = self.managed.is_some_and(|told| now > told.saturating_add(SILENCE_NANOS));
        if std::mem::replace(&mut self.is_silent, is_silent) == is_silent {
            return None;
        }
        let (severity, text, change) = match is_silent {
            true => (Severity::Alarm, "the fleet manager is silent or gone", AlarmChange::Begins(AlarmKey::Manager)),
            false => (Severity::Info, "the fleet manager is back", AlarmChange::Ends(AlarmKey::Manager)),
        };
        Some((about_fleet(now, severity, text.to_owned()), change))
    }

    /// Whether a fleet manager steers the robots, if that has changed.
    fn change_of_management(&mut self) -> Option<bool> {
        let is_managed = self.managed.is_some() && !self.is_silent;
        (std::mem::replace(&mut self.is_managed, is_managed) != is_managed).then_some(is_managed)
    }

    /// Takes whether all robots that want to drive stand.
    fn see_motion(&mut self, now: u64, is_stuck: bool) -> Option<(Entry, AlarmChange)> {
        if !is_stuck || now < self.moved {
            self.moved = now;
        }
        let stands = now - self.moved >= STANDSTILL_NANOS;
        if std::mem::replace(&mut self.stands, stands) == stands {
            return None;
        }
        let secs = STANDSTILL_NANOS / 1_000_000_000;
        Some(match stands {
            true => {
                let text = format!("standstill: robots want to drive, and none has moved for {secs} s");
                (about_fleet(now, Severity::Alarm, text), AlarmChange::Begins(AlarmKey::Standstill))
            }
            false => {
                let entry = about_fleet(now, Severity::Info, "robots move again".to_owned());
                (entry, AlarmChange::Ends(AlarmKey::Standstill))
            }
        })
    }
}

/// Whether robots want to drive, and none of them moves. Ends with the first one that does.
fn is_stuck(frame: &Frame<'_>) -> bool {
    let columns = frame.columns();
    let mut waiting = false;
    for (state, speed) in columns.state.iter().zip(columns.speed) {
        match RobotState::from_number(*state) {
            RobotState::Turning => return false,
            RobotState::Driving | RobotState::Waiting if *speed != 0.0 => return false,
            RobotState::Driving | RobotState::Waiting => waiting = true,
            _ => {}
        }
    }
    waiting
}

/// Leaves out entries beyond [`MOST_OF_A_KIND`] that are no alarms, and counts them in one more.
fn thin_out(news: &mut Vec<(Entry, AlarmChange)>) {
    let mut counts = BTreeMap::<Kind, usize>::new();
    news.retain(|(entry, change)| {
        let count = counts.entry(entry.kind).or_default();
        *count += 1;
        *count <= MOST_OF_A_KIND || *change != AlarmChange::None
    });
    let time = news.last().map_or(0, |(entry, _)| entry.time_nanos);
    for (kind, count) in counts.into_iter().filter(|(_, count)| *count > MOST_OF_A_KIND) {
        let text = format!("{} more of these ({}) at once", count - MOST_OF_A_KIND, kind.name());
        let entry = Entry { kind, ..about_fleet(time, Severity::Warning, text) };
        news.push((entry, AlarmChange::None));
    }
}

fn about_fleet(time_nanos: u64, severity: Severity, text: String) -> Entry {
    Entry { time_nanos, kind: Kind::Fleet, severity, robot: None, place: Place::None, text }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SECOND: u64 = 1_000_000_000;

    #[test]
    fn a_manager_that_tells_of_no_frames_is_silent_until_it_does() {
        let mut health = Health::default();
        assert_eq!(health.see_manager(100 * SECOND, None), None, "there was none");
        assert_eq!(health.see_manager(101 * SECOND, Some(101 * SECOND)), None);
        assert_eq!(health.see_manager(105 * SECOND, Some(101 * SECOND)), None);
        let silent = health.see_manager(107 * SECOND, None).map(|(_, change)| change);
        assert_eq!(silent, Some(AlarmChange::Begins(AlarmKey::Manager)));
        assert_eq!(health.see_manager(108 * SECOND, None), None, "told once");
        let back = health.see_manager(109 * SECOND, Some(109 * SECOND)).map(|(_, change)| change);
        assert_eq!(back, Some(AlarmChange::Ends(AlarmKey::Manager)));
    }

    #[test]
    fn a_standstill_takes_half_a_minute() {
        let mut health = Health::default();
        assert_eq!(health.see_motion(SECOND, false), None);
        assert_eq!(health.see_motion(30 * SECOND, true), None);
        let stands = health.see_motion(31 * SECOND, true).map(|(_, change)| change);
        assert_eq!(stands, Some(AlarmChange::Begins(AlarmKey::Standstill)));
        assert_eq!(health.see_motion(90 * SECOND, true), None);
        let moves = health.see_motion(91 * SECOND, false).map(|(_, change)| change);
        assert_eq!(moves, Some(AlarmChange::Ends(AlarmKey::Standstill)));
    }

    #[test]
    fn many_entries_at_once_are_counted() {
        let entry = |number: usize| (about_fleet(number as u64, Severity::Info, String::new()), AlarmChange::None);
        let mut news: Vec<_> = (0..1_000).map(entry).collect();
        news[900].1 = AlarmChange::Begins(AlarmKey::Standstill);
        thin_out(&mut news);
        assert_eq!(news.len(), MOST_OF_A_KIND + 2, "an alarm is never left out");
        assert!(news.last().is_some_and(|(entry, _)| entry.text.starts_with("800 more")), "{:?}", news.last());
    }
}
