//! The results of a collision checker, if one runs and keeps up.

use std::sync::Arc;

use regatta_plugin::column::COLLISION;
use regatta_plugin::contact::{ContactHeader, ContactLevel, ContactRecord};
use regatta_plugin::{ColumnReader, ContactReader, Participant, ReadError, Result};

use crate::fleet::Received;
use crate::snapshot::{Collisions, RobotLevels};

/// The largest number of pairs in the list. The totals count all.
const MAX_LISTED: usize = 1000;

/// A reader of the column `collision` and the contacts of a fleet.
#[derive(Debug)]
pub struct CollisionReader {
    column: ColumnReader,
    contacts: ContactReader,
    levels: Option<Received<RobotLevels>>,
    pairs: Option<Received<(ContactHeader, Arc<[ContactRecord]>)>>,
}

impl CollisionReader {
    /// Opens both, whether or not a checker publishes them yet.
    ///
    /// # Errors
    /// Fails if the fleet uses another version of the contract, or has no room for another reader.
    pub fn open_on(participant: &Participant) -> Result<Self> {
        let contacts = ContactReader::open_on(participant)?;
        Ok(Self {
            column: ColumnReader::open_on(participant, COLLISION.name())?,
            contacts,
            levels: None,
            pairs: None,
        })
    }

    /// Returns the results that belong to the newest frame, given its run id and its wall time in
    /// nanoseconds.
    pub fn collisions(&self, newest: Option<(u64, u64)>) -> Collisions {
        let Some(newest) = newest else { return Collisions::default() };
        let pairs = self.pairs.as_ref().and_then(|pairs| pairs.if_current(newest));
        Collisions {
            robots: self.levels.as_ref().and_then(|levels| levels.if_current(newest)).copied(),
            pairs: pairs.map(|(header, _)| *header),
            list: pairs.map(|(_, list)| Arc::clone(list)).unwrap_or_default(),
        }
    }

    /// Reads the column at the wall time `now`, in nanoseconds, if there is a new one.
    pub fn read_levels(&mut self, now: u64) -> Result<(), ReadError> {
        if let Some(column) = self.column.latest()? {
            let levels = count_levels(column.header.tick, column.values);
            self.levels = Some(Received::new(column.header.run_id, now, levels));
        }
        Ok(())
    }

    /// Reads the contacts in the same way.
    pub fn read_pairs(&mut self, now: u64) -> Result<(), ReadError> {
        if let Some(contacts) = self.contacts.latest()? {
            let listed = contacts.pairs[..contacts.pairs.len().min(MAX_LISTED)].into();
            let value = (*contacts.header, listed);
            self.pairs = Some(Received::new(contacts.header.run_id, now, value));
        }
        Ok(())
    }
}

fn count_levels(tick: u64, values: &[f32]) -> RobotLevels {
    let [possible, touching] = [ContactLevel::Possible, ContactLevel::Touching]
        .map(|level| values.iter().filter(|&&value| value == level as u32 as f32).count() as u64);
    RobotLevels { tick, possible, touching }
}

#[cfg(test)]
mod tests {
    use regatta_plugin::{ColumnPublisher, ContactPublisher, FleetName};

    use super::*;

    const RUN: u64 = 7;
    const SECOND: u64 = 1_000_000_000;

    /// Creates a checker and a reader on a fleet of their own.
    fn fleet(test: &str) -> (ColumnPublisher, ContactPublisher, CollisionReader) {
        let name: FleetName =
            format!("unit-metrics-{test}-{}", std::process::id()).parse().expect("a name");
        let participant = Participant::join(&name, "test").expect("joined");
        let column = ColumnPublisher::open_on(&participant, COLLISION.name()).expect("a column");
        let contacts = ContactPublisher::open_on(&participant).expect("contacts");
        (column, contacts, CollisionReader::open_on(&participant).expect("a reader"))
    }

    #[test]
    fn results_belong_to_the_run_of_the_newest_frame() {
        let (mut column, mut contacts, mut reader) = fleet("collisions");
        reader.read_levels(0).expect("read");
        assert!(reader.collisions(Some((RUN, 0))).tick().is_none(), "no checker runs");

        let values = [0.0, 1.0, 2.0, 2.0, f32::NAN, 7.0];
        column
            .write(RUN, 40, values.len(), |chunk| chunk.copy_from_slice(&values))
            .expect("published");
        let header = ContactHeader {
            run_id: RUN,
            tick: 41,
            touching: 1,
            possible: 2,
            ..ContactHeader::default()
        };
        let pairs = vec![
            ContactRecord { robots: [2, 3], level: 2, ..ContactRecord::default() };
            MAX_LISTED + 5
        ];
        contacts.publish(&header, &pairs).expect("published");
        reader.read_levels(SECOND).expect("read");
        reader.read_pairs(SECOND).expect("read");

        let header = ContactHeader { sequence: 1, ..header };
        let collisions = reader.collisions(Some((RUN, SECOND)));
        assert_eq!(collisions.robots, Some(RobotLevels { tick: 40, possible: 1, touching: 2 }));
        assert_eq!(
            (collisions.pairs, collisions.list.len(), collisions.tick()),
            (Some(header), MAX_LISTED, Some(41))
        );
        assert!(reader.collisions(Some((RUN + 1, SECOND))).tick().is_none(), "another run");
        assert!(
            reader.collisions(Some((RUN, 3 * SECOND))).tick().is_none(),
            "its checker has died"
        );
        assert!(reader.collisions(None).tick().is_none(), "no engine");
    }
}
