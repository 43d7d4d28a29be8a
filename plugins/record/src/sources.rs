//! Reads columns, commands, orders, contacts, doors and lifts. The plugin runner reads frames, the
//! world and events.

use std::collections::BTreeSet;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Weak};
use std::time::Duration;

use regatta_plugin::services::COLUMN_BUFFER;
use regatta_plugin::{
    ColumnName, ColumnReader, CommandLogReader, ContactEventReader, ContactReader, Contacts,
    FacilityReader, FleetName, OrderReader, Participant, Result, column_names,
};

use crate::arguments::TopicSet;
use crate::contacts::ContactList;
use crate::encode;
use crate::schema::Topic;
use crate::sink::Payload;

/// The time between two searches for new columns.
const SEARCH_PERIOD: Duration = Duration::from_millis(500);
/// The largest number of samples read from one column per poll, so that a publisher that is faster
/// than the recorder can't keep it busy forever.
const MAX_SAMPLES: usize = 2 * COLUMN_BUFFER;

/// The readers of all services that the plugin runner doesn't read itself.
#[derive(Debug)]
pub(crate) struct Sources {
    participant: Participant,
    columns: Vec<(ColumnName, ColumnReader)>,
    new_columns: Receiver<ColumnName>,
    /// Dropping this ends the thread that searches for columns.
    _search: Arc<()>,
    topics: TopicSet,
    commands: Option<CommandLogReader>,
    orders: Option<OrderReader>,
    contacts: Option<ContactReader>,
    contact_events: Option<ContactEventReader>,
    facilities: Option<FacilityReader>,
}

/// A message with the tick that it belongs to.
#[derive(Debug)]
pub(crate) struct Sample {
    pub topic: Topic,
    pub run_id: u64,
    pub tick: u64,
    /// The number of samples lost before this one.
    pub missed: u64,
    pub payload: Payload,
}

impl Sample {
    fn new(topic: Topic, (run_id, tick): (u64, u64), missed: u64, payload: Payload) -> Self {
        Self { topic, run_id, tick, missed, payload }
    }
}

impl Sources {
    /// Opens the services of these topics.
    pub fn open(participant: &Participant, topics: &TopicSet) -> Result<Self> {
        let (sender, new_columns) = channel();
        let fleet = participant.fleet().clone();
        let search = Arc::new(());
        if !participant.is_local() {
            // Listing the machine's services takes too long to be done between two frames.
            let is_needed = Arc::downgrade(&search);
            let thread = std::thread::Builder::new().name("columns".to_owned());
            thread.spawn(move || search_columns(&fleet, &sender, &is_needed))?;
        }
        let mut sources = Self {
            participant: participant.clone(),
            columns: Vec::new(),
            new_columns,
            _search: search,
            topics: topics.clone(),
            commands: None,
            orders: None,
            contacts: None,
            contact_events: None,
            facilities: None,
        };
        if topics.includes(&Topic::Commands) {
            sources.commands = Some(CommandLogReader::open_on(participant)?);
        }
        if topics.includes(&Topic::Orders) {
            sources.orders = Some(OrderReader::open_on(participant)?);
        }
        if topics.includes(&Topic::Contacts) {
            sources.contacts = Some(ContactReader::open_for_all_on(participant)?);
        }
        if topics.includes(&Topic::ContactEvents) {
            sources.contact_events = Some(ContactEventReader::open_on(participant)?);
        }
        if topics.includes(&Topic::Facilities) {
            sources.facilities = Some(FacilityReader::open_on(participant)?);
        }
        // Opening takes a while, so that the producer's column and all existing ones are opened
        // before the first frame.
        if let Some(types) = Topic::types().as_ref().and_then(Topic::column) {
            sources.open_column(types.clone())?;
        }
        sources.open_columns()?;
        Ok(sources)
    }

    /// Returns the newest contacts that were read, if they are recorded.
    pub fn contacts(&self) -> Option<Contacts<'_>> {
        self.contacts.as_ref()?.current()
    }

    /// Opens all existing columns. This is too slow to be called for every frame.
    pub fn open_columns(&mut self) -> Result {
        for name in self.participant.column_names() {
            self.open_column(name)?;
        }
        Ok(())
    }

    /// Calls `each` with all new samples.
    pub fn poll(&mut self, mut each: impl FnMut(Sample)) -> Result {
        // At most one column is opened per call, because opening several could take so long that a
        // frame is missed.
        if let Ok(name) = self.new_columns.try_recv() {
            self.open_column(name)?;
        }
        for (name, reader) in &mut self.columns {
            for _ in 0..MAX_SAMPLES {
                let Some(column) = reader.take_next()? else { break };
                let (topic, header) = (Topic::Column(name.clone()), column.header);
                let payload = Payload::Message(encode::column(&column));
                each(Sample::new(topic, (header.run_id, header.tick), column.missed, payload));
            }
        }
        if let Some(commands) = &mut self.commands {
            commands.take(|log| -> Result {
                let tick = (log.header.run_id, log.header.tick);
                let payload = Payload::Message(encode::commands(log));
                each(Sample::new(Topic::Commands, tick, log.missed, payload));
                Ok(())
            })?;
        }
        if let Some(orders) = &mut self.orders {
            orders.take(|log| -> Result {
                let tick = (log.header.run_id, log.header.tick);
                let payload = Payload::Message(encode::orders(log));
                each(Sample::new(Topic::Orders, tick, log.missed, payload));
                Ok(())
            })?;
        }
        if let Some(reader) = &mut self.contacts {
            for _ in 0..MAX_SAMPLES {
                let Some(contacts) = reader.take_next()? else { break };
                let header = *contacts.header;
                let list = ContactList { header, pairs: contacts.pairs.to_vec() };
                let (tick, payload) = ((header.run_id, header.tick), Payload::Contacts(list));
                each(Sample::new(Topic::Contacts, tick, contacts.missed, payload));
            }
        }
        if let Some(contact_events) = &mut self.contact_events {
            contact_events.take(|events| -> Result {
                let tick = (events.header.run_id, events.header.tick);
                let payload = Payload::Message(encode::contact_events(events));
                each(Sample::new(Topic::ContactEvents, tick, events.missed, payload));
                Ok(())
            })?;
        }
        if let Some(facilities) = &mut self.facilities
            && facilities.take()?
            && let Some((header, states)) = facilities.newest()
        {
            let payload = Payload::Message(encode::facilities(header, states));
            // A state that was replaced before it was read isn't lost: the newest has all.
            each(Sample::new(Topic::Facilities, (header.run_id, header.tick), 0, payload));
        }
        Ok(())
    }

    fn open_column(&mut self, name: ColumnName) -> Result {
        let is_wanted = self.topics.includes(&Topic::Column(name.clone()));
        if is_wanted && !self.columns.iter().any(|(opened, _)| *opened == name) {
            let reader = ColumnReader::open_for_all_on(&self.participant, name.as_str())?;
            self.columns.push((name, reader));
        }
        Ok(())
    }
}

/// Searches for columns until `is_needed` is dropped. Sends each name once.
fn search_columns(fleet: &FleetName, new_columns: &Sender<ColumnName>, is_needed: &Weak<()>) {
    let mut sent = BTreeSet::new();
    while is_needed.strong_count() > 0 {
        for name in column_names(fleet) {
            if sent.insert(name.clone()) {
                // Sending fails if the receiver was dropped meanwhile, which ends the loop.
                let _ = new_columns.send(name);
            }
        }
        std::thread::sleep(SEARCH_PERIOD);
    }
}
