//! Where it jams: the heat map of edges, hot spots, and the figures of the fleet over time. A background thread reads frames,
//! contacts and what the traffic plugin publishes, and reduces them to lists to draw and figures to show, so that no picture waits
//! for it.

pub mod heat;
pub mod inbox;
pub mod series;
pub mod spots;
mod watcher;

use std::sync::Arc;
use std::sync::mpsc::{self, Sender};
use std::thread::JoinHandle;

use regatta_plugin::traffic::{EdgeTraffic, TRAFFIC_PERIODS};
use regatta_plugin::{FleetName, Result};

use heat::{Heat, HeatFacts, HeatMap};
use series::Sample;
use spots::Spot;

/// What is to be watched.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Watch {
    /// The heat map to work out.
    pub heat: Option<Heat>,
    /// The edge whose figures are wanted, by its index in the world.
    pub edge: Option<u32>,
    /// Whether hot spots and figures over time are kept.
    pub history: bool,
}

impl Watch {
    fn is_idle(&self) -> bool {
        *self == Self::default()
    }
}

/// What is known of an edge.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EdgeFacts {
    /// Its index in the world.
    pub edge: u32,
    /// What happened there in each period; `None` without a traffic plugin.
    pub traffic: Option<[EdgeTraffic; TRAFFIC_PERIODS]>,
    /// The number of robots that wait there now.
    pub waiting: u32,
}

/// What the interface shows of all this.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct JamFacts {
    /// The scale of the heat map; `None` as long as there is none.
    pub heat: Option<HeatFacts>,
    /// The selected edge.
    pub edge: Option<EdgeFacts>,
    /// The hot spots, the worst first.
    pub spots: Arc<[Spot]>,
    /// The figures over time, the oldest first.
    pub series: Arc<[Sample]>,
}

/// The hot spots, the worst one first, and the figures over time.
pub type History = (Arc<[Spot]>, Arc<[Sample]>);

/// What was found since the report before.
#[derive(Clone, Debug, Default)]
pub struct JamReport {
    /// Another heat map; `Some(None)` if there is none any more.
    pub heat: Option<Option<HeatMap>>,
    /// What is known of the watched edge.
    pub edge: Option<EdgeFacts>,
    /// The hot spots and the figures over time, if there are newer ones.
    pub history: Option<History>,
}

/// A running thread that watches where it jams. Dropping it ends the thread.
#[derive(Debug)]
pub struct JamWatch {
    changes: Option<Sender<Watch>>,
    thread: Option<JoinHandle<()>>,
}

impl JamWatch {
    /// Starts the thread, which watches nothing at first. `report` gets what it finds, and returns whether it wants more.
    ///
    /// # Errors
    /// If the system can't start a thread.
    pub fn start(
        fleet: &FleetName,
        mut report: impl FnMut(Result<JamReport>) -> bool + Send + 'static,
    ) -> std::io::Result<Self> {
        let (changes, changed) = mpsc::channel();
        let fleet = fleet.clone();
        let thread = std::thread::Builder::new().name("jams".into()).spawn(move || {
            if let Err(error) = watcher::run(&fleet, &changed, &mut |found| report(Ok(found))) {
                report(Err(error));
            }
        })?;
        Ok(Self { changes: Some(changes), thread: Some(thread) })
    }

    /// Sets what is watched from now on.
    pub fn watch(&self, watch: Watch) {
        if let Some(changes) = &self.changes {
            // Fails only after the thread has reported its error.
            let _ = changes.send(watch);
        }
    }
}

impl Drop for JamWatch {
    fn drop(&mut self) {
        self.changes = None;
        if let Some(thread) = self.thread.take() {
            // The result is an error only if the thread panicked, and the panic has been printed.
            let _ = thread.join();
        }
    }
}
