//! The outcome of a job, and the figures that a study takes from it.

mod backlog;
mod example;
mod measured;
mod stall;
mod survival;
mod time_split;

use std::collections::BTreeMap;

use regatta_meter::Figures;
use serde::{Deserialize, Serialize};

use crate::job::{Ending, JobId};

pub use backlog::{Backlog, HOUR_SECS, HourOrders, hours};
pub use example::{Example, examples};
pub(crate) use measured::CONTACT;
pub use measured::{Measured, RunEnd, Service};
pub use stall::{FleetState, SeenStates, Stall, StallKind, stalls};
pub use time_split::{CHARGING, Grouping, ORDER_PARTS, OrderTime, ROBOT_PARTS, STORAGE, by_group};

/// The result file of a job.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// The job.
    pub job: JobId,
    /// The engine's digest of all frames, 32 hexadecimal digits: equal wherever the job runs.
    pub digest: String,
    /// The meter's figures of the fleet.
    pub figures: Figures,
    /// The numbers of the validator's findings by kind; kinds without findings are left out.
    pub findings: BTreeMap<String, u64>,
    /// The first of them of each kind; none in a result of an earlier version.
    #[serde(default)]
    pub examples: BTreeMap<String, Example>,
    /// The times in which robots with orders made no progress.
    pub stalls: Vec<Stall>,
    /// The edges where robots waited.
    pub edges: Vec<EdgeOutcome>,
    /// The end of what it measures.
    #[serde(default)]
    pub ending: Ending,
}

/// An edge of a run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct EdgeOutcome {
    /// The id in the layout.
    pub edge: u32,
    /// Robot seconds in which robots stood there and waited to drive on.
    pub waiting_secs: f64,
    /// Robot seconds in which robots waited, wherever they stood, because they or the robots before
    /// them were kept out of it.
    pub caused_secs: f64,
    /// Robots that entered it, an hour.
    pub entered_per_hour: f64,
}

impl EdgeOutcome {
    /// Returns an edge where no robot was.
    pub fn new(edge: u32) -> Self {
        Self { edge, waiting_secs: 0.0, caused_secs: 0.0, entered_per_hour: 0.0 }
    }
}

/// The figures of an observer by edges.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct EdgeFigures<T> {
    /// The figures of each edge.
    pub edges: Vec<T>,
}

/// The traffic of an edge.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct EdgeTraffic {
    /// The id in the layout.
    pub edge: u32,
    /// Robot seconds of waiting there.
    pub waiting_secs: f64,
    /// Robots that entered it, an hour.
    pub entered_per_hour: f64,
}

/// The waiting that an edge has caused.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct EdgeQueues {
    /// The id in the layout.
    pub edge: u32,
    /// Robot seconds of waiting for it.
    pub caused_secs: f64,
}

/// Returns the edges on which robots were, or that they were kept out of, from the figures of the
/// observers.
pub fn edges(
    traffic: EdgeFigures<EdgeTraffic>,
    queues: EdgeFigures<EdgeQueues>,
) -> Vec<EdgeOutcome> {
    let caused: BTreeMap<u32, f64> =
        queues.edges.into_iter().map(|edge| (edge.edge, edge.caused_secs)).collect();
    let mut edges = Vec::new();
    for EdgeTraffic { edge, waiting_secs, entered_per_hour } in traffic.edges {
        let caused_secs = caused.get(&edge).copied().unwrap_or_default();
        if waiting_secs > 0.0 || caused_secs > 0.0 || entered_per_hour > 0.0 {
            edges.push(EdgeOutcome { edge, waiting_secs, caused_secs, entered_per_hour });
        }
    }
    edges
}

/// The most periods of a run: those of a week, of a second each.
const MOST_PERIODS: f64 = 604_800.0;
impl Outcome {
    /// The number of the validator's findings of a kind.
    fn count(&self, kind: &str) -> u64 {
        self.findings.get(kind).copied().unwrap_or(0)
    }

    /// Whether the periods of the figures can be added up: a result may come from anywhere.
    pub fn is_plausible(&self) -> bool {
        let periods = self.figures.secs / self.figures.period_secs;
        self.figures.period_secs > 0.0 && (0.0..=MOST_PERIODS).contains(&periods)
    }
}

/// Returns a time as minutes and seconds.
fn clock(secs: f64) -> String {
    let secs = secs.round().max(0.0) as u64;
    format!("{}:{:02} min", secs / 60, secs % 60)
}
