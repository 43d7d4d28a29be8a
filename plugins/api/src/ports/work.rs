//! Both sides of the figures of a fleet's work: the fleet manager publishes them, any process reads
//! them.

use super::error::{OpenError, PublishError, ReadError};
use super::receive::Newest;
use super::services;
use super::slices::SliceSender;
use crate::process::join::Participant;
use crate::records::work::{WorkFigures, WorkHeader};

/// Publishes the figures of a fleet's work. A fleet has one such publisher at a time.
#[derive(Debug)]
pub struct WorkPublisher {
    sender: SliceSender<WorkFigures, WorkHeader>,
}

impl WorkPublisher {
    /// Opens a fleet's figures for writing.
    ///
    /// # Errors
    /// [`OpenError::Taken`] if a live process publishes them, [`OpenError::OtherVersion`] if
    /// the fleet uses another contract, else [`OpenError::SharedMemory`].
    pub fn open_on(participant: &Participant) -> Result<Self, OpenError> {
        Ok(Self { sender: SliceSender::open_only(&services::WORK, participant)? })
    }

    /// Publishes the figures of a run up to a tick.
    ///
    /// # Errors
    /// [`PublishError`] when shared memory is full.
    pub fn publish(
        &mut self,
        run_id: u64,
        tick: u64,
        figures: WorkFigures,
    ) -> Result<(), PublishError> {
        let header = WorkHeader { run_id, tick, ..WorkHeader::default() };
        self.sender.publish_unless_full(header, &[figures])
    }

    /// The number of readers; without any, there is no need to compute figures.
    pub fn readers(&self) -> usize {
        self.sender.readers()
    }

    /// Gives the newest figures to readers that have joined since. Publishing does so as well.
    pub fn update(&self) {
        self.sender.update();
    }
}

/// Reads the newest figures of a fleet's work.
///
/// ```
/// use regatta_plugin::work::WorkFigures;
/// use regatta_plugin::{Participant, Result, WorkPublisher, WorkReader};
///
/// # fn main() -> Result {
/// # let fleet = format!("doc-work-{}", std::process::id()).parse()?;
/// let participant = Participant::join(&fleet, "manager")?;
/// let mut publisher = WorkPublisher::open_on(&participant)?;
/// let mut reader = WorkReader::open_on(&participant)?;
/// let run_id = 7;
/// publisher.publish(run_id, 100, WorkFigures { finished: 12, ..WorkFigures::default() })?;
/// assert!(reader.take()?);
/// assert_eq!(reader.of_run(run_id).map(|figures| figures.finished), Some(12));
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct WorkReader {
    figures: Newest<WorkFigures, WorkHeader>,
}

impl WorkReader {
    /// Opens a fleet's figures, whether or not a process publishes them yet.
    ///
    /// # Errors
    /// As [`Subscriber::open`](crate::Subscriber::open).
    pub fn open_on(participant: &Participant) -> Result<Self, OpenError> {
        Ok(Self { figures: Newest::open(&services::WORK, participant)? })
    }

    /// Takes the newest figures, and returns whether there were some that this hasn't taken yet.
    ///
    /// # Errors
    /// [`ReadError`] if the connection is broken.
    pub fn take(&mut self) -> Result<bool, ReadError> {
        self.figures.take_newest()
    }

    /// The figures that were taken last, with their run and tick.
    pub fn newest(&self) -> Option<(&WorkHeader, &WorkFigures)> {
        let (header, figures) = self.figures.held()?;
        Some((header, figures.first()?))
    }

    /// The figures of a run, as of the sample that was taken last.
    pub fn of_run(&self, run_id: u64) -> Option<&WorkFigures> {
        self.newest().filter(|(header, _)| header.run_id == run_id).map(|(_, figures)| figures)
    }

    /// Whether a process publishes them. One that was killed counts until another process joins the
    /// fleet.
    pub fn has_publisher(&self) -> bool {
        self.figures.has_publisher()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::FleetName;

    #[test]
    fn a_late_reader_gets_the_figures_of_its_run_from_the_one_publisher() {
        let name: FleetName = format!("unit-work-{}", std::process::id()).parse().expect("a name");
        let participant = Participant::join(&name, "test").expect("joined");
        let mut publisher = WorkPublisher::open_on(&participant).expect("a publisher");
        let second = WorkPublisher::open_on(&participant).expect_err("one at a time");
        assert!(matches!(second, OpenError::Taken { .. }), "{second}");
        let figures = WorkFigures { orders_per_hour: 42.0, busy: 3, ..WorkFigures::default() };
        publisher.publish(5, 9, figures).expect("published");
        let mut reader = WorkReader::open_on(&participant).expect("a reader");
        assert_eq!((publisher.readers(), reader.has_publisher()), (1, true));
        publisher.update();
        assert!(reader.take().expect("readable") && !reader.take().expect("readable"));
        assert_eq!((reader.of_run(5), reader.of_run(6)), (Some(&figures), None));
    }

    #[test]
    fn without_a_finished_order_there_are_no_service_times() {
        let none = WorkFigures { service_p50_secs: f32::NAN, ..WorkFigures::default() };
        assert_eq!(none.service_secs(), None);
        let some = WorkFigures { service_p99_secs: 9.0, ..WorkFigures::default() };
        assert_eq!(some.service_secs(), Some([0.0, 9.0]));
    }
}
