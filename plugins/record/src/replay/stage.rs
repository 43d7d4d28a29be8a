//! Publishes recorded messages through the ports of a producer.

use std::collections::BTreeSet;
use std::fmt::Display;

use regatta_plugin::contact::ContactHeader;
use regatta_plugin::frame::{FrameHeader, RobotState};
use regatta_plugin::producer::Session;
use regatta_plugin::{ColumnName, ContactPublisher, OrderPublisher, ProducerPorts, PublishError};

use super::ReplayError;
use super::annotations::Annotations;
use super::closures::ClosureChange;
use crate::contacts::ContactDecoder;
use crate::decode::{self, MessageError, RecordedWorld};
use crate::reading::{Entry, Recording};
use crate::recorded::{RecordedColumn, RecordedFrame};
use crate::schema::Topic;

/// The state of a replay's services.
#[derive(Debug)]
pub(super) struct Stage {
    annotations: Annotations,
    /// The time in the recording of the published message, in nanoseconds.
    pub time: u64,
    /// `None` if the recording has no contacts, so that a live checker can publish them.
    contacts: Option<ContactPublisher>,
    /// `None` if the recording has no order log.
    orders: Option<OrderPublisher>,
    /// The columns that are published: none that another process publishes.
    columns: BTreeSet<ColumnName>,
    /// The recorded run that is being shown.
    recorded_run: Option<u64>,
    world: RecordedWorld,
    /// The number of changes of the world.
    pub world_changes: u64,
    /// The states of the frame shown last.
    states: Vec<u8>,
    /// The recorded contacts up to now.
    recorded_contacts: ContactDecoder,
    /// The recorded columns shown in the run: a repeated one isn't published again.
    shown: BTreeSet<ColumnName>,
}

/// The error of publishing one message.
enum StageError {
    Message(MessageError),
    Replay(ReplayError),
}

impl<E: Into<ReplayError>> From<E> for StageError {
    fn from(error: E) -> Self {
        Self::Replay(error.into())
    }
}

impl From<MessageError> for StageError {
    fn from(error: MessageError) -> Self {
        Self::Message(error)
    }
}

/// Returns the opened service, or prints that it is left out.
pub(super) fn or_left_out<T, E: Display>(what: &str, opened: Result<T, E>) -> Option<T> {
    opened.inspect_err(|error| regatta_plugin::tell!("replay: {what} left out: {error}")).ok()
}

impl Stage {
    /// Opens the services of these topics, all before the first frame, so that readers that wait
    /// for a fleet join in time.
    pub fn open(ports: &mut ProducerPorts, topics: &[Topic], annotations: Annotations) -> Self {
        let mut columns = BTreeSet::new();
        for name in topics.iter().filter_map(Topic::column) {
            let opened = ports.open_column(name.clone());
            if or_left_out("the recorded column is", opened).is_some() {
                columns.insert(name.clone());
            }
        }
        let has_contacts = topics.iter().any(|topic| {
            matches!(topic, Topic::Contacts | Topic::ContactUpdates | Topic::ContactEvents)
        });
        let (mut contacts, mut orders) = (None, None);
        if has_contacts {
            let opened = ContactPublisher::open_on(ports.participant());
            contacts = or_left_out("contacts are", opened);
        }
        if topics.contains(&Topic::Orders) {
            orders = or_left_out("orders are", OrderPublisher::open_on(ports.participant()));
        }
        Self {
            annotations,
            time: 0,
            contacts,
            orders,
            columns,
            recorded_run: None,
            world: RecordedWorld::default(),
            world_changes: 0,
            states: Vec::new(),
            recorded_contacts: ContactDecoder::default(),
            shown: BTreeSet::new(),
        }
    }

    /// Gives the newest contacts to readers that have joined since, and connects those of the order
    /// log.
    ///
    /// # Errors
    /// Returns a [`PublishError`] if shared memory is full.
    pub fn update(&mut self) -> Result<(), PublishError> {
        self.annotations.update()?;
        if let Some(orders) = &self.orders {
            orders.update();
        }
        if let Some(contacts) = &self.contacts {
            contacts.update();
        }
        Ok(())
    }

    /// Returns the number of robots of the frame shown last, by state.
    pub fn robots_by_state(&self) -> [u32; RobotState::COUNT] {
        let mut counts = [0; RobotState::COUNT];
        for state in &self.states {
            if let Some(count) = counts.get_mut(usize::from(*state)) {
                *count += 1;
            }
        }
        counts
    }

    /// Begins another run, to go back in time.
    pub fn begin_run(&mut self, session: &mut Session) -> Result<(), PublishError> {
        session.ports().begin_run();
        self.shown.clear();
        self.annotations.closures.begin_run();
        self.publish_world(session)
    }

    /// Publishes one message of a recording.
    ///
    /// # Errors
    /// Returns a [`ReplayError`] if the message is invalid or can't be published.
    pub fn publish(
        &mut self,
        session: &mut Session,
        recording: &Recording,
        entry: Entry<'_>,
    ) -> Result<(), ReplayError> {
        match self.publish_message(session, entry.topic, entry.message) {
            Err(StageError::Message(error)) => {
                Ok(recording.located(entry.topic, entry.log_time, Err(error))?)
            }
            Err(StageError::Replay(error)) => Err(error),
            Ok(()) => Ok(()),
        }
    }

    fn publish_message(
        &mut self,
        session: &mut Session,
        topic: &Topic,
        message: &[u8],
    ) -> Result<(), StageError> {
        match topic {
            Topic::Frames => self.frame(session, &RecordedFrame::parse(message)?)?,
            Topic::World => self.take_world(session, decode::world(message)?)?,
            Topic::Column(name) if self.columns.contains(name) => {
                let column = RecordedColumn::parse(message)?;
                if !self.shown.insert(name.clone()) && column.is_repeated {
                    return Ok(());
                }
                session.ports().publish_column(name.as_str(), column.tick, &column.values())?;
            }
            Topic::Events if session.ports().has_event_readers() => {
                let (header, events) = decode::events(message)?;
                let (run_id, time) = (header.run_id, self.time);
                let changes = events.iter().filter_map(|e| ClosureChange::of(run_id, time, e));
                self.annotations.closures.take(changes);
                session.ports().publish_events(header.tick, header.dropped, &events)?;
            }
            Topic::Commands if session.ports().has_command_log_readers() => {
                let (_, tick, commands) = decode::commands(message)?;
                session.ports().publish_command_log(tick, &commands)?;
            }
            Topic::Orders => {
                if let Some(publisher) = &mut self.orders {
                    let (header, orders, _) = decode::orders(message)?;
                    publisher.publish(session.run_id(), header.tick, header.dropped, &orders)?;
                }
            }
            Topic::Contacts | Topic::ContactUpdates => {
                self.contacts(session.run_id(), topic, message)?
            }
            Topic::Facilities => {
                let (tick, states) = decode::facilities(message)?;
                session.ports().publish_facilities(tick, &states)?;
            }
            Topic::ContactEvents => self.contact_events(session.run_id(), message)?,
            // Without readers, or for other programs.
            _ => {}
        }
        Ok(())
    }

    fn frame(
        &mut self,
        session: &mut Session,
        frame: &RecordedFrame<'_>,
    ) -> Result<(), StageError> {
        self.follow_run(session, frame.header.run_id)?;
        self.annotations.before_frame(session.run_id(), self.time, &frame.header)?;
        session.set_tick(frame.header.tick);
        self.publish_closures(session)?;
        let mut loan = session.loan(frame.len())?;
        let header = loan.header_mut();
        // These fields are about the recording, the others about the replay.
        *header = FrameHeader {
            sim_time_nanos: frame.header.sim_time_nanos,
            late_ticks: frame.header.late_ticks,
            tick_cost_nanos: frame.header.tick_cost_nanos,
            tick_period_nanos: frame.header.tick_period_nanos,
            ..*header
        };
        frame.copy_to(&mut loan.columns_mut());
        session.send(loan)?;
        self.update()?;
        self.states.clear();
        self.states.extend_from_slice(frame.states());
        Ok(())
    }

    /// Publishes the edges that are closed at the shown time, if that has changed: the search may
    /// learn it after the frame.
    pub fn publish_closures(&mut self, session: &mut Session) -> Result<(), PublishError> {
        let Some(run) = self.recorded_run else { return Ok(()) };
        let Some(closed) = self.annotations.closures.news(run, self.time) else { return Ok(()) };
        let tick = session.tick();
        session.ports().publish_closures(tick, closed)
    }

    fn take_world(
        &mut self,
        session: &mut Session,
        world: RecordedWorld,
    ) -> Result<(), StageError> {
        let run_id = world.run_id;
        let world = RecordedWorld { is_repeated: false, ..world };
        let shown = (self.recorded_run == Some(run_id)) && world == self.world;
        self.world_changes += u64::from(world != self.world);
        self.world = world;
        if !shown && !self.follow_run(session, run_id)? {
            self.publish_world(session)?;
        }
        Ok(())
    }

    /// Begins a run of the replay for each run of the recording. Returns whether it did, and so
    /// published the world.
    fn follow_run(
        &mut self,
        session: &mut Session,
        recorded_run: u64,
    ) -> Result<bool, PublishError> {
        let before = self.recorded_run.replace(recorded_run);
        let changed = before.is_some_and(|before| before != recorded_run);
        if changed {
            self.begin_run(session)?;
        }
        Ok(changed)
    }

    fn publish_world(&mut self, session: &mut Session) -> Result<(), PublishError> {
        session.ports().publish_world(&self.world.data).map(drop)
    }

    /// Continues with contacts that were decoded so far, and publishes the last list.
    pub fn take_contacts(
        &mut self,
        session: &Session,
        decoder: ContactDecoder,
    ) -> Result<(), PublishError> {
        self.recorded_contacts = decoder;
        self.publish_contacts(session.run_id())
    }

    fn contacts(&mut self, run_id: u64, topic: &Topic, message: &[u8]) -> Result<(), StageError> {
        if self.contacts.is_some() && self.recorded_contacts.decode(topic, message)? {
            self.publish_contacts(run_id)?;
        }
        Ok(())
    }

    fn publish_contacts(&mut self, run_id: u64) -> Result<(), PublishError> {
        if let (Some(publisher), Some((header, pairs))) =
            (&mut self.contacts, self.recorded_contacts.list())
        {
            publisher.publish(&ContactHeader { run_id, ..*header }, pairs)?;
        }
        Ok(())
    }

    fn contact_events(&mut self, run_id: u64, message: &[u8]) -> Result<(), StageError> {
        if let Some(publisher) = &mut self.contacts {
            let (_, tick, events) = decode::contact_events(message)?;
            publisher.publish_events(run_id, tick, &events)?;
        }
        Ok(())
    }
}
