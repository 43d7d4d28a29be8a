//! The last minutes, in slots of half a second: what the sparklines show.

use std::collections::VecDeque;
use std::time::Duration;

use crate::snapshot::{Lap, Snapshot};

/// Time that one bar of a sparkline stands for.
pub const SLOT: Duration = Duration::from_millis(500);

/// Slots to keep: as many as the widest terminal has columns.
const KEPT: usize = 1000;

/// What happened in one slot. A figure is `None` if nothing was measured.
#[derive(Clone, Copy, Debug, Default)]
pub struct Slot {
    /// Mean and longest cost of a tick, in seconds.
    pub tick_cost: Option<(f64, f64)>,
    /// Mean and longest jitter, in seconds.
    pub jitter: Option<(f64, f64)>,
    /// Mean and longest time from publishing a frame to reading it, in seconds.
    pub frame_age: Option<(f64, f64)>,
    /// Simulated seconds per wall second.
    pub real_time_factor: Option<f64>,
    /// The wanted ones; infinite for as fast as possible.
    pub wanted: f64,
    /// Wall time that there was for a tick, in seconds; 0 if it was to be as fast as possible.
    pub budget: f64,
}

/// The slots, oldest first.
#[derive(Clone, Debug, Default)]
pub struct History {
    slots: VecDeque<Slot>,
}

impl History {
    /// Adds a slot.
    pub fn add(&mut self, lap: &Lap, snapshot: &Snapshot) {
        if self.slots.len() == KEPT {
            self.slots.pop_front();
        }
        let speed = snapshot.run.map_or(1.0, |run| f64::from(run.speed));
        let period = snapshot.run.map_or(0.0, |run| run.tick_period.as_secs_f64());
        self.slots.push_back(Slot {
            tick_cost: lap.tick_cost.mean_and_max(),
            jitter: lap.jitter.mean_and_max(),
            frame_age: lap.frame_age.mean_and_max(),
            real_time_factor: snapshot.run.and_then(|run| run.real_time_factor),
            wanted: speed,
            budget: period / speed,
        });
    }

    /// The newest slot.
    pub fn newest(&self) -> Slot {
        self.slots.back().copied().unwrap_or_default()
    }

    /// All slots, newest first.
    pub fn newest_first(&self) -> impl Iterator<Item = &Slot> {
        self.slots.iter().rev()
    }
}
