//! The history of the run so far, published for readers that join later.

use std::time::{Duration, Instant};

use regatta_kit::RunHistory;
use regatta_plugin::column::ACTIVITY;
use regatta_plugin::history::HistoryHeader;
use regatta_plugin::{
    ColumnReader, ContactReader, Frame, HistoryPublisher, OpenError, Participant, Result,
};

/// The time between two publications, unless they take long.
const PUBLISH_EVERY: Duration = Duration::from_millis(500);
/// The pause after a publication is at least this many times its duration.
const PAUSES: u32 = 20;

/// Hot spots and figures over time, with their ports.
pub struct PublishedHistory {
    publisher: HistoryPublisher,
    contacts: ContactReader,
    activities: ColumnReader,
    run: RunHistory,
    /// The header of the newest frame.
    newest: HistoryHeader,
    /// Whether frames aren't published yet.
    is_due: bool,
    publish_at: Instant,
}

impl PublishedHistory {
    /// Opens the ports. Returns `None` if another process publishes the history.
    ///
    /// # Errors
    /// If shared memory fails.
    pub fn open(fleet: &Participant) -> Result<Option<Self>> {
        let publisher = match HistoryPublisher::open_on(fleet) {
            Ok(publisher) => publisher,
            Err(OpenError::Taken { .. }) => return Ok(None),
            Err(error) => return Err(error.into()),
        };
        Ok(Some(Self {
            publisher,
            contacts: ContactReader::open_on(fleet)?,
            activities: ColumnReader::open_on(fleet, ACTIVITY.name())?,
            run: RunHistory::default(),
            newest: HistoryHeader::default(),
            is_due: false,
            publish_at: Instant::now(),
        }))
    }

    /// Adds a frame. `throughput` is the number of robots that enter an edge, per hour, over the
    /// last minute, if it is known.
    ///
    /// # Errors
    /// If shared memory fails.
    pub fn add(&mut self, frame: &Frame<'_>, throughput: Option<f32>) -> Result {
        self.contacts.latest()?;
        let has_checker = self.contacts.has_publisher();
        let contacts = self.contacts.current().filter(|_| has_checker);
        let contacts = contacts.map(|contacts| (contacts.header, contacts.pairs));
        let published = self.activities.newest_of_run(frame.run_id())?;
        self.run.add(frame, contacts, published, || throughput);
        self.newest = HistoryHeader {
            run_id: frame.run_id(),
            tick: frame.tick(),
            sim_time_nanos: frame.header().sim_time_nanos,
            began_nanos: (self.run.spots.began().1 * 1e9) as u64,
            sequence: 0,
        };
        self.is_due = true;
        self.publish()
    }

    /// Publishes the history if there are frames that aren't published yet. Without readers they
    /// stay due, so that the first one gets all of it at once.
    ///
    /// # Errors
    /// If shared memory fails.
    pub fn publish(&mut self) -> Result {
        if !self.is_due || self.publisher.readers() == 0 {
            return Ok(());
        }
        let start = Instant::now();
        if start < self.publish_at {
            return Ok(());
        }
        self.is_due = false;
        let RunHistory { series, spots } = &self.run;
        self.publisher.publish(&self.newest, &series.samples, &spots.list())?;
        self.publish_at = Instant::now() + PUBLISH_EVERY.max(start.elapsed() * PAUSES);
        Ok(())
    }

    /// Passes the newest history to readers that have joined since.
    pub fn update(&self) {
        self.publisher.update();
    }
}
