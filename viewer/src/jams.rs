//! Where it jams: the heat map of edges, hot spots, and the figures of the fleet over time. A
//! background thread reads frames, contacts and what the traffic plugin publishes, and reduces them
//! to lists to draw and figures to show, so that no picture waits for it.

mod watcher;

use std::sync::Arc;
use std::sync::mpsc::Receiver;

use regatta_interface::jams::{EdgeFacts, Known, NodeFacts, Spot};
use regatta_plugin::history::FleetSample;
use regatta_plugin::{FleetName, Participant, Result};
use regatta_scene::heat::{Heat, HeatMap};

use crate::watching::Watched;
use watcher::Watcher;

/// What is to be watched.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Watch {
    /// The heat map to work out.
    pub heat: Option<Heat>,
    /// The edges whose figures are wanted, by their indices in the world: the selected one, and the
    /// one under the pointer.
    pub edges: Vec<u32>,
    /// The node whose robots are wanted, by its index in the world.
    pub node: Option<u32>,
    /// Whether hot spots and figures over time are kept.
    pub history: bool,
}

impl Watched for Watch {
    type Report = JamReport;

    const THREAD: &'static str = "jams";

    fn is_idle(&self) -> bool {
        *self == Self::default()
    }

    fn run(
        fleet: &FleetName,
        changed: &Receiver<Self>,
        report: &mut dyn FnMut(JamReport) -> bool,
    ) -> Result {
        watcher::run(fleet, changed, report)
    }
}

/// Reads where it jams at once, with the newest frame, for programs that wait for it.
pub struct JamReader(Watcher);

impl JamReader {
    /// Opens what a fleet publishes.
    ///
    /// # Errors
    /// If the fleet can't be read.
    pub fn open(fleet: &FleetName) -> Result<Self> {
        Ok(Self(Watcher::open(&Participant::join(fleet, "viewer-jams")?)?))
    }

    /// Returns what is new with the newest frame.
    ///
    /// # Errors
    /// If the fleet can't be read.
    pub fn read(&mut self, watch: &Watch) -> Result<JamReport> {
        self.0.look_now(watch)
    }
}

/// The hot spots, the worst one first, the figures over time, and the part of the run that they are
/// about.
pub type History = (Arc<[Spot]>, Arc<[FleetSample]>, Known);

/// Moves a history by some seconds: from simulated time to that of a recording's clock.
#[must_use]
pub fn moved((spots, series, known): History, secs: f64) -> History {
    if secs == 0.0 {
        return (spots, series, known);
    }
    let spot = |spot: &Spot| Spot { seen: spot.seen.map(|at| at + secs), ..spot.clone() };
    let sample = |sample: &FleetSample| FleetSample { secs: sample.secs + secs, ..*sample };
    let (from_secs, until_secs) = (known.from_secs + secs, known.until_secs + secs);
    let known = Known { from_secs, until_secs, ..known };
    (spots.iter().map(spot).collect(), series.iter().map(sample).collect(), known)
}

/// What was found since the report before.
#[derive(Clone, Debug, Default)]
pub struct JamReport {
    /// Another heat map; `Some(None)` if there is none any more.
    pub heat: Option<Option<HeatMap>>,
    /// What is known of the watched edges.
    pub edges: Vec<EdgeFacts>,
    /// What is known of the watched node.
    pub node: Option<NodeFacts>,
    /// The hot spots and the figures over time, if there are newer ones.
    pub history: Option<History>,
}
