//! What a fleet tells besides frames, world and events: columns, orders, contacts.

use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::time::Duration;

use regatta_plugin::contact::{ContactEventReader, ContactReader};
use regatta_plugin::order_log::OrderLogReader;
use regatta_plugin::{ColumnName, ColumnReader, FleetName, Participant, Result, column_names};

use crate::encode;
use crate::schema::Topic;

/// How often to look for new columns.
const SEARCH_PERIOD: Duration = Duration::from_secs(1);

/// Readers of all that isn't handed over by the contract itself.
#[derive(Debug)]
pub(crate) struct Sources {
    participant: Participant,
    columns: Vec<(ColumnName, ColumnReader)>,
    found: Receiver<Vec<ColumnName>>,
    orders: OrderLogReader,
    contacts: ContactReader,
    contact_events: ContactEventReader,
}

impl Sources {
    pub fn open(participant: &Participant) -> Result<Self> {
        let (sender, found) = sync_channel(1);
        let fleet = participant.fleet().clone();
        // Looking through the machine's services takes longer than a frame may wait.
        std::thread::Builder::new().name("columns".to_owned()).spawn(move || search(&fleet, &sender))?;
        let mut sources = Self {
            participant: participant.clone(),
            columns: Vec::new(),
            found,
            orders: OrderLogReader::open_on(participant)?,
            contacts: ContactReader::open_on(participant)?,
            contact_events: ContactEventReader::open_on(participant)?,
        };
        // Those that are there already, before the first frame: opening takes a while.
        sources.open_columns(column_names(participant.fleet()))?;
        Ok(sources)
    }

    /// Hands over what is new: its topic, run, tick, and the message.
    pub fn poll(&mut self, mut take: impl FnMut(Topic, u64, u64, Vec<u8>)) -> Result {
        let found: Vec<_> = self.found.try_iter().flatten().collect();
        self.open_columns(found)?;
        for (name, reader) in &mut self.columns {
            if let Some(column) = reader.latest()? {
                let topic = Topic::Column(name.clone());
                take(topic, column.header.run_id, column.header.tick, encode::column(&column));
            }
        }
        self.orders.take(|log| -> Result {
            take(Topic::Orders, log.header.run_id, log.header.tick, encode::orders(log));
            Ok(())
        })?;
        if let Some(contacts) = self.contacts.latest()? {
            take(Topic::Contacts, contacts.header.run_id, contacts.header.tick, encode::contacts(&contacts));
        }
        self.contact_events.take(|events| -> Result {
            take(Topic::ContactEvents, events.header.run_id, events.header.tick, encode::contact_events(events));
            Ok(())
        })
    }

    fn open_columns(&mut self, names: Vec<ColumnName>) -> Result {
        for name in names {
            if !self.columns.iter().any(|(known, _)| *known == name) {
                let reader = ColumnReader::open_on(&self.participant, &name)?;
                self.columns.push((name, reader));
            }
        }
        Ok(())
    }
}

/// Looks for columns until nobody wants to know.
fn search(fleet: &FleetName, found: &SyncSender<Vec<ColumnName>>) {
    loop {
        std::thread::sleep(SEARCH_PERIOD);
        if found.send(column_names(fleet)).is_err() {
            return;
        }
    }
}
