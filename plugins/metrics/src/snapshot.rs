//! A fleet at one moment: what the exporter, the CSV file and `top` are three views of.

use std::sync::Arc;
use std::time::Duration;

use regatta_plugin::FleetName;
use regatta_plugin::contact::{ContactHeader, ContactRecord};
use regatta_plugin::frame::ClockState;

use crate::census::Census;
use crate::histogram::{Histogram, Spread};

/// All that is known of a fleet.
#[derive(Clone, Debug)]
pub struct Snapshot {
    /// Its name.
    pub fleet: FleetName,
    /// What this reader has seen since it started.
    pub totals: Totals,
    /// The producer's run; `None` while there is no producer.
    pub run: Option<Run>,
    /// What a collision checker says of that run.
    pub collisions: Collisions,
    /// Processes that have a place in the fleet.
    pub processes: Vec<Process>,
}

/// What a reader has seen since it started, over all runs.
#[derive(Clone, Copy, Debug, Default)]
pub struct Totals {
    /// Frames read, those included that a producer publishes only to show that its clock was stopped, say.
    pub frames_read: u64,
    /// Frames published in between that were not read.
    pub frames_skipped: u64,
    /// Metres that all robots together have driven: the mean of their speeds at two frames, times the simulated time between.
    pub driven_metres: f64,
    /// Messages that could not be read.
    pub read_errors: u64,
    /// Cost of the ticks whose frames were read.
    pub tick_cost: Histogram,
    /// Jitter of the ticks whose frames were read one after the other.
    pub jitter: Histogram,
    /// Time from publishing a frame to reading it.
    pub frame_age: Histogram,
}

/// A producer's run, by its newest frame.
#[derive(Clone, Copy, Debug)]
pub struct Run {
    /// Differs between any two runs.
    pub run_id: u64,
    /// Ticks since the start.
    pub tick: u64,
    /// Simulated time since the start.
    pub sim_time: Duration,
    /// When the newest frame was published, since the Unix epoch.
    pub wall_time: Duration,
    /// What the clock is doing.
    pub clock: ClockState,
    /// Wanted simulated seconds per wall second; infinite for as fast as possible.
    pub speed: f32,
    /// Simulated time of one tick.
    pub tick_period: Duration,
    /// Ticks that ended after their deadline.
    pub late_ticks: u64,
    /// Simulated seconds per wall second over the last second or so, if there were frames enough to tell.
    pub real_time_factor: Option<f64>,
    /// Robots by state, and their speed.
    pub census: Census,
}

/// What a collision checker says of the newest run, if there is one that keeps up.
#[derive(Clone, Debug, Default)]
pub struct Collisions {
    /// From the column `collision`.
    pub robots: Option<RobotLevels>,
    /// From the contacts.
    pub pairs: Option<ContactHeader>,
    /// The first pairs, those that touch before those that may.
    pub list: Arc<[ContactRecord]>,
}

/// Robots by level of collision, at one tick.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RobotLevels {
    /// The tick that was checked.
    pub tick: u64,
    /// Robots that may collide.
    pub possible: u64,
    /// Robots that touch another.
    pub touching: u64,
}

impl Collisions {
    /// The newest tick that was checked.
    pub fn tick(&self) -> Option<u64> {
        let ticks = [self.robots.map(|robots| robots.tick), self.pairs.map(|pairs| pairs.tick)];
        ticks.into_iter().flatten().max()
    }
}

/// A process that has a place in a fleet.
#[derive(Clone, Debug, PartialEq)]
pub struct Process {
    /// The name that it joined by.
    pub name: String,
    /// Its id.
    pub pid: u32,
    /// Whether it is stopped (`SIGSTOP`).
    pub stopped: bool,
    /// Memory in its shared-memory segments, in bytes.
    pub shared_bytes: u64,
    /// Resident memory, the shared memory that it uses included, in bytes.
    pub resident_bytes: u64,
    /// Processor time since it started, in seconds.
    pub cpu_seconds: f64,
    /// Processor seconds per second since the sample before: 1 is one core in full use.
    pub cpu_cores: f64,
}

/// How long things took since the last look.
#[derive(Clone, Copy, Debug, Default)]
pub struct Lap {
    /// Cost of a tick.
    pub tick_cost: Spread,
    /// Jitter of a tick.
    pub jitter: Spread,
    /// Time from publishing a frame to reading it.
    pub frame_age: Spread,
}
