//! Sends columns: each new one while somebody listens, and the newest to those who ask.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use regatta_plugin::records::name::ColumnName;
use regatta_plugin::{ColumnReader, Participant, Result};
use zenoh::{Session, Wait};

use super::{Requests, queryable};
use crate::link::{Link, LinkError, Outlet, key};
use crate::wire::encode_column;

/// The time between two looks for columns that are new.
const LOOK: Duration = Duration::from_secs(1);
/// The largest number of columns.
pub const MAX_COLUMNS: usize = 64;

/// The columns of a fleet.
pub struct Columns {
    participant: Participant,
    session: Session,
    requests: Requests,
    columns: BTreeMap<ColumnName, (ColumnReader, Outlet)>,
    next_look: Instant,
}

impl Columns {
    /// Offers the columns of a fleet.
    pub fn open(participant: Participant, link: &Link) -> Result<Self, LinkError> {
        let requests = queryable(link, key(participant.fleet(), "columns/*"))?;
        Ok(Self {
            participant,
            session: link.session.clone(),
            requests,
            columns: BTreeMap::new(),
            next_look: Instant::now(),
        })
    }

    /// Sends what is new, and answers requests.
    pub fn advance(&mut self) -> Result {
        if Instant::now() >= self.next_look {
            self.next_look = Instant::now() + LOOK;
            self.look()?;
        }
        for (reader, outlet) in self.columns.values_mut() {
            if outlet.is_wanted()
                && let Some(column) = reader.latest()?
            {
                outlet.put(encode_column(column.header, column.values));
            }
        }
        while let Ok(Some(query)) = self.requests.try_recv() {
            for (name, (reader, _)) in &mut self.columns {
                reader.latest()?;
                let Some(column) = reader.current()? else { continue };
                let name = key(self.participant.fleet(), &format!("columns/{name}"));
                let _ = query.reply(name, encode_column(column.header, column.values)).wait();
            }
        }
        Ok(())
    }

    /// Opens the columns that have come since.
    fn look(&mut self) -> Result {
        for name in self.participant.column_names() {
            if self.columns.contains_key(&name) || self.columns.len() >= MAX_COLUMNS {
                continue;
            }
            let reader = ColumnReader::open_on(&self.participant, name.as_str())?;
            let name_of = key(self.participant.fleet(), &format!("columns/{name}"));
            let outlet = Outlet::dropping(&self.session, name_of)?;
            self.columns.insert(name, (reader, outlet));
        }
        Ok(())
    }
}
