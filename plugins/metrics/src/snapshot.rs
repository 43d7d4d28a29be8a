//! A snapshot of a fleet, of which the exporter's page, the CSV file and `regatta top` are views.

use std::sync::Arc;
use std::time::Duration;

use regatta_plugin::FleetName;
use regatta_plugin::activity::Activity;
use regatta_plugin::contact::{ContactHeader, ContactRecord};
use regatta_plugin::frame::ClockState;
use regatta_plugin::traffic::EdgeTraffic;
use regatta_plugin::work::WorkFigures;

use crate::durations::{DurationStats, Histogram, TimeSummary};
use crate::state_counts::StateCounts;
use crate::work::Effort;

/// The state of a fleet at one moment.
#[derive(Clone, Debug)]
pub struct Snapshot {
    /// Name of the fleet.
    pub fleet: FleetName,
    /// Totals since this reader started.
    pub totals: Totals,
    /// Run of the producer; `None` while there is no producer.
    pub run: Option<Run>,
    /// Results of a collision checker for that run.
    pub collisions: Collisions,
    /// Work of a fleet manager for that run; `None` while none publishes.
    pub work: Option<Work>,
    /// Edges at which robots waited the longest in the last ten minutes, the worst one first;
    /// `None` while no plugin publishes traffic.
    pub jams: Option<Arc<[Jam]>>,
    /// Processes that participate in the fleet.
    pub processes: Vec<Process>,
}

impl Snapshot {
    /// Returns the snapshot of a fleet of which nothing is known.
    pub fn of(fleet: &FleetName) -> Self {
        Self {
            fleet: fleet.clone(),
            totals: Totals::default(),
            run: None,
            collisions: Collisions::default(),
            work: None,
            jams: None,
            processes: Vec::new(),
        }
    }
}

/// An edge at which robots waited.
#[derive(Clone, Debug, PartialEq)]
pub struct Jam {
    /// Id of the edge in the route graph.
    pub edge: u32,
    /// Its name; empty if it has none.
    pub name: Arc<str>,
    /// Its figures of the last ten minutes.
    pub figures: EdgeTraffic,
}

/// Totals since the reader started, over all runs.
#[derive(Clone, Copy, Debug, Default)]
pub struct Totals {
    /// Number of frames read, including those that a producer publishes without a tick, for example
    /// to show a pause.
    pub frames_read: u64,
    /// Number of frames published in between that were not read.
    pub frames_skipped: u64,
    /// Distance that all robots together have driven, in metres: the mean of their speeds at two
    /// frames, times the simulated time between.
    pub driven_metres: f64,
    /// Number of messages that could not be read.
    pub read_errors: u64,
    /// Cost of the ticks whose frames were read.
    pub tick_cost: Histogram,
    /// Jitter of the ticks whose frames were read consecutively.
    pub jitter: Histogram,
    /// Time from publishing a frame to reading it.
    pub frame_age: Histogram,
}

/// A producer's run, as of its newest frame.
#[derive(Clone, Copy, Debug)]
pub struct Run {
    /// Id that differs between any two runs.
    pub run_id: u64,
    /// Number of ticks since the start.
    pub tick: u64,
    /// Number of frames published since the start.
    pub frames: u64,
    /// Simulated time since the start.
    pub sim_time: Duration,
    /// Time at which the newest frame was published, since the Unix epoch.
    pub wall_time: Duration,
    /// State of the clock.
    pub clock: ClockState,
    /// Wanted simulated seconds per wall second; infinite for as fast as possible.
    pub speed: f32,
    /// Simulated time of one tick.
    pub tick_period: Duration,
    /// Number of ticks that ended after their deadline.
    pub late_ticks: u64,
    /// Simulated seconds per wall second over about the last second; `None` with too few frames.
    pub real_time_factor: Option<f64>,
    /// Number of robots in each state, and their speed.
    pub state_counts: StateCounts,
}

impl Run {
    /// Whether the clock makes ticks.
    pub fn runs(&self) -> bool {
        matches!(self.clock, ClockState::Running | ClockState::WarmingUp)
    }
}

/// Results of a collision checker for the newest run, if one runs and keeps up.
#[derive(Clone, Debug, Default)]
pub struct Collisions {
    /// Robots by level, from the column `collision`.
    pub robots: Option<RobotLevels>,
    /// Header of the contacts.
    pub pairs: Option<ContactHeader>,
    /// The first pairs: touching ones, then possible ones.
    pub list: Arc<[ContactRecord]>,
}

/// Numbers of robots by level of collision, at one tick.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RobotLevels {
    /// Tick that was checked.
    pub tick: u64,
    /// Number of robots that may collide.
    pub possible: u64,
    /// Number of robots that touch another.
    pub touching: u64,
}

impl Collisions {
    /// Returns the newest tick that was checked.
    pub fn tick(&self) -> Option<u64> {
        let ticks = [self.robots.map(|robots| robots.tick), self.pairs.map(|pairs| pairs.tick)];
        ticks.into_iter().flatten().max()
    }
}

/// The work of a fleet manager in the newest run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Work {
    /// Number of robots of each activity, in the order of [`Activity::ALL`].
    pub robots: [u64; Activity::ALL.len()],
    /// Figures of its orders.
    pub orders: OrderFigures,
    /// The figures of the run that it publishes, if it does.
    pub run: Option<WorkFigures>,
    /// Distance and busy time of its robots.
    pub effort: Effort,
    /// Wall time that it spends on a frame, of the frames whose columns were read.
    pub cycle: TimeSummary,
}

/// Figures of transport orders, from the order log of a run since this reader began to read it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OrderFigures {
    /// Number of orders that were created.
    pub created: u64,
    /// Number of orders that were finished.
    pub finished: u64,
    /// Number of orders that were given up.
    pub failed: u64,
    /// Number of orders that were cancelled.
    pub cancelled: u64,
    /// Number of orders that are not over; `None` unless the whole log of the run was read.
    pub open: Option<u64>,
    /// Orders finished per second of simulated time, over its last hour; `None` in the first
    /// minute.
    pub finished_per_second: Option<f64>,
    /// Simulated time from the creation of an order to its end, of finished orders.
    pub service: TimeSummary,
    /// Simulated time from the creation of an order to its first assignment to a robot.
    pub waiting: TimeSummary,
    /// Number of ticks whose records are missing, in whole or in part.
    pub gaps: u64,
    /// Simulated time from which orders are counted, in seconds; `None` if that is the start of the
    /// run.
    pub since_secs: Option<f64>,
}

/// A process that participates in a fleet.
#[derive(Clone, Debug, PartialEq)]
pub struct Process {
    /// Name under which it joined.
    pub name: String,
    /// Process id.
    pub pid: u32,
    /// Whether it is stopped (`SIGSTOP`).
    pub stopped: bool,
    /// Size of its shared-memory segments, in bytes.
    pub shared_bytes: u64,
    /// Resident memory, including the shared memory that it uses, in bytes.
    pub resident_bytes: u64,
    /// Processor time of all processes of this name, in seconds since the first of them started: it
    /// includes those that have ended since, so that it never decreases while one is running.
    pub cpu_seconds: f64,
    /// Processor seconds per second since the previous sample: 1 is one core in full use.
    pub cpu_cores: f64,
}

/// Statistics of durations since the previous call of
/// [`take_interval`](crate::aggregator::Aggregator::take_interval).
#[derive(Clone, Copy, Debug, Default)]
pub struct IntervalStats {
    /// Cost of a tick.
    pub tick_cost: DurationStats,
    /// Jitter of a tick.
    pub jitter: DurationStats,
    /// Time from publishing a frame to reading it.
    pub frame_age: DurationStats,
}
