//! Publishes the history of the recorded run that is shown.

use regatta_plugin::history::HistoryHeader;
use regatta_plugin::{HistoryPublisher, Participant, PublishError};

use super::history::RecordedHistory;

/// The histories that were found, and the one that is published.
#[derive(Debug)]
pub(super) struct Histories {
    publisher: HistoryPublisher,
    /// One for each recorded run.
    found: Vec<RecordedHistory>,
    /// The run of the replay, and the recorded run that it shows.
    shown: (u64, u64),
    /// Whether the history of the shown run has changed since it was published.
    is_news: bool,
}

impl Histories {
    /// Opens the services. Returns `None`, and says so, if another process publishes the history,
    /// or shared memory fails.
    pub fn open(participant: &Participant) -> Option<Self> {
        let opened = HistoryPublisher::open_on(participant);
        let publisher = opened
            .inspect_err(|error| {
                regatta_plugin::tell!("replay: hot spots and plots are left out: {error}")
            })
            .ok()?;
        Some(Self { publisher, found: Vec::new(), shown: (0, 0), is_news: false })
    }

    /// Takes what is known now of a recorded run.
    pub fn take(&mut self, history: RecordedHistory) {
        let run_id = history.header.run_id;
        self.is_news |= run_id == self.shown.1;
        match self.found.iter_mut().find(|known| known.header.run_id == run_id) {
            Some(known) => *known = history,
            None => self.found.push(history),
        }
    }

    /// Publishes what is known of the recorded run that is shown, under the run of the replay, if
    /// that has changed.
    pub fn show(&mut self, run_id: u64, recorded_run: u64) -> Result<(), PublishError> {
        let shown = (run_id, recorded_run);
        self.is_news |= std::mem::replace(&mut self.shown, shown) != shown;
        self.publish()
    }

    /// Publishes what has changed, and connects readers that have joined.
    pub fn update(&mut self) -> Result<(), PublishError> {
        self.publish()?;
        self.publisher.update();
        Ok(())
    }

    fn publish(&mut self) -> Result<(), PublishError> {
        let (run_id, recorded_run) = self.shown;
        if !std::mem::take(&mut self.is_news) {
            return Ok(());
        }
        let Some(history) = self.found.iter().find(|known| known.header.run_id == recorded_run)
        else {
            return Ok(());
        };
        let header = HistoryHeader { run_id, ..history.header };
        self.publisher.publish(&header, &history.samples, &history.spots)
    }
}
