//! A day: orders with times, which replace the load.

use std::collections::BTreeSet;
use std::sync::Arc;

use serde::Serialize;

use super::scenario::{Load, Setup};
use super::{PlanError, Variant};
use crate::job::{Ending, IN_TURN, Manager};

/// The latest end of a day, in seconds: some 30 years, which no run takes.
const LATEST_SECS: f64 = 1e9;

/// The time of day at which the runs of a day begin.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DayClock {
    /// Seconds after midnight.
    pub begin_secs: f64,
    /// Whether it is that of UTC, as the times of the file have zones.
    pub is_utc: bool,
}

/// The orders of a day.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Day {
    /// The file, for messages.
    pub file: String,
    /// The orders, as the fleet manager reads them: CSV.
    pub timetable: String,
    /// The names of their stops.
    pub stops: BTreeSet<String>,
    /// The number of orders.
    pub orders: usize,
    /// Whether the file has the time at a stop.
    pub has_dwell: bool,
    /// The time of day at which simulated time begins, if the file has such times.
    pub clock: Option<DayClock>,
    /// The time of the last order, in seconds.
    pub last_secs: f64,
    /// Orders for each of the file.
    pub scale: f64,
    /// Seconds by which all orders come later.
    pub shift_secs: f64,
    /// The block of which each seed's day is drawn, in seconds; `None` for the day as it is.
    pub block_secs: Option<f64>,
}

impl Day {
    /// Returns the day in words.
    pub fn in_words(&self) -> String {
        let Self { file, orders, scale, shift_secs, block_secs, .. } = self;
        let times = if *scale == 1.0 { String::new() } else { format!(" × {scale}") };
        let shift = match *shift_secs {
            0.0 => String::new(),
            secs if secs < 0.0 => format!(", {:.0} min earlier", -secs / 60.0),
            secs => format!(", {:.0} min later", secs / 60.0),
        };
        let days = match (block_secs, *scale == 1.0) {
            (Some(secs), _) => format!(
                "each seed has a day of the same kind, drawn from blocks of {:.0} min",
                secs / 60.0
            ),
            (None, true) => "as they are, the same for each seed".to_owned(),
            (None, false) => "the further or missing ones drawn at random by each seed".to_owned(),
        };
        let at_once = match self.last_secs {
            0.0 if *orders > 1 => ", all at time 0, as the file gives no other time",
            _ => "",
        };
        format!("the {orders} orders of {file}{times}{at_once}{shift}, {days}")
    }

    /// Returns the time from which on no order comes, in whole seconds.
    pub fn end_secs(&self) -> u64 {
        let block_secs = self.block_secs.unwrap_or(0.0);
        // The last block may be the one before, which is moved.
        let last_secs = match block_secs > 0.0 {
            true => ((self.last_secs / block_secs).floor() + 1.0) * block_secs,
            false => self.last_secs,
        };
        (last_secs + self.shift_secs).min(LATEST_SECS).ceil() as u64
    }

    /// Returns the day as a load, with what a given one says of stops, stations and storages.
    fn load(&self, given: Option<&Load>) -> Load {
        let mut load = given.map(Load::without_orders).unwrap_or_default();
        load.set_timetable(self.timetable.clone());
        load.rest.insert("scale".to_owned(), self.scale.into());
        load.rest.insert("shift".to_owned(), self.shift_secs.into());
        load.rest.extend(self.block_secs.map(|secs| ("resample".to_owned(), secs.into())));
        load
    }
}

impl Variant {
    /// Replaces the load by the orders of a day.
    ///
    /// # Errors
    /// [`PlanError::CutOffStops`] if a stop isn't on the roads that can be used, or as
    /// [`read`](Self::read).
    pub fn with_day(mut self, day: &Arc<Day>) -> Result<Self, PlanError> {
        let given = self.setup.load.take().filter(|_| !self.is_load_made_up);
        if self.is_load_made_up {
            if let Manager::BuiltIn(args) = &mut self.manager {
                args.retain(|arg| arg != IN_TURN);
            }
            self.is_load_made_up = false;
        }
        self.other_stops = None;
        self.setup = Setup { load: Some(day.load(given.as_ref())), ..self.setup };
        (self.load, self.day) = (day.in_words(), Some(Arc::clone(day)));
        self.set_roads()?;
        Ok(self)
    }

    /// The time of day at which its runs begin, if that is known.
    pub fn clock(&self) -> Option<DayClock> {
        self.day.as_ref()?.clock
    }

    /// The end of its runs.
    pub fn ending(&self) -> Ending {
        if self.day.is_some() { Ending::AfterOrders } else { Ending::AtTime }
    }
}
