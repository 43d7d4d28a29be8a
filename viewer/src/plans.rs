//! The plans of a fleet manager, for all robots or those that match the filter: routes, goals, and
//! waits for other robots. A worker collects them, and reduces them to lists to draw.

mod collector;
pub mod marks;

use std::time::{Duration, Instant};

use regatta_interface::robot_filter::{RobotSet, is_in};
use regatta_plugin::column::{GOAL, WAITS_FOR};
use regatta_plugin::{
    ColumnReader, Participant, ReadError, Result, RouteClient, Subscriber, WorldReader,
};
use regatta_scene::plans::{PlanReport, Waiting};

use crate::worker::Query;
use collector::Collector;
use marks::{Places, arrows, goal_marks, lines};

/// The time between two reports, unless they take long, and between two rounds of requests for
/// routes.
const REPORT_EVERY: Duration = Duration::from_millis(100);
/// The time for which routes are asked for between two looks at the query.
const ASK_FOR: Duration = Duration::from_millis(40);
/// The time after which routes are requested again without an answer.
const ASK_AGAIN: Duration = Duration::from_millis(500);
/// A report is followed by a pause of at least so many times the time that it took.
const PAUSES: u32 = 5;

/// The plans to collect.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PlanQuery {
    /// Routes and goals.
    pub plans: bool,
    /// The robots that robots wait for.
    pub waits: bool,
    /// The robots whose plans and waits are watched; `None` for all.
    pub matching: Option<RobotSet>,
    /// Robots that are watched even if they are not among those, and their goals even without those
    /// of others.
    pub selected: Vec<u32>,
}

impl PlanQuery {
    /// Returns the robots that match, and the selected ones; `None` for all.
    fn robots(&self) -> Option<RobotSet> {
        let mut robots = self.matching.clone()?;
        for robot in &self.selected {
            robots.insert(*robot);
        }
        Some(robots)
    }
}

impl Query for PlanQuery {
    type Report = PlanReport;
    type Ports = Watcher;

    const THREAD: &'static str = "plans";

    fn is_idle(&self) -> bool {
        !self.plans && !self.waits && self.selected.is_empty()
    }

    /// Not if only some more or fewer robots match.
    fn is_urgent(&self, before: &Self) -> bool {
        (self.plans, self.waits, &self.selected) != (before.plans, before.waits, &before.selected)
            || self.matching.is_some() != before.matching.is_some()
    }

    fn open(participant: &Participant) -> Result<Watcher> {
        Watcher::open(participant)
    }

    fn due(watcher: &Watcher) -> Instant {
        watcher.ask_at.map_or(watcher.report_at, |ask| ask.min(watcher.report_at))
    }

    fn poll(&self, watcher: &mut Watcher, at_once: bool) -> Result<Option<PlanReport>> {
        watcher.poll(self, at_once)
    }

    fn nothing() -> PlanReport {
        PlanReport::default()
    }
}

/// The open ports, and the routes so far.
pub struct Watcher {
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

    /// Asks for routes and reports, each if it is due. Reports in any case `at_once`.
    fn poll(&mut self, query: &PlanQuery, at_once: bool) -> Result<Option<PlanReport>> {
        self.frames.latest()?;
        if self.worlds.latest()?.is_some() {
            self.places =
                self.worlds.current()?.map(|world| Places::new(&world)).unwrap_or_default();
        }
        if !query.plans {
            self.ask_at = None;
            self.collector = Collector::new();
        } else if self.ask_at.is_none_or(|ask| Instant::now() >= ask) {
            self.ask(query)?;
        }
        if !at_once && Instant::now() < self.report_at {
            return Ok(None);
        }
        let start = Instant::now();
        let report = self.report(query)?;
        self.report_at = Instant::now() + REPORT_EVERY.max(start.elapsed() * PAUSES);
        Ok(Some(report))
    }

    fn ask(&mut self, query: &PlanQuery) -> Result<(), ReadError> {
        let now = Instant::now();
        let Some(frame) = self.frames.current()? else {
            self.ask_at = Some(now + REPORT_EVERY);
            return Ok(());
        };
        let robots = query.robots();
        let until = now + ASK_FOR;
        let asked = self.collector.advance(&mut self.client, &frame, robots.as_ref(), until);
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

    fn report(&mut self, query: &PlanQuery) -> Result<PlanReport, ReadError> {
        let mut found = PlanReport::default();
        let (Some(frame), Some(world)) = (self.frames.current()?, self.worlds.current()?) else {
            return Ok(found);
        };
        let (matching, robots) = (query.matching.as_ref(), query.robots());
        found.facts.is_filtered = matching.is_some();
        if query.plans {
            let routes =
                self.collector.routes().filter(|route| is_in(robots.as_ref(), route.robot));
            found.lines = lines(routes, &frame, &world);
            found.facts.routes = Some(self.collector.coverage(&frame, matching));
        }
        if let Some(goals) = values(&mut self.goals, frame.run_id())? {
            found.facts.has_goals = true;
            found.goals = goal_marks(
                goals,
                |robot| query.plans && is_in(robots.as_ref(), robot),
                &query.selected,
                &self.places,
            );
        }
        if let Some(waits_for) = values(&mut self.waits, frame.run_id())?.filter(|_| query.waits) {
            found.arrows = arrows(waits_for);
            found.arrows.retain(|arrow| is_in(robots.as_ref(), arrow.from));
            let mut waiting = Waiting::default();
            for arrow in found.arrows.iter().filter(|arrow| is_in(matching, arrow.from)) {
                waiting.robots += 1;
                waiting.in_rings += arrow.in_ring;
            }
            found.facts.waiting = Some(waiting);
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
