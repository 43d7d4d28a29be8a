//! Publishes recorded messages as a producer.

use std::collections::BTreeSet;

use regatta_plugin::column::ColumnHeader;
use regatta_plugin::contact::{ContactHeader, ContactPublisher};
use regatta_plugin::frame::{ClockState, FrameHeader, RobotState};
use regatta_plugin::publish::Producer;
use regatta_plugin::{ColumnName, OpenError, Participant, PublishError};

use super::ReplayError;
use crate::decode::{self, MessageError, RecordedWorld};
use crate::recorded::{RecordedColumn, RecordedFrame};
use crate::schema::Topic;

/// What a frame says about the replay rather than about the recording.
#[derive(Clone, Copy, Debug)]
pub(super) struct Show {
    pub clock: ClockState,
    pub speed: f32,
    pub lockstep: bool,
}

/// The producer, and what it showed last.
#[derive(Debug)]
pub(super) struct Stage {
    pub producer: Producer,
    /// A recording without any leaves them to a live checker.
    contacts: Option<ContactPublisher>,
    /// Those that are published: none that somebody else publishes.
    columns: BTreeSet<ColumnName>,
    /// The run that was recorded, of which this shows a part.
    recorded_run: Option<u64>,
    world: RecordedWorld,
    /// Header and states of the frame shown last.
    header: FrameHeader,
    states: Vec<u8>,
}

/// What went wrong with one message.
pub(super) enum StageError {
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

impl Stage {
    /// Opens a fleet to publish these topics on, all before the first frame: so readers that wait for a fleet are there
    /// in time.
    pub fn open(participant: Participant, topics: &[Topic]) -> Result<Self, OpenError> {
        let mut producer = Producer::create_on(participant, 0)?;
        let mut columns = BTreeSet::new();
        for name in topics.iter().filter_map(Topic::column) {
            match producer.open_column(name.clone()) {
                Ok(_) => drop(columns.insert(name.clone())),
                Err(error) => regatta_plugin::tell!("replay: the recorded column is left out: {error}"),
            }
        }
        let has_contacts = topics.iter().any(|topic| matches!(topic, Topic::Contacts | Topic::ContactEvents));
        let contacts = has_contacts.then(|| ContactPublisher::open_on(producer.participant()));
        let contacts = contacts.and_then(|opened| {
            opened.inspect_err(|error| regatta_plugin::tell!("replay: contacts are left out: {error}")).ok()
        });
        Ok(Self {
            producer,
            contacts,
            columns,
            recorded_run: None,
            world: RecordedWorld::default(),
            header: FrameHeader::default(),
            states: Vec::new(),
        })
    }

    /// Gives what was published last to readers that have joined since.
    pub fn update(&self) {
        self.producer.update();
        if let Some(contacts) = &self.contacts {
            contacts.update();
        }
    }

    /// Header of the frame shown last.
    pub fn header(&self) -> &FrameHeader {
        &self.header
    }

    /// Robots of the frame shown last, by state.
    pub fn robots_by_state(&self) -> [u32; 5] {
        let mut counts = [0; 256];
        self.states.iter().for_each(|state| counts[usize::from(*state)] += 1);
        let [idle, driving, waiting, held, faulted, ..] = counts;
        debug_assert!(RobotState::Faulted as usize == 4, "states are numbered in this order");
        [idle, driving, waiting, held, faulted]
    }

    /// Starts another run, for going back in time.
    pub fn begin_run(&mut self) -> Result<(), PublishError> {
        self.producer.begin_run();
        self.publish_world()
    }

    /// Publishes one message. Whether it was a frame.
    pub fn publish(&mut self, topic: &Topic, message: &[u8], show: Show) -> Result<bool, StageError> {
        match topic {
            Topic::Frames => return self.frame(&RecordedFrame::parse(message)?, show).map(|()| true),
            Topic::World => self.take_world(decode::world(message)?)?,
            Topic::Column(name) if self.columns.contains(name) => {
                self.column(name, &RecordedColumn::parse(message)?)?
            }
            Topic::Events if self.producer.has_event_readers() => {
                let (header, events) = decode::events(message)?;
                self.producer.publish_events(&header, &events)?;
            }
            Topic::Orders if self.producer.has_order_log_readers() => {
                let (tick, orders) = decode::orders(message)?;
                self.producer.publish_order_log(tick, &orders)?;
            }
            Topic::Contacts => self.contacts(message)?,
            Topic::ContactEvents => self.contact_events(message)?,
            // What nobody reads or wants, and what is for other programs.
            _ => {}
        }
        Ok(false)
    }

    fn frame(&mut self, frame: &RecordedFrame<'_>, show: Show) -> Result<(), StageError> {
        self.follow_run(frame.header.run_id)?;
        self.producer.check_room(frame.len())?;
        let mut loan = self.producer.loan(frame.len())?;
        let header = loan.header_mut();
        let FrameHeader { run_id, world_revision, robots, stride_lines, .. } = *header;
        *header = FrameHeader {
            run_id,
            world_revision,
            robots,
            stride_lines,
            clock: show.clock as u32,
            speed: show.speed,
            lockstep: u32::from(show.lockstep),
            ..frame.header
        };
        self.header = *header;
        frame.copy_to(&mut loan.columns_mut());
        loan.send()?;
        self.producer.notify();
        self.update();
        self.states.clear();
        self.states.extend_from_slice(frame.states());
        Ok(())
    }

    fn take_world(&mut self, world: RecordedWorld) -> Result<(), StageError> {
        let run_id = world.run_id;
        let shown = (self.recorded_run == Some(run_id)) && world == self.world;
        self.world = world;
        if !shown && !self.follow_run(run_id)? {
            self.publish_world()?;
        }
        Ok(())
    }

    /// A run of the recording is a run of the replay. Whether it is another than before, so that the world was
    /// published anew.
    fn follow_run(&mut self, recorded_run: u64) -> Result<bool, PublishError> {
        let before = self.recorded_run.replace(recorded_run);
        let changed = before.is_some_and(|before| before != recorded_run);
        if changed {
            self.begin_run()?;
        }
        Ok(changed)
    }

    fn publish_world(&mut self) -> Result<(), PublishError> {
        let RecordedWorld { nodes, edges, robot_types, .. } = &self.world;
        self.producer.publish_world(nodes, edges, robot_types).map(drop)
    }

    fn column(&mut self, name: &ColumnName, column: &RecordedColumn<'_>) -> Result<(), StageError> {
        let header = ColumnHeader { tick: column.tick, ..ColumnHeader::default() };
        Ok(self.producer.publish_column(name.as_str(), header, &column.values())?)
    }

    fn contacts(&mut self, message: &[u8]) -> Result<(), StageError> {
        let run_id = self.producer.run_id();
        if let Some(publisher) = &mut self.contacts {
            let (header, pairs) = decode::contacts(message)?;
            publisher.publish(&ContactHeader { run_id, ..header }, &pairs)?;
        }
        Ok(())
    }

    fn contact_events(&mut self, message: &[u8]) -> Result<(), StageError> {
        let run_id = self.producer.run_id();
        if let Some(publisher) = &mut self.contacts {
            let (tick, events) = decode::contact_events(message)?;
            publisher.publish_events(run_id, tick, &events)?;
        }
        Ok(())
    }
}
