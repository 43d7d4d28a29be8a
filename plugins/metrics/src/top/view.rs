//! The state that the screen draws, and the history of the last minutes.

use std::collections::VecDeque;
use std::time::Duration;

use regatta_plugin::FleetName;

use super::commands::Outcome;
use crate::snapshot::{IntervalStats, Snapshot};

/// The state that the screen draws.
#[derive(Debug)]
pub struct View {
    /// Snapshot of the fleet.
    pub snapshot: Snapshot,
    /// History of the last minutes.
    pub history: History,
    /// Reason why the processes can't be listed.
    pub process_error: Option<String>,
    /// Whether the list shows the edges at which robots wait, rather than collisions.
    pub shows_jams: bool,
    /// Number of collisions above the first line of the list.
    pub scroll: usize,
    /// Whether the help is shown.
    pub help: bool,
    /// Outcome of the last key.
    pub outcome: Option<Outcome>,
}

impl View {
    /// Creates the view of a fleet before its first frame.
    pub fn new(fleet: &FleetName) -> Self {
        Self {
            snapshot: Snapshot::of(fleet),
            history: History::default(),
            process_error: None,
            shows_jams: false,
            scroll: 0,
            help: false,
            outcome: None,
        }
    }

    /// Scrolls the collisions by a number of lines, at most to their end.
    pub fn scroll_by(&mut self, lines: isize) {
        let last = self.snapshot.collisions.list.len().saturating_sub(1);
        self.scroll = self.scroll.min(last).saturating_add_signed(lines).min(last);
    }
}

/// The duration of a slot: one bar of a sparkline.
pub const SLOT: Duration = Duration::from_millis(500);

/// The number of slots that are kept: as many as the widest terminal has columns.
const MAX_SLOTS: usize = 1000;

/// The figures of a slot. A figure is `None` if nothing was measured.
#[derive(Clone, Copy, Debug, Default)]
pub struct Slot {
    /// Mean and maximum cost of a tick, in seconds.
    pub tick_cost: Option<(f64, f64)>,
    /// Mean and maximum jitter, in seconds.
    pub jitter: Option<(f64, f64)>,
    /// Mean and maximum time from publishing a frame to reading it, in seconds.
    pub frame_age: Option<(f64, f64)>,
    /// Simulated seconds per wall second.
    pub real_time_factor: Option<f64>,
    /// Wanted simulated seconds per wall second; infinite for as fast as possible.
    pub wanted: f64,
    /// Wall time that is available for a tick, in seconds; 0 if it is to be as fast as possible.
    pub budget: f64,
}

/// The slots, oldest first.
#[derive(Clone, Debug, Default)]
pub struct History {
    slots: VecDeque<Slot>,
}

impl History {
    /// Adds a slot.
    pub fn add(&mut self, interval: &IntervalStats, snapshot: &Snapshot) {
        if self.slots.len() == MAX_SLOTS {
            self.slots.pop_front();
        }
        let speed = snapshot.run.map_or(1.0, |run| f64::from(run.speed));
        let period = snapshot.run.map_or(0.0, |run| run.tick_period.as_secs_f64());
        self.slots.push_back(Slot {
            tick_cost: interval.tick_cost.mean_and_max(),
            jitter: interval.jitter.mean_and_max(),
            frame_age: interval.frame_age.mean_and_max(),
            real_time_factor: snapshot.run.and_then(|run| run.real_time_factor),
            wanted: speed,
            budget: period / speed,
        });
    }

    /// Returns the newest slot.
    pub fn newest(&self) -> Slot {
        self.slots.back().copied().unwrap_or_default()
    }

    /// Returns all slots, newest first.
    pub fn newest_first(&self) -> impl Iterator<Item = &Slot> {
        self.slots.iter().rev()
    }
}
