//! Jams: the heat map of edges, hot spots, and the figures of the fleet over time. A worker reads
//! frames, contacts and the figures of the traffic plugin, and reduces them to lists to draw and
//! figures to show.

mod watcher;

use std::sync::Arc;
use std::time::Instant;

use regatta_interface::jams::{EdgeFacts, Known, NodeFacts, Spot};
use regatta_plugin::history::FleetSample;
use regatta_plugin::{Participant, Result};
use regatta_scene::heat::{Heat, HeatMap};

use crate::worker::Query;
use watcher::Watcher;

/// The figures to work out.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct JamQuery {
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

impl Query for JamQuery {
    type Report = JamReport;
    type Ports = Watcher;

    const THREAD: &'static str = "jams";

    fn is_idle(&self) -> bool {
        *self == Self::default()
    }

    fn is_urgent(&self, _: &Self) -> bool {
        false
    }

    fn open(participant: &Participant) -> Result<Watcher> {
        Watcher::open(participant)
    }

    fn due(watcher: &Watcher) -> Instant {
        watcher.look_at
    }

    fn poll(&self, watcher: &mut Watcher, at_once: bool) -> Result<Option<JamReport>> {
        if at_once {
            watcher.look_at = Instant::now();
        }
        watcher.look(self).map(Some)
    }

    fn nothing() -> JamReport {
        JamReport { heat: Some(None), ..JamReport::default() }
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
    let spots =
        spots.iter().map(|spot| Spot { seen: spot.seen.map(|at| at + secs), ..spot.clone() });
    let series = series.iter().map(|sample| FleetSample { secs: sample.secs + secs, ..*sample });
    let (from_secs, until_secs) = (known.from_secs + secs, known.until_secs + secs);
    (spots.collect(), series.collect(), Known { from_secs, until_secs, ..known })
}

/// The findings since the report before.
#[derive(Clone, Debug, Default)]
pub struct JamReport {
    /// Another heat map; `Some(None)` if there is none any more.
    pub heat: Option<Option<HeatMap>>,
    /// The figures of the watched edges.
    pub edges: Vec<EdgeFacts>,
    /// The figures of the watched node.
    pub node: Option<NodeFacts>,
    /// The hot spots and the figures over time, if there are newer ones.
    pub history: Option<History>,
}
