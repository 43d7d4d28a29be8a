//! The log of a fleet, collected from its events, contacts, orders and frames.

mod entries;
mod health;
mod standing;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use regatta_interface::log::{AlarmChange, Entry, Kind, LogReport, Severity};
use regatta_interface::text::{thousands, with_plural};
use regatta_plugin::column::GOAL;
use regatta_plugin::frame::Frame;
use regatta_plugin::{
    ColumnReader, ContactEventReader, EventReader, OrderReader, Participant, ReadError, Result,
    Subscriber,
};

use crate::worker::Query;
use entries::{of_contact, of_event, of_order};
use health::{Health, about_fleet, is_stuck};
use standing::{Now, Standing, Unseen};

/// The time between two looks. Events of some tens of ticks are kept for a reader.
const EVERY: Duration = Duration::from_millis(40);
/// The number of looks between two at whether anybody moves, and whether the manager is there: a
/// second.
const CHECK_EVERY: u32 = 25;
/// The number of looks between two at which alarms hold: a fifth of a second.
const COMPARE_EVERY: u32 = 5;
/// The maximum number of entries of one kind that one check adds. The rest is counted in one entry.
const MOST_OF_A_KIND: usize = 200;

/// The query for the log, which is never idle.
#[derive(Clone, Copy, Debug, Default)]
pub struct LogQuery;

impl Query for LogQuery {
    type Report = LogReport;
    type Ports = LogCollector;

    const THREAD: &'static str = "log";

    fn is_idle(&self) -> bool {
        false
    }

    fn is_urgent(&self, _: &Self) -> bool {
        false
    }

    fn open(participant: &Participant) -> Result<LogCollector> {
        LogCollector::open(participant)
    }

    fn due(collector: &LogCollector) -> Instant {
        collector.look_at
    }

    fn poll(&self, collector: &mut LogCollector, at_once: bool) -> Result<Option<LogReport>> {
        let found = collector.poll()?;
        Ok((at_once || found != LogReport::default()).then_some(found))
    }

    fn nothing() -> LogReport {
        LogReport::default()
    }
}

/// The records of each tick.
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
    look_at: Instant,
    health: Health,
    standing: Standing,
    /// Whether events may have been missed.
    has_missed: bool,
}

impl LogCollector {
    /// Opens the ports of a fleet.
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
            look_at: Instant::now(),
            health: Health::default(),
            standing: Standing::default(),
            has_missed: false,
        })
    }

    /// Returns the news since the last call.
    ///
    /// # Errors
    /// [`ReadError`] if the fleet can't be read.
    pub fn poll(&mut self) -> Result<LogReport, ReadError> {
        self.look_at = Instant::now() + EVERY;
        // The standing alarms are read before the events, so that the events that caused them are
        // known.
        self.frames.latest()?;
        self.now.update()?;
        let mut found = LogReport::default();
        let Self {
            frames, records, now, goals, run_id, looks, health, standing, has_missed, ..
        } = self;
        let Some(frame) = frames.current()? else { return Ok(found) };
        let clock = Clock::of(&frame);
        if frame.run_id() != *run_id {
            found.is_new_run = *run_id != 0;
            *run_id = frame.run_id();
            *health = Health::new(clock.sim_nanos);
            *standing = Standing::default();
            // If a run begins while the window is open, events may precede the first frame.
            *has_missed = found.is_new_run;
        }
        if frame.header().is_warm_up() {
            // Events of the warm-up aren't of the run.
            *health = Health::new(clock.sim_nanos);
            records.take(*run_id, &clock, standing, &mut Vec::new())?;
            return Ok(found);
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
    /// Appends the news of a run since the last call. Returns the number of ticks whose
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

/// Leaves out entries beyond [`MOST_OF_A_KIND`] that aren't alarms, and counts them in one more
/// entry.
fn thin_out(news: &mut Vec<(Entry, AlarmChange)>) {
    let mut counts = BTreeMap::<Kind, usize>::new();
    news.retain(|(entry, change)| {
        let count = counts.entry(entry.kind).or_default();
        *count += 1;
        *count <= MOST_OF_A_KIND || *change != AlarmChange::None
    });
    let time = news.last().map_or(0, |(entry, _)| entry.time_nanos);
    for (kind, count) in counts.into_iter().filter(|(_, count)| *count > MOST_OF_A_KIND) {
        let more = thousands((count - MOST_OF_A_KIND) as u64);
        let text = format!("{more} more of these ({}) at once", kind.name());
        let entry = Entry { kind, ..about_fleet(time, Severity::Warning, text) };
        news.push((entry, AlarmChange::None));
    }
}
