//! What a fleet tells besides frames, world and events: columns, orders, contacts.

use std::collections::BTreeSet;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Weak};
use std::time::Duration;

use regatta_plugin::services::COLUMN_BUFFER;
use regatta_plugin::{
    ColumnName, ColumnReader, ContactEventReader, ContactReader, FleetName, OrderLogReader, Participant, Result,
    column_names,
};

use crate::encode;
use crate::schema::{PRODUCERS_COLUMN, Topic};

/// How often to look for new columns.
const SEARCH_PERIOD: Duration = Duration::from_millis(500);
/// Most samples of one column that are taken at a time: a publisher faster than the recorder must not keep it busy.
const AT_ONCE: usize = 2 * COLUMN_BUFFER;

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

/// A message, and the tick that it belongs to.
pub(crate) struct Found {
    pub topic: Topic,
    pub run_id: u64,
    pub tick: u64,
    /// Samples before this one that nobody will ever see here.
    pub missed: u64,
    pub message: Vec<u8>,
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
            contacts: ContactReader::open_for_all_on(participant)?,
            contact_events: ContactEventReader::open_on(participant)?,
        };
        // Before the first frame, because opening takes a while: the producer's own, and those that are there already.
        sources.open_column(PRODUCERS_COLUMN.parse()?)?;
        sources.open_columns()?;
        Ok(sources)
    }

    /// Opens all columns that there are. Takes a while: not for every frame.
    pub fn open_columns(&mut self) -> Result {
        column_names(self.participant.fleet()).into_iter().try_for_each(|name| self.open_column(name))
    }

    /// Hands over what is new.
    pub fn poll(&mut self, mut take: impl FnMut(Found)) -> Result {
        // No more than one for a frame, or else a frame could be missed.
        if let Ok(name) = self.found.try_recv() {
            self.open_column(name)?;
        }
        for (name, reader) in &mut self.columns {
            for _ in 0..AT_ONCE {
                let Some(column) = reader.take_next()? else { break };
                let (run_id, tick, missed) = (column.header.run_id, column.header.tick, column.missed);
                let message = encode::column(&column);
                take(Found { topic: Topic::Column(name.clone()), run_id, tick, missed, message });
            }
        }
        self.orders.take(|log| -> Result {
            let (run_id, tick, missed) = (log.header.run_id, log.header.tick, log.missed);
            take(Found { topic: Topic::Orders, run_id, tick, missed, message: encode::orders(log) });
            Ok(())
        })?;
        for _ in 0..AT_ONCE {
            let Some(contacts) = self.contacts.take_next()? else { break };
            let (run_id, tick, missed) = (contacts.header.run_id, contacts.header.tick, contacts.missed);
            take(Found { topic: Topic::Contacts, run_id, tick, missed, message: encode::contacts(&contacts) });
        }
        self.contact_events.take(|events| -> Result {
            let (run_id, tick, missed) = (events.header.run_id, events.header.tick, events.missed);
            take(Found { topic: Topic::ContactEvents, run_id, tick, missed, message: encode::contact_events(events) });
            Ok(())
        })
    }

    fn open_column(&mut self, name: ColumnName) -> Result {
        if !self.columns.iter().any(|(known, _)| *known == name) {
            let reader = ColumnReader::open_for_all_on(&self.participant, name.as_str())?;
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
