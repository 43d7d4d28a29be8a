//! The reader's side of closed edges.

use super::error::{OpenError, ReadError};
use super::receive::Newest;
use super::services;
use crate::process::join::Participant;
use crate::records::closure::{ClosedEdge, ClosureHeader};

/// Reads the closed edges of a fleet. Nothing arrives before the first one is closed.
///
/// ```
/// use regatta_plugin::closure::ClosedEdge;
/// use regatta_plugin::{ClosureReader, ProducerPorts, Result};
///
/// # fn main() -> Result {
/// # let fleet = format!("doc-closures-{}", std::process::id()).parse()?;
/// let mut producer = ProducerPorts::create(&fleet, 1)?;
/// let mut reader = ClosureReader::open_on(producer.participant())?;
/// producer.publish_closures(5, &[ClosedEdge { edge: 7 }])?;
/// assert!(reader.take()?);
/// assert_eq!(reader.closed(producer.run_id()), [ClosedEdge { edge: 7 }]);
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct ClosureReader {
    closures: Newest<ClosedEdge, ClosureHeader>,
}

impl ClosureReader {
    /// Opens a fleet's closed edges, whether or not it has a producer.
    ///
    /// # Errors
    /// As [`Subscriber::open`](crate::Subscriber::open).
    pub fn open_on(participant: &Participant) -> Result<Self, OpenError> {
        Ok(Self { closures: Newest::open(&services::CLOSURES, participant)? })
    }

    /// Takes the newest sample, and returns whether there was one that this hasn't taken yet.
    ///
    /// # Errors
    /// [`ReadError`] if the connection is broken.
    pub fn take(&mut self) -> Result<bool, ReadError> {
        self.closures.take_newest()
    }

    /// The edges that are closed in a run, sorted by id, as of the sample that was taken last.
    pub fn closed(&self, run_id: u64) -> &[ClosedEdge] {
        self.closures
            .held()
            .filter(|(header, _)| header.run_id == run_id)
            .map_or(&[], |(_, edges)| edges)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{FleetName, ProducerPorts};

    #[test]
    fn a_late_reader_gets_the_closed_edges_of_its_run() {
        let name: FleetName =
            format!("unit-closures-{}", std::process::id()).parse().expect("a name");
        let mut producer = ProducerPorts::create(&name, 1).expect("a producer");
        let edges = [3, 7].map(|edge| ClosedEdge { edge });
        producer.publish_closures(5, &edges).expect("published");
        let participant = Participant::join(&name, "reader").expect("joined");
        let mut reader = ClosureReader::open_on(&participant).expect("a reader");
        producer.update();
        assert!(reader.take().expect("readable") && !reader.take().expect("readable"));
        assert_eq!((reader.closed(producer.run_id()), reader.closed(1)), (&edges[..], &[][..]));
        producer.publish_closures(6, &[]).expect("published");
        assert!(reader.take().expect("readable") && reader.closed(producer.run_id()).is_empty());
    }
}
