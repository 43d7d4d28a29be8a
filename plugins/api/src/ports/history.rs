//! Both sides of the history of a run: a plugin or a replay publishes it, any process reads it.

use super::error::{OpenError, PublishError, ReadError};
use super::receive::Newest;
use super::services;
use super::slices::SliceSender;
use crate::process::join::Participant;
use crate::records::history::{FleetSample, HistoryHeader, HotSpot};

/// Publishes the history of a fleet's run. A fleet has one such publisher at a time.
#[derive(Debug)]
pub struct HistoryPublisher {
    samples: SliceSender<FleetSample, HistoryHeader>,
    spots: SliceSender<HotSpot, HistoryHeader>,
}

impl HistoryPublisher {
    /// Opens a fleet's history for writing.
    ///
    /// # Errors
    /// [`OpenError::Taken`] if a live process publishes it, [`OpenError::OtherVersion`] if
    /// the fleet uses another contract, else [`OpenError::SharedMemory`].
    pub fn open_on(participant: &Participant) -> Result<Self, OpenError> {
        Ok(Self {
            samples: SliceSender::open_only(&services::HISTORY, participant)?,
            spots: SliceSender::open_only(&services::SPOTS, participant)?,
        })
    }

    /// Publishes all samples and all hot spots so far. Fills in the header's `sequence`.
    ///
    /// # Errors
    /// [`PublishError`] when shared memory is full.
    pub fn publish(
        &mut self,
        header: &HistoryHeader,
        samples: &[FleetSample],
        spots: &[HotSpot],
    ) -> Result<(), PublishError> {
        self.samples.publish(*header, samples)?;
        self.spots.publish(*header, spots)
    }

    /// The number of readers; without any, there is no need to publish.
    pub fn readers(&self) -> usize {
        self.samples.readers().max(self.spots.readers())
    }

    /// Gives the newest history to readers that have joined since. Publishing does so as well.
    pub fn update(&self) {
        self.samples.update();
        self.spots.update();
    }
}

/// Reads the newest history of a fleet's run.
///
/// ```
/// use regatta_plugin::history::{FleetSample, HistoryHeader};
/// use regatta_plugin::{HistoryPublisher, HistoryReader, Participant, Result};
///
/// # fn main() -> Result {
/// # let fleet = format!("doc-history-{}", std::process::id()).parse()?;
/// let participant = Participant::join(&fleet, "traffic")?;
/// let mut publisher = HistoryPublisher::open_on(&participant)?;
/// let mut reader = HistoryReader::open_on(&participant)?;
/// let sample = FleetSample { secs: 60.0, mean_speed: 0.8, ..FleetSample::default() };
/// publisher.publish(&HistoryHeader::default(), &[sample], &[])?;
/// assert!(reader.update()?);
/// let (_, samples) = reader.samples().expect("samples");
/// assert_eq!(samples[0].mean_speed, 0.8);
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct HistoryReader {
    samples: Newest<FleetSample, HistoryHeader>,
    spots: Newest<HotSpot, HistoryHeader>,
}

impl HistoryReader {
    /// Opens a fleet's history, whether or not a process publishes it yet.
    ///
    /// # Errors
    /// As [`Subscriber::open`](crate::Subscriber::open).
    pub fn open_on(participant: &Participant) -> Result<Self, OpenError> {
        Ok(Self {
            samples: Newest::open(&services::HISTORY, participant)?,
            spots: Newest::open(&services::SPOTS, participant)?,
        })
    }

    /// Takes the newest history, and returns whether there was one that this hasn't taken yet.
    ///
    /// # Errors
    /// [`ReadError`] if a connection is broken.
    pub fn update(&mut self) -> Result<bool, ReadError> {
        let has_samples = self.samples.take_newest()?;
        Ok(self.spots.take_newest()? || has_samples)
    }

    /// The figures over time, the oldest first.
    pub fn samples(&self) -> Option<(&HistoryHeader, &[FleetSample])> {
        self.samples.held()
    }

    /// The hot spots, the worst first.
    pub fn spots(&self) -> Option<(&HistoryHeader, &[HotSpot])> {
        self.spots.held()
    }

    /// Whether a process publishes it. One that was killed counts until another process joins the
    /// fleet.
    pub fn has_publisher(&self) -> bool {
        self.samples.has_publisher()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::FleetName;

    #[test]
    fn a_reader_that_joins_late_has_all_of_the_run() {
        let name: FleetName =
            format!("unit-history-{}", std::process::id()).parse().expect("a name");
        let participant = Participant::join(&name, "test").expect("joined");
        let mut publisher = HistoryPublisher::open_on(&participant).expect("a publisher");
        let second = HistoryPublisher::open_on(&participant).expect_err("one at a time");
        assert!(matches!(second, OpenError::Taken { .. }), "{second}");
        let samples: Vec<_> = (0..300)
            .map(|n| FleetSample { secs: f64::from(n), ..FleetSample::default() })
            .collect();
        let header = HistoryHeader { run_id: 3, tick: 9, ..HistoryHeader::default() };
        publisher.publish(&header, &samples, &[]).expect("published");
        let mut reader = HistoryReader::open_on(&participant).expect("a reader");
        publisher.update();
        assert!(reader.update().expect("readable") && reader.has_publisher());
        let (found, history) = reader.samples().expect("samples");
        assert_eq!(*found, HistoryHeader { sequence: 1, ..header });
        assert_eq!((history.len(), history[299].secs), (300, 299.0));
        assert_eq!(
            reader.spots().map(|(_, spots)| spots.len()),
            Some(0),
            "none is something else than nobody knows"
        );
        publisher
            .publish(&header, &samples, &[HotSpot { x: 5.0, ..HotSpot::default() }])
            .expect("published");
        assert!(reader.update().expect("readable"));
        assert_eq!(
            reader.spots().map(|(header, spots)| (header.sequence, spots[0].x)),
            Some((2, 5.0))
        );
    }
}
