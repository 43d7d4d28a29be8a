//! What a fleet tells besides frames, world and events: columns, orders, contacts.

use std::collections::BTreeSet;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Weak};
use std::time::Duration;

use regatta_plugin::contact::{ContactEventReader, ContactReader};
use regatta_plugin::order_log::OrderLogReader;
use regatta_plugin::{ColumnName, ColumnReader, FleetName, Participant, Result, column_names};

use crate::encode;
use crate::schema::Topic;

/// How often to look for new columns.
const SEARCH_PERIOD: Duration = Duration::from_millis(500);
/// The column that every producer publishes: each robot's type.
const PRODUCERS_COLUMN: &str = "type";

/// Readers of all that isn't handed over by the contract itself.
#[derive(Debug)]
pub(crate) struct Sources {
    participant: Participant,
    columns: Vec<(ColumnName, ColumnReader)>,
    found: Receiver<ColumnName>,
    /// While this lives, the search goes on.
    _searched_for: Arc<()>,
    orders: OrderLogReader,
    contacts: ContactReader,
    contact_events: ContactEventReader,
}

impl Sources {
    pub fn open(participant: &Participant) -> Result<Self> {
        let (sender, found) = channel();
        let fleet = participant.fleet().clone();
        // Looking through the machine's services takes longer than a frame may wait.
        let searched_for = Arc::new(());
        let wanted = Arc::downgrade(&searched_for);
        std::thread::Builder::new().name("columns".to_owned()).spawn(move || search(&fleet, &sender, &wanted))?;
        let mut sources = Self {
            participant: participant.clone(),
            columns: Vec::new(),
            found,
            _searched_for: searched_for,
            orders: OrderLogReader::open_on(participant)?,
            contacts: ContactReader::open_on(participant)?,
            contact_events: ContactEventReader::open_on(participant)?,
        };
        // Before the first frame, because opening takes a while: the producer's own, and those that are there already.
        for name in [PRODUCERS_COLUMN.parse()?].into_iter().chain(column_names(participant.fleet())) {
            sources.open_column(name)?;
        }
        Ok(sources)
    }

    /// Hands over what is new: its topic, run, tick, and the message.
    pub fn poll(&mut self, mut take: impl FnMut(Topic, u64, u64, Vec<u8>)) -> Result {
        // No more than one for a frame, or else a frame could be missed.
        if let Ok(name) = self.found.try_recv() {
            self.open_column(name)?;
        }
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

    fn open_column(&mut self, name: ColumnName) -> Result {
        if !self.columns.iter().any(|(known, _)| *known == name) {
            let reader = ColumnReader::open_on(&self.participant, &name)?;
            self.columns.push((name, reader));
        }
        Ok(())
    }
}

/// Looks for columns while they are wanted. Tells of each once.
fn search(fleet: &FleetName, found: &Sender<ColumnName>, wanted: &Weak<()>) {
    let mut known = BTreeSet::new();
    while wanted.strong_count() > 0 {
        for name in column_names(fleet) {
            if known.insert(name.clone()) {
                // Nobody takes it at the end.
                let _ = found.send(name);
            }
        }
        std::thread::sleep(SEARCH_PERIOD);
    }
}
