//! The thread that collects the log.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use regatta_interface::log::{AlarmChange, Entry, Kind, LogReport, Severity};
use regatta_interface::text::with_plural;
use regatta_plugin::column::GOAL;
use regatta_plugin::frame::Frame;
use regatta_plugin::{
    ColumnReader, ContactEventReader, EventReader, FleetName, OrderReader, Participant, ReadError,
    Result, Subscriber,
};

use super::entries::{of_contact, of_event, of_order};
use super::health::{Health, about_fleet, is_stuck};
use super::standing::{Now, Standing, Unseen};

/// The time between two looks. Events of some tens of ticks are kept for a reader.
const EVERY: Duration = Duration::from_millis(40);
/// The number of looks between two at whether anybody moves, and whether the manager is there: a
/// second.
const CHECK_EVERY: u32 = 25;
/// The number of looks between two at which alarms hold: a fifth of a second.
const COMPARE_EVERY: u32 = 5;
/// The most entries of one kind that one look adds; the rest is counted in one entry.
const MOST_OF_A_KIND: usize = 200;

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

fn run(
    fleet: &FleetName,
    is_over: &AtomicBool,
    report: &mut dyn FnMut(LogReport) -> bool,
) -> Result {
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

/// What processes tell of each tick.
#[derive(Debug)]
struct Records {
    events: EventReader,
    contacts: ContactEventReader,
    orders: OrderReader,
}

/// Collects the log of a fleet.
#[derive(Debug)]
pub struct LogCollector {
    frames: Subscriber,
    records: Records,
    now: Now,
    /// The fleet manager publishes it with each frame that it has seen.
    goals: ColumnReader,
    run_id: u64,
    looks: u32,
    health: Health,
    standing: Standing,
    /// Whether events may have been missed.
    has_missed: bool,
}

impl LogCollector {
    /// Opens what a fleet tells.
    ///
    /// # Errors
    /// If the fleet can't be read.
    pub fn open(participant: &Participant) -> Result<Self> {
        Ok(Self {
            frames: Subscriber::open_on(participant)?,
            records: Records {
                events: EventReader::open_on(participant)?,
                contacts: ContactEventReader::open_on(participant)?,
                orders: OrderReader::open_on(participant)?,
            },
            now: Now::open(participant)?,
            goals: ColumnReader::open_on(participant, GOAL.name())?,
            run_id: 0,
            looks: 0,
            health: Health::default(),
            standing: Standing::default(),
            has_missed: false,
        })
    }

    /// Returns what has happened since the last call.
    ///
    /// # Errors
    /// [`ReadError`] if the fleet can't be read.
    pub fn poll(&mut self) -> Result<LogReport, ReadError> {
        // What holds is read before the events: those that led to it are known then.
        self.frames.latest()?;
        self.now.update()?;
        let mut found = LogReport::default();
        let Self { frames, records, now, goals, run_id, looks, health, standing, has_missed } =
            self;
        let Some(frame) = frames.current()? else { return Ok(found) };
        let clock = Clock::of(&frame);
        if frame.run_id() != *run_id {
            found.is_new_run = *run_id != 0;
            *run_id = frame.run_id();
            *health = Health::new(clock.sim_nanos);
            *standing = Standing::default();
            // Of a run that begins while the window is open, events may have come before the first
            // frame.
            *has_missed = found.is_new_run;
        }
        found.is_replayed = now.change_of_replay(*run_id);
        let missed = records.take(*run_id, &clock, standing, &mut found.news)?;
        thin_out(&mut found.news);
        if missed > 0 {
            *has_missed = true;
            let (ticks, verb) =
                (with_plural(missed, "tick"), if missed == 1 { "was" } else { "were" });
            let text =
                format!("events of {ticks} {verb} missed: the fleet is faster than this viewer");
            found
                .news
                .push((about_fleet(clock.sim_nanos, Severity::Info, text), AlarmChange::None));
        }
        if looks.is_multiple_of(COMPARE_EVERY) {
            let unseen = match (now.is_replayed(), *has_missed) {
                (true, _) => Unseen::Jumped,
                (false, true) => Unseen::Missed,
                (false, false) => Unseen::Opened,
            };
            found.news.extend(now.compare(standing, &frame, unseen));
        }
        *looks += 1;
        health.look(clock.sim_nanos, now.is_replayed());
        if looks.is_multiple_of(CHECK_EVERY) {
            goals.latest()?;
            let told = goals.current()?.filter(|column| column.header.run_id == *run_id);
            let told = told.map(|column| clock.time_of(column.header.tick));
            found.news.extend(health.see_manager(clock.sim_nanos, told));
            found.is_managed = health.change_of_management();
            found.news.extend(health.see_motion(clock.sim_nanos, is_stuck(&frame)));
        }
        Ok(found)
    }
}

impl Records {
    /// Appends what has happened in a run since the last call. Returns the number of ticks whose
    /// events were missed.
    fn take(
        &mut self,
        run_id: u64,
        clock: &Clock,
        standing: &mut Standing,
        news: &mut Vec<(Entry, AlarmChange)>,
    ) -> Result<u64, ReadError> {
        let mut missed = 0;
        self.events.take(|tick| {
            missed += tick.missed;
            let time = clock.time_of(tick.header.tick);
            let records = tick.records.iter().filter(|_| tick.header.run_id == run_id);
            for (entry, change) in records.filter_map(|event| of_event(event, time)) {
                standing.tell(change, tick.header.tick);
                news.push((entry, change));
            }
            Ok::<_, ReadError>(())
        })?;
        self.contacts.take(|tick| {
            let records = tick.records.iter().filter(|_| tick.header.run_id == run_id);
            for (entry, change) in records.filter_map(of_contact) {
                standing.tell(change, tick.header.tick);
                news.push((entry, change));
            }
            Ok::<_, ReadError>(())
        })?;
        self.orders.take(|tick| {
            let records = tick.records.iter().filter(|_| tick.header.run_id == run_id);
            let time = clock.time_of(tick.header.tick);
            news.extend(records.filter_map(|order| of_order(order, time)));
            Ok::<_, ReadError>(())
        })?;
        Ok(missed)
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
        Self {
            tick: header.tick,
            sim_nanos: header.sim_time_nanos,
            period_nanos: header.tick_period_nanos,
        }
    }

    fn time_of(&self, tick: u64) -> u64 {
        let apart = self.tick.abs_diff(tick).saturating_mul(self.period_nanos);
        if tick > self.tick {
            self.sim_nanos.saturating_add(apart)
        } else {
            self.sim_nanos.saturating_sub(apart)
        }
    }
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

#[cfg(test)]
mod tests {
    use super::*;
    use regatta_interface::log::AlarmKey;

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
}
