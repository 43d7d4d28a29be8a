//! What a collision checker publishes, if one runs and keeps up.

use std::sync::Arc;

use regatta_plugin::contact::{ContactHeader, ContactLevel, ContactRecord};
use regatta_plugin::{ColumnReader, ContactReader, Participant, ReadError, Result};

use crate::fold::Fold;
use crate::snapshot::{Collisions, RobotLevels};

/// Pairs to list. The totals count all.
const LISTED: usize = 1000;

/// Nanoseconds of wall time. What was checked longer before the newest frame says nothing of it any more: its checker
/// has died or hangs.
const FRESH: u64 = 2_000_000_000;

/// Reads the column `collision` and the contacts of a fleet.
#[derive(Debug)]
pub struct CollisionReader {
    column: ColumnReader,
    contacts: ContactReader,
    levels: Option<News<RobotLevels>>,
    pairs: Option<News<(ContactHeader, Arc<[ContactRecord]>)>>,
}

/// Something that was read, of one run, at a wall time in nanoseconds.
#[derive(Debug)]
struct News<T> {
    run_id: u64,
    seen: u64,
    what: T,
}

impl<T> News<T> {
    fn of(&self, (run_id, wall): (u64, u64)) -> Option<&T> {
        (self.run_id == run_id && wall.saturating_sub(self.seen) < FRESH).then_some(&self.what)
    }
}

impl CollisionReader {
    /// Opens both, whether or not anybody publishes them yet.
    ///
    /// # Errors
    /// If the fleet speaks another contract, or has no place for another reader.
    pub fn open_on(participant: &Participant) -> Result<Self> {
        let contacts = ContactReader::open_on(participant)?;
        Ok(Self { column: ColumnReader::open_on(participant, "collision")?, contacts, levels: None, pairs: None })
    }

    /// Takes in what is new at the wall time `now`, in nanoseconds. What can't be read is counted: it is another
    /// program's mistake, and no reason to end.
    pub fn update(&mut self, fold: &mut Fold, now: u64) {
        for outcome in [self.read_levels(now), self.read_pairs(now)] {
            if outcome.is_err() {
                fold.read_error();
            }
        }
    }

    /// What was read of the run of a frame, the newest one, that was published at a wall time in nanoseconds.
    pub fn collisions(&self, newest: Option<(u64, u64)>) -> Collisions {
        let Some(newest) = newest else { return Collisions::default() };
        let pairs = self.pairs.as_ref().and_then(|pairs| pairs.of(newest));
        Collisions {
            robots: self.levels.as_ref().and_then(|levels| levels.of(newest)).copied(),
            pairs: pairs.map(|(header, _)| *header),
            list: pairs.map(|(_, list)| Arc::clone(list)).unwrap_or_default(),
        }
    }

    fn read_levels(&mut self, now: u64) -> Result<(), ReadError> {
        if let Some(column) = self.column.latest()? {
            let levels = count_levels(column.header.tick, column.values);
            self.levels = Some(News { run_id: column.header.run_id, seen: now, what: levels });
        }
        Ok(())
    }

    fn read_pairs(&mut self, now: u64) -> Result<(), ReadError> {
        if let Some(contacts) = self.contacts.latest()? {
            let listed = contacts.pairs[..contacts.pairs.len().min(LISTED)].into();
            self.pairs = Some(News { run_id: contacts.header.run_id, seen: now, what: (*contacts.header, listed) });
        }
        Ok(())
    }
}

fn count_levels(tick: u64, values: &[f32]) -> RobotLevels {
    let count = |level: ContactLevel| values.iter().filter(|&&value| value == level as u32 as f32).count() as u64;
    RobotLevels { tick, possible: count(ContactLevel::Possible), touching: count(ContactLevel::Touching) }
}

#[cfg(test)]
mod tests {
    use regatta_plugin::{ColumnPublisher, ContactPublisher, FleetName};

    use super::*;

    const RUN: u64 = 7;
    const SECOND: u64 = 1_000_000_000;

    /// A checker and a reader on a fleet of their own.
    fn fleet(test: &str) -> (ColumnPublisher, ContactPublisher, CollisionReader) {
        let name: FleetName = format!("unit-metrics-{test}-{}", std::process::id()).parse().expect("a name");
        let participant = Participant::join(&name, "test").expect("joined");
        let column = ColumnPublisher::open_on(&participant, "collision").expect("a column");
        let contacts = ContactPublisher::open_on(&participant).expect("contacts");
        (column, contacts, CollisionReader::open_on(&participant).expect("a reader"))
    }

    #[test]
    fn levels_and_pairs_are_those_of_the_newest_frames_run() {
        let (mut column, mut contacts, mut reader) = fleet("collisions");
        let mut fold = Fold::default();
        reader.update(&mut fold, 0);
        assert!(reader.collisions(Some((RUN, 0))).tick().is_none(), "nobody checks");

        let values = [0.0, 1.0, 2.0, 2.0, f32::NAN, 7.0];
        column.write(RUN, 40, values.len(), |chunk| chunk.copy_from_slice(&values)).expect("published");
        let header = ContactHeader { run_id: RUN, tick: 41, touching: 1, possible: 2, ..ContactHeader::default() };
        let pairs = vec![ContactRecord { robots: [2, 3], level: 2, ..ContactRecord::default() }; LISTED + 5];
        contacts.publish(&header, &pairs).expect("published");
        reader.update(&mut fold, SECOND);

        let header = ContactHeader { sequence: 1, ..header };
        let collisions = reader.collisions(Some((RUN, SECOND)));
        assert_eq!(collisions.robots, Some(RobotLevels { tick: 40, possible: 1, touching: 2 }));
        assert_eq!((collisions.pairs, collisions.list.len(), collisions.tick()), (Some(header), LISTED, Some(41)));
        assert!(reader.collisions(Some((RUN + 1, SECOND))).tick().is_none(), "another run");
        assert!(reader.collisions(Some((RUN, 3 * SECOND))).tick().is_none(), "its checker has died");
        assert!(reader.collisions(None).tick().is_none(), "no engine");
    }
}
