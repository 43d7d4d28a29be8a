//! A plugin that writes what robots waited for.

use std::path::PathBuf;

use regatta_plugin::{Frame, Plugin, Result, World};
use serde_json::json;

use crate::queues::{Queues, Track};
use crate::report;

struct QueueObserver {
    file: PathBuf,
    /// The ids of the edges.
    ids: Vec<u32>,
    queues: Queues,
}

/// Returns a plugin that writes to a file, at its end, the edges that robots were kept out of:
/// `{"edges": [{"edge": ID, "caused_secs": SECONDS}]}`, with robot seconds of the robots that were
/// kept out and of those behind them.
pub fn queue_observer(file: PathBuf) -> impl Plugin {
    QueueObserver { file, ids: Vec::new(), queues: Queues::default() }
}

impl Plugin for QueueObserver {
    fn on_world(&mut self, world: &World<'_>) -> Result {
        let track = |edge: &regatta_plugin::world::EdgeRecord| Track {
            origin: edge.origin,
            destination: edge.destination,
            length: edge.length,
        };
        self.ids = world.edges().iter().map(|edge| edge.id).collect();
        self.queues = Queues::new(world.edges().iter().map(track).collect());
        Ok(())
    }

    fn on_frame(&mut self, frame: &Frame<'_>) -> Result {
        self.queues.add(&frame.columns(), frame.sim_time().as_secs_f64());
        Ok(())
    }

    fn on_stop(&mut self) -> Result {
        let caused = self.queues.caused_secs();
        let edges = self.ids.iter().zip(caused).filter(|(_, secs)| *secs > 0.0);
        let edges: Vec<_> =
            edges.map(|(edge, secs)| json!({"edge": edge, "caused_secs": secs})).collect();
        report::write(&self.file, &format!("{:#}\n", json!({ "edges": edges })))
    }
}
