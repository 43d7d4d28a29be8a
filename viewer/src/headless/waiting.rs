//! Waits before a picture: for the fleet, its columns, plans and figures.

use std::time::{Duration, Instant};

use regatta_plugin::frame::ClockState;
use regatta_plugin::{Error, Result};
use regatta_scene::palette::Colouring;

use super::{HeadlessViewer, POLL};

/// The time after which a message says that the viewer waits for the fleet.
const NOTICE_AFTER: Duration = Duration::from_secs(1);
/// The longest time that the replay of a recording may take to start.
const REPLAY_START: Duration = Duration::from_secs(30);
/// The longest wait for columns, which may arrive some moments after their frame.
const COLUMNS_WAIT: Duration = Duration::from_millis(300);
/// The longest wait for a column that the command line names, whose plugin may just be starting.
const REQUESTED_COLUMN_WAIT: Duration = Duration::from_secs(3);
/// The longest wait for the figures of a heat map.
const HEAT_WAIT: Duration = Duration::from_secs(3);
/// The longest wait for the plans of all robots of a screenshot.
const PLANS_WAIT: Duration = Duration::from_secs(10);

impl HeadlessViewer<'_> {
    /// Waits for a world, and for a frame at or after the requested time. Returns false if
    /// interrupted.
    pub(super) fn wait_for_fleet(&mut self) -> Result<bool> {
        let (started, mut is_notified, mut polls) = (Instant::now(), false, 0);
        // The frames before the picture are played afterwards, if they are needed.
        let at = self.options.at.filter(|_| !self.options.plays_to_picture());
        let from = at.map_or(Duration::ZERO, Into::into);
        while !self.termination.requested() {
            let news = self.stage.update(Instant::now())?;
            self.update_labels(news);
            if news.frame && self.stage.scene.trails.points > 0 {
                self.stage.collect_trails();
            }
            let time = self.stage.feed.frame().map(|frame| frame.sim_time());
            polls += u32::from(time.is_some());
            if let Some(time) = time.filter(|time| polls == 1 && at.is_some() && *time > from) {
                let (time, fleet) = (time.as_secs_f64(), &self.options.fleet);
                return Err(Error::new(format!(
                    "fleet '{fleet}' is already at {time:.2} s, after --at: give a later time, or \
                     replay a recording"
                )));
            }
            if time.is_some_and(|time| time >= from || self.stands_at(from))
                && self.stage.feed.world().is_some()
            {
                let bounds = self.stage.bounds();
                self.options.look.load_floor_picture(&mut self.stage.renderer, bounds);
                return Ok(true);
            }
            if self.options.recording.is_some()
                && time.is_none()
                && started.elapsed() > REPLAY_START
            {
                return Err(Error::new(
                    "the replay of the recording doesn't start; `regatta replay FILE` says why",
                ));
            }
            if !is_notified && started.elapsed() > NOTICE_AFTER {
                let what = if time.is_some() { "the time --at of " } else { "" };
                regatta_plugin::tell!("viewer: waiting for {what}fleet '{}'", self.options.fleet);
                is_notified = true;
            }
            let is_absent = time.is_none() && self.stage.feed.warm_up().is_none();
            if is_absent && started.elapsed() > self.options.timeout.into() {
                let (fleet, timeout) = (&self.options.fleet, self.options.timeout);
                return Err(Error::new(format!(
                    "no frame of fleet '{fleet}' within {timeout}: start it with `regatta run`, or \
                     give a longer --timeout"
                )));
            }
            if let Some(time) = time.filter(|_| self.has_ended()) {
                let (time, fleet) = (time.as_secs_f64(), &self.options.fleet);
                return Err(Error::new(format!(
                    "fleet '{fleet}' ended at {time:.2} s, before --at"
                )));
            }
            std::thread::sleep(POLL);
        }
        Ok(false)
    }

    /// Whether this is a recording that stands at a time within it: the frame is the last one
    /// before, if none is at that time.
    fn stands_at(&self, time: Duration) -> bool {
        let clock = self.stage.feed.frame().map(|frame| frame.header().clock);
        let recording =
            self.stage.feed.recording().filter(|_| clock == Some(ClockState::Paused as u32));
        recording.is_some_and(|recording| time.as_nanos() <= u128::from(recording.header.end_nanos))
    }

    /// Whether the producer has stopped or is gone.
    pub(super) fn has_ended(&self) -> bool {
        let header = self.stage.feed.frame().map(|frame| *frame.header());
        header.is_some_and(|header| header.clock == ClockState::Stopped as u32)
            || !self.stage.feed.has_producer()
    }

    /// Waits a moment for the columns of robot types and values.
    pub(super) fn wait_for_columns(&mut self) -> Result {
        let started = Instant::now();
        let wait =
            if self.options.look.colour.is_some() { REQUESTED_COLUMN_WAIT } else { COLUMNS_WAIT };
        while self.lacks_columns() && started.elapsed() < wait && !self.termination.requested() {
            std::thread::sleep(POLL);
            self.stage.update(Instant::now())?;
        }
        Ok(())
    }

    /// Whether the column of robot types is missing, or the one that colours robots.
    fn lacks_columns(&self) -> bool {
        let feed = &self.stage.feed;
        let lacks_values = match &self.stage.colouring {
            None => feed.activity().is_none() || feed.value().is_none(),
            Some(Colouring::Column(_)) => feed.value().is_none(),
            Some(_) => false,
        };
        feed.robot_type().is_none() || lacks_values
    }

    /// Waits until the routes of all robots have been requested once, and the waiting robots are
    /// known.
    pub(super) fn wait_for_plans(&mut self) -> Result {
        let started = Instant::now();
        let layers = self.stage.scene.layers;
        while self.plans.is_some()
            && started.elapsed() < PLANS_WAIT
            && !self.termination.requested()
        {
            std::thread::sleep(POLL);
            self.stage.update(Instant::now())?;
            let Some(facts) = self.update_plans()? else { continue };
            let has_round = facts
                .routes
                .is_some_and(|routes| routes.round_secs.is_finite() || routes.under_way == 0);
            // Without a fleet manager, nobody publishes the columns.
            let is_late = started.elapsed() > COLUMNS_WAIT;
            let has_columns = facts.has_goals && (!layers.waits || facts.waiting.is_some());
            if (!layers.plans || has_round) && (has_columns || is_late) {
                break;
            }
        }
        Ok(())
    }

    /// Waits a moment for the figures of the heat map, which are published once a simulated second.
    pub(super) fn wait_for_heat(&mut self) -> Result {
        let started = Instant::now();
        while self.jams.is_some() && started.elapsed() < HEAT_WAIT && !self.termination.requested()
        {
            std::thread::sleep(POLL);
            self.stage.update(Instant::now())?;
            self.update_jams()?;
            if self.stage.jam_facts().heat.is_some() {
                return Ok(());
            }
        }
        if self.jams.is_some() {
            let fleet = &self.options.fleet;
            tracing::warn!(
                "nobody publishes the figures of edges; start: regatta plugin traffic --fleet \
                 {fleet}"
            );
        }
        Ok(())
    }
}
