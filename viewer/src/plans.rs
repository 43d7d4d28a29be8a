//! What a fleet manager plans, for all robots or those that match the filter: routes, goals, and
//! who waits for whom. A background thread collects and reduces it to lists to draw, so that no
//! picture waits for it.

mod collector;
pub mod goals;
pub mod lines;
pub mod waits;

use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::{Duration, Instant};

use regatta_interface::robot_filter::{RobotSet, is_in};
use regatta_plugin::column::{GOAL, WAITS_FOR};
use regatta_plugin::{
    ColumnReader, FleetName, Participant, ReadError, Result, RouteClient, Subscriber, WorldReader,
};
use regatta_scene::plans::PlanReport;

use crate::watching::Watched;
use collector::Collector;
use goals::Places;

/// The time between two reports, unless they take long, and between two rounds of requests for
/// routes.
const REPORT_EVERY: Duration = Duration::from_millis(100);
/// The time for which routes are asked for between two looks at what is to be watched.
const ASK_FOR: Duration = Duration::from_millis(40);
/// The time after which routes are asked for again if nobody answers.
const ASK_AGAIN: Duration = Duration::from_millis(500);
/// A report is followed by a pause of at least so many times the time that it took.
const PAUSES: u32 = 5;

/// What is to be watched.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Watch {
    /// Routes and goals.
    pub plans: bool,
    /// Who waits for whom.
    pub waits: bool,
    /// The robots whose plans and waits are watched; `None` for all.
    pub matching: Option<RobotSet>,
    /// Robots that are watched even if they are not among those, and their goals even without those
    /// of others.
    pub selected: Vec<u32>,
}

impl Watch {
    /// Returns the robots that match, and the selected ones; `None` for all.
    fn robots(&self) -> Option<RobotSet> {
        let mut robots = self.matching.clone()?;
        self.selected.iter().for_each(|robot| robots.insert(*robot));
        Some(robots)
    }

    /// Whether something else is to be watched than before, other than that some more or fewer
    /// robots match.
    fn differs(&self, before: &Self) -> bool {
        let wanted = |watch: &Self| (watch.plans, watch.waits, watch.matching.is_some());
        wanted(self) != wanted(before) || self.selected != before.selected
    }
}

impl Watched for Watch {
    type Report = PlanReport;

    const THREAD: &'static str = "plans";

    fn is_idle(&self) -> bool {
        !self.plans && !self.waits && self.selected.is_empty()
    }

    fn run(
        fleet: &FleetName,
        changed: &Receiver<Self>,
        report: &mut dyn FnMut(PlanReport) -> bool,
    ) -> Result {
        run(fleet, changed, report)
    }
}

/// Reads plans at once, with the newest frame, for programs that wait for it.
pub struct PlanReader(Watcher);

impl PlanReader {
    /// Opens what a fleet publishes.
    ///
    /// # Errors
    /// If the fleet can't be read.
    pub fn open(fleet: &FleetName) -> Result<Self> {
        Ok(Self(Watcher::open(&Participant::join(fleet, "viewer-plans")?)?))
    }

    /// Returns what is known with the newest frame.
    ///
    /// # Errors
    /// If the fleet can't be read.
    pub fn read(&mut self, watch: &Watch) -> Result<PlanReport> {
        Ok(self.0.poll(watch, true)?.unwrap_or_default())
    }
}

fn run(
    fleet: &FleetName,
    changed: &Receiver<Watch>,
    report: &mut dyn FnMut(PlanReport) -> bool,
) -> Result {
    let participant = Participant::join(fleet, "viewer-plans")?;
    let mut watch = Watch::default();
    let mut watcher: Option<Watcher> = None;
    loop {
        let wait = watcher.as_ref().map_or(Duration::MAX, Watcher::idle_time);
        let change = if wait == Duration::MAX {
            changed.recv().map_err(|_| RecvTimeoutError::Disconnected)
        } else {
            changed.recv_timeout(wait)
        };
        let mut is_changed = false;
        match change {
            Ok(newer) => {
                let newer = changed.try_iter().last().unwrap_or(newer);
                is_changed = newer.differs(&watch);
                watch = newer;
            }
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return Ok(()),
        }
        let found = if watch.is_idle() {
            watcher.take().map(|_| PlanReport::default())
        } else {
            let open = match &mut watcher {
                Some(open) => open,
                none => none.insert(Watcher::open(&participant)?),
            };
            open.poll(&watch, is_changed)?
        };
        if found.is_some_and(|found| !report(found)) {
            return Ok(());
        }
    }
}

/// The ports that are open while something is watched.
struct Watcher {
    frames: Subscriber,
    worlds: WorldReader,
    places: Places,
    goals: ColumnReader,
    waits: ColumnReader,
    client: RouteClient,
    collector: Collector,
    ask_at: Option<Instant>,
    report_at: Instant,
}

impl Watcher {
    fn open(participant: &Participant) -> Result<Self> {
        Ok(Self {
            frames: Subscriber::open_on(participant)?,
            worlds: WorldReader::open_on(participant)?,
            places: Places::default(),
            goals: ColumnReader::open_on(participant, GOAL.name())?,
            waits: ColumnReader::open_on(participant, WAITS_FOR.name())?,
            client: RouteClient::open_on(participant)?,
            collector: Collector::new(),
            ask_at: None,
            report_at: Instant::now(),
        })
    }

    fn idle_time(&self) -> Duration {
        let next = self.ask_at.map_or(self.report_at, |ask| ask.min(self.report_at));
        next.saturating_duration_since(Instant::now())
    }

    /// Does what is due. Returns a report if one is, or `at_once` if what is watched has changed.
    fn poll(&mut self, watch: &Watch, at_once: bool) -> Result<Option<PlanReport>> {
        self.frames.latest()?;
        if self.worlds.latest()?.is_some() {
            self.places =
                self.worlds.current()?.map(|world| Places::new(&world)).unwrap_or_default();
        }
        if !watch.plans {
            self.ask_at = None;
            self.collector = Collector::new();
        } else if self.ask_at.is_none_or(|ask| Instant::now() >= ask) {
            self.ask(watch)?;
        }
        if !at_once && Instant::now() < self.report_at {
            return Ok(None);
        }
        let start = Instant::now();
        let report = self.report(watch)?;
        self.report_at = Instant::now() + REPORT_EVERY.max(start.elapsed() * PAUSES);
        Ok(Some(report))
    }

    fn ask(&mut self, watch: &Watch) -> Result<(), ReadError> {
        let now = Instant::now();
        let Some(frame) = self.frames.current()? else {
            self.ask_at = Some(now + REPORT_EVERY);
            return Ok(());
        };
        let asked = self.collector.advance(
            &mut self.client,
            &frame,
            watch.robots().as_ref(),
            now + ASK_FOR,
        );
        let rest = match asked {
            Ok(false) => Duration::ZERO,
            Ok(true) => REPORT_EVERY,
            Err(error) => {
                tracing::debug!(%error, "asking for all routes");
                ASK_AGAIN
            }
        };
        self.ask_at = Some(Instant::now() + rest);
        Ok(())
    }

    fn report(&mut self, watch: &Watch) -> Result<PlanReport, ReadError> {
        let mut found = PlanReport::default();
        let (Some(frame), Some(world)) = (self.frames.current()?, self.worlds.current()?) else {
            return Ok(found);
        };
        let (matching, robots) = (watch.matching.as_ref(), watch.robots());
        let is_watched = |robot: u32| is_in(robots.as_ref(), robot);
        found.facts.is_filtered = matching.is_some();
        if watch.plans {
            let routes = self.collector.routes().filter(|route| is_watched(route.robot));
            found.lines = lines::lines(routes, &frame, &world);
            found.facts.routes = Some(self.collector.coverage(&frame, matching));
        }
        if let Some(goals) = values(&mut self.goals, frame.run_id())? {
            found.facts.has_goals = true;
            found.goals = goals::marks(
                goals,
                |robot| watch.plans && is_watched(robot),
                &watch.selected,
                &self.places,
            );
        }
        if let Some(waits_for) = values(&mut self.waits, frame.run_id())?.filter(|_| watch.waits) {
            found.arrows = waits::arrows(waits_for);
            found.arrows.retain(|arrow| is_watched(arrow.from));
            let counted = || found.arrows.iter().filter(|arrow| is_in(matching, arrow.from));
            let in_rings = counted().filter(|arrow| arrow.in_ring == 1).count();
            found.facts.waiting = Some([counted().count() as u32, in_rings as u32]);
        }
        Ok(found)
    }
}

/// Returns the newest values of a column of a run, while it has a publisher.
fn values(reader: &mut ColumnReader, run: u64) -> Result<Option<&[f32]>, ReadError> {
    reader.latest()?;
    let has_publisher = reader.has_publisher();
    Ok(reader
        .current()?
        .filter(|column| has_publisher && column.header.run_id == run)
        .map(|column| column.values))
}

#[cfg(test)]
mod tests;
