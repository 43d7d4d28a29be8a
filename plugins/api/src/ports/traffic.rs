//! Both sides of the traffic on edges: a plugin publishes it, any process reads it.

use super::error::{OpenError, PublishError, ReadError};
use super::receive::Newest;
use super::services;
use super::slices::SliceSender;
use crate::process::join::Participant;
use crate::records::traffic::{EdgeTraffic, TRAFFIC_PERIODS, Traffic, TrafficHeader};

/// Publishes the traffic on a fleet's edges. A fleet has one such publisher at a time.
///
/// ```
/// use regatta_plugin::traffic::{EdgeTraffic, TRAFFIC_PERIODS, TrafficHeader};
/// use regatta_plugin::{Participant, Result, TrafficPublisher};
///
/// # fn main() -> Result {
/// # let fleet = format!("doc-traffic-{}", std::process::id()).parse()?;
/// let mut publisher = TrafficPublisher::open_on(&Participant::join(&fleet, "traffic")?)?;
/// // One edge: a figure for each period.
/// let edge = EdgeTraffic { occupancy: 1.5, ..EdgeTraffic::default() };
/// publisher.publish(&TrafficHeader::default(), &[edge; TRAFFIC_PERIODS])?;
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct TrafficPublisher {
    sender: SliceSender<EdgeTraffic, TrafficHeader>,
}

impl TrafficPublisher {
    /// Opens a fleet's traffic for writing.
    ///
    /// # Errors
    /// [`OpenError::Taken`] if a live process publishes it, [`OpenError::OtherVersion`] if
    /// the fleet uses another contract, else [`OpenError::SharedMemory`].
    pub fn open_on(participant: &Participant) -> Result<Self, OpenError> {
        Ok(Self { sender: SliceSender::open_only(&services::TRAFFIC, participant)? })
    }

    /// Publishes the figures of all edges for each period. Fills in the header's `sequence` and
    /// `edges`.
    ///
    /// # Errors
    /// [`PublishError`] when shared memory is full.
    ///
    /// # Panics
    /// If `figures` aren't as many for each period.
    pub fn publish(
        &mut self,
        header: &TrafficHeader,
        figures: &[EdgeTraffic],
    ) -> Result<(), PublishError> {
        assert_eq!(figures.len() % TRAFFIC_PERIODS, 0, "a figure for each edge and period");
        let edges = (figures.len() / TRAFFIC_PERIODS) as u32;
        self.sender.publish(TrafficHeader { edges, ..*header }, figures)
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

/// Reads the newest traffic on a fleet's edges.
///
/// ```no_run
/// use regatta_plugin::{FleetName, Participant, Result, TrafficReader};
///
/// # fn main() -> Result {
/// let participant = Participant::join(&FleetName::default(), "reader")?;
/// let mut reader = TrafficReader::open_on(&participant)?;
/// if let Some(traffic) = reader.latest()? {
///     let [minute, ..] = traffic.periods;
///     println!("{} robots an hour entered the first edge", minute[0].entered_per_hour);
/// }
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct TrafficReader {
    traffic: Newest<EdgeTraffic, TrafficHeader>,
}

impl TrafficReader {
    /// Opens a fleet's traffic, whether or not a process publishes it yet.
    ///
    /// # Errors
    /// As [`Subscriber::open`](crate::Subscriber::open).
    pub fn open_on(participant: &Participant) -> Result<Self, OpenError> {
        Ok(Self { traffic: Newest::open(&services::TRAFFIC, participant)? })
    }

    /// Returns the newest figures, if there are some that this hasn't returned yet.
    ///
    /// # Errors
    /// [`ReadError`] if the connection is broken, or the figures contradict their header.
    pub fn latest(&mut self) -> Result<Option<Traffic<'_>>, ReadError> {
        if self.traffic.take_newest()? { self.current() } else { Ok(None) }
    }

    /// The figures that [`latest`](Self::latest) returned last.
    ///
    /// # Errors
    /// [`ReadError::Malformed`] if they contradict their header.
    pub fn current(&self) -> Result<Option<Traffic<'_>>, ReadError> {
        let Some((header, figures)) = self.traffic.held() else { return Ok(None) };
        let edges = header.edges as usize;
        if figures.len() != edges * TRAFFIC_PERIODS {
            return Err(ReadError::Malformed { what: "traffic", lines: figures.len() });
        }
        let periods = core::array::from_fn(|period| &figures[period * edges..(period + 1) * edges]);
        Ok(Some(Traffic { header, periods, missed: self.traffic.missed() }))
    }

    /// Whether a process publishes it. One that was killed counts until another process joins the
    /// fleet.
    pub fn has_publisher(&self) -> bool {
        self.traffic.has_publisher()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::FleetName;

    #[test]
    fn figures_arrive_as_they_were_published_and_by_one_publisher_only() {
        let name: FleetName =
            format!("unit-traffic-{}", std::process::id()).parse().expect("a name");
        let participant = Participant::join(&name, "test").expect("joined");
        let mut publisher = TrafficPublisher::open_on(&participant).expect("a publisher");
        let second = TrafficPublisher::open_on(&participant).expect_err("one at a time");
        assert!(matches!(second, OpenError::Taken { .. }), "{second}");
        let mut reader = TrafficReader::open_on(&participant).expect("a reader");
        assert!(reader.latest().expect("readable").is_none() && reader.has_publisher());
        let figures: Vec<_> =
            (0..6).map(|n| EdgeTraffic { occupancy: n as f32, ..EdgeTraffic::default() }).collect();
        let header = TrafficHeader {
            run_id: 3,
            tick: 9,
            period_secs: [60.0, 600.0, 700.0],
            ..TrafficHeader::default()
        };
        publisher.publish(&header, &figures).expect("published");
        let traffic = reader.latest().expect("readable").expect("figures");
        assert_eq!(*traffic.header, TrafficHeader { edges: 2, sequence: 1, ..header });
        assert_eq!(traffic.periods, [&figures[0..2], &figures[2..4], &figures[4..6]]);
    }
}
