//! The history of a run so far, in bounded memory. The plugin or the replay that publishes it keeps
//! it, or a reader without either.

pub mod series;
pub mod spots;

use regatta_plugin::contact::{ContactHeader, ContactRecord};
use regatta_plugin::frame::Frame;
use regatta_plugin::history::FleetSample;
use series::Series;
use spots::Spots;

/// Hot spots and figures over time of a run.
#[derive(Clone, Debug, Default)]
pub struct RunHistory {
    /// The hot spots.
    pub spots: Spots,
    /// The figures over time.
    pub series: Series,
}

impl RunHistory {
    /// Adds a frame, with its contacts if they are known. Contacts of another run count as none.
    /// `published` are the values of the column `activity`, none where nobody publishes it.
    /// `throughput` returns the number of robots that enter an edge per hour, if that is known. It
    /// is called only if a sample is due.
    pub fn add(
        &mut self,
        frame: &Frame<'_>,
        contacts: Option<(&ContactHeader, &[ContactRecord])>,
        published: &[f32],
        throughput: impl FnOnce() -> Option<f32>,
    ) {
        let run_id = frame.run_id();
        let contacts = contacts.filter(|(header, _)| header.run_id == run_id);
        self.spots.add(frame, contacts.map_or(&[], |(_, pairs)| pairs));
        if self.series.wants(run_id, frame.sim_time().as_secs_f64()) {
            let sample = FleetSample {
                throughput: throughput().unwrap_or(f32::NAN),
                ..FleetSample::of(frame, published)
            };
            self.series
                .add(run_id, sample.with_touching(contacts.map(|(header, _)| header.touching)));
        }
    }
}
