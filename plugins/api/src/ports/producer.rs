//! The producer's side of all services: frames, the world, events, columns and the command log go
//! out; commands and requests come in.

use std::cell::Cell;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::hash::{BuildHasher, RandomState};
use std::rc::Rc;

use super::columns::ColumnPublisher;
use super::error::{OpenError, PublishError, ReadError};
pub use super::frame_loan::FrameLoan;
use super::frame_loan::{LastTick, wall_time_nanos};
use super::inbox::{CommandInbox, RequestInbox};
#[cfg(feature = "shared-memory")]
use super::lockstep::DoneReports;
use super::services;
use super::slices::SliceSender;
use crate::process::join::Participant;
use crate::records::closure::{ClosedEdge, ClosureHeader};
use crate::records::command::{Authority, CommandHeader, CommandRecord};
use crate::records::command_log::CommandLogHeader;
use crate::records::control::{ControlRequest, ControlResponse};
use crate::records::event::{EventHeader, EventRecord};
use crate::records::facility::{FacilityHeader, FacilityState};
use crate::records::frame::{FrameHeader, Line, frame_lines, stride_lines};
use crate::records::name::{ColumnName, FleetName};
use crate::records::world::{WorldData, WorldHeader};
use crate::transport::Notifier;

/// All ports of a producer. A fleet has one live producer at a time.
///
/// Everything that belongs to a tick is published before its frame: first
/// [events](Self::publish_events), the [command log](Self::publish_command_log) and
/// [columns](Self::publish_column), then the frame. So a reader that has the frame has all of it. A
/// [`Session`](crate::producer::Session) adds a clock, figures and the control service.
///
/// ```
/// use regatta_plugin::{FleetName, ProducerPorts, Result, Subscriber};
///
/// # fn main() -> Result {
/// # let fleet: FleetName = format!("doc-producer-{}", std::process::id()).parse()?;
/// let mut producer = ProducerPorts::create(&fleet, 2)?;
/// let mut subscriber = Subscriber::open(&fleet)?;
///
/// let mut frame = producer.loan(2)?;
/// frame.header_mut().tick = 1;
/// let columns = frame.columns_mut();
/// columns.x[..2].copy_from_slice(&[1.0, 3.0]);
/// frame.send()?;
/// producer.notify();
///
/// let frame = subscriber.latest()?.expect("a frame");
/// assert_eq!(frame.x(), [1.0, 3.0]);
/// # Ok(())
/// # }
/// ```
pub struct ProducerPorts {
    run_id: u64,
    revision: u64,
    frames: SliceSender<Line, FrameHeader>,
    wake: Notifier,
    world: SliceSender<Line, WorldHeader>,
    events: SliceSender<EventRecord, EventHeader>,
    command_log: SliceSender<CommandRecord, CommandLogHeader>,
    closures: SliceSender<ClosedEdge, ClosureHeader>,
    facilities: SliceSender<FacilityState, FacilityHeader>,
    columns: BTreeMap<ColumnName, ColumnPublisher>,
    commands: CommandInbox,
    requests: RequestInbox,
    /// `None` in a local fleet, whose readers are called.
    #[cfg(feature = "shared-memory")]
    pub(super) reports: Option<DoneReports>,
    participant: Participant,
    last_tick: LastTick,
    /// The largest frame, in lines, that shared memory was found to have room for.
    roomy_lines: Cell<usize>,
}

impl ProducerPorts {
    /// Opens all services of a fleet, with room for frames of `robots` robots (they can grow
    /// later).
    ///
    /// # Errors
    /// [`OpenError::AlreadyRunning`] if the fleet has a live producer, [`OpenError::OtherVersion`]
    /// if a process with another contract has a service open, else [`OpenError::SharedMemory`].
    pub fn create(fleet: &FleetName, robots: usize) -> Result<Self, OpenError> {
        Self::create_on(Participant::join(fleet, "producer")?, robots)
    }

    /// Opens all services for a process that has joined the fleet.
    ///
    /// # Errors
    /// As [`create`](Self::create).
    pub fn create_on(participant: Participant, robots: usize) -> Result<Self, OpenError> {
        let lines = frame_lines(robots.max(1));
        // First, because this publisher is the lock against a second producer.
        let (service, fleet) = (&services::FRAMES, participant.fleet().clone());
        let frames = SliceSender::only(service, service.name, lines, &participant, |owner| {
            OpenError::AlreadyRunning { fleet, owner }
        })?;
        let few = services::FIRST_RECORDS;
        Ok(Self {
            run_id: new_run_id(),
            revision: 0,
            frames,
            wake: Notifier::open(&participant, "wake")?,
            world: SliceSender::open(&services::WORLD, &participant, 1)?,
            events: SliceSender::open(&services::EVENTS, &participant, few)?,
            command_log: SliceSender::open(&services::COMMAND_LOG, &participant, few)?,
            closures: SliceSender::open(&services::CLOSURES, &participant, few)?,
            facilities: SliceSender::open(&services::FACILITIES, &participant, few)?,
            columns: BTreeMap::new(),
            commands: CommandInbox::open(&participant)?,
            requests: RequestInbox::open(&participant)?,
            #[cfg(feature = "shared-memory")]
            reports: match participant.is_local() {
                true => None,
                false => Some(DoneReports::open(&participant)?),
            },
            participant,
            last_tick: LastTick::default(),
            roomy_lines: Cell::new(0),
        })
    }

    /// The id of the run: it differs between any two starts of a producer. Every header that this
    /// one sends carries it.
    pub fn run_id(&self) -> u64 {
        self.run_id
    }

    /// Begins another run: samples from here on carry a new [run id](Self::run_id). A replay
    /// that goes back in time does this, for example: readers then start afresh. The world must be
    /// published again.
    pub fn begin_run(&mut self) {
        self.run_id = new_run_id();
        self.revision = 0;
    }

    /// The fleet that this producer publishes, and the name of this process in it.
    pub fn participant(&self) -> &Participant {
        &self.participant
    }

    /// Loans the chunk for the next frame. `run_id`, `world_revision`, `robots` and `stride_lines`
    /// are set in its header, the rest is zero; the values of the columns are left over from an
    /// older frame.
    ///
    /// Copies nothing and takes no lock. (iceoryx2 allocates one small reference count per loan,
    /// and a larger segment when the fleet has outgrown the last.)
    ///
    /// # Errors
    /// [`PublishError::NoRoom`] or [`PublishError::MemoryFull`] if shared memory is full,
    /// [`PublishError::Loan`] while another loan is alive.
    pub fn loan(&self, robots: usize) -> Result<FrameLoan, PublishError> {
        self.check_room(robots)?;
        let mut sample = self.frames.loan(frame_lines(robots))?;
        *sample.header_mut() = FrameHeader {
            run_id: self.run_id,
            world_revision: self.revision,
            robots: robots as u32,
            stride_lines: stride_lines(robots) as u32,
            ..FrameHeader::default()
        };
        Ok(FrameLoan::new(
            sample,
            robots,
            self.frames.sequence().clone(),
            Rc::clone(&self.last_tick),
        ))
    }

    /// Checks that frames of `robots` robots have room. The operating system hands out shared
    /// memory that it doesn't have, and kills the process that writes to it (`SIGBUS`): hence the
    /// check before the first frame of a size.
    ///
    /// # Errors
    /// [`PublishError::NoRoom`], with the missing amount.
    pub fn check_room(&self, robots: usize) -> Result<(), PublishError> {
        let lines = frame_lines(robots);
        if lines > self.roomy_lines.get() {
            #[cfg(feature = "shared-memory")]
            if !self.participant.is_local() {
                check_shared_room(lines)?;
            }
            self.roomy_lines.set(lines);
        }
        Ok(())
    }

    /// Wakes the readers that wait for a frame or for events. Never blocks.
    pub fn notify(&self) {
        self.wake.notify();
    }

    /// Publishes the route graph and the robot types, in place of those before. Returns the new
    /// revision, which later frames carry.
    ///
    /// # Errors
    /// [`PublishError`] when shared memory is full.
    pub fn publish_world(&mut self, world: &WorldData) -> Result<u64, PublishError> {
        let mut sample = self.world.loan(world.lines())?;
        world.write(sample.records_mut());
        *sample.header_mut() = world.header(self.run_id, self.revision + 1);
        sample.send()?;
        self.revision += 1;
        Ok(self.revision)
    }

    /// Publishes a column of the producer's own for a tick.
    ///
    /// # Errors
    /// [`PublishError`]; among them that another process publishes a column of that name.
    pub fn publish_column(
        &mut self,
        name: &str,
        tick: u64,
        values: &[f32],
    ) -> Result<(), PublishError> {
        let run_id = self.run_id;
        let column = self.open_column(name.parse()?)?;
        column.write(run_id, tick, values.len(), |chunk| chunk.copy_from_slice(values))
    }

    /// Opens a column of the producer's own, for readers to find before there are values.
    ///
    /// # Errors
    /// As [`ColumnPublisher::open_on`].
    pub fn open_column(&mut self, name: ColumnName) -> Result<&mut ColumnPublisher, OpenError> {
        Ok(match self.columns.entry(name) {
            Entry::Occupied(entry) => entry.into_mut(),
            Entry::Vacant(entry) => {
                let column = ColumnPublisher::open_on(&self.participant, entry.key().as_str())?;
                entry.insert(column)
            }
        })
    }

    /// Publishes the events of a tick, `dropped` of which were left out because there were too
    /// many.
    ///
    /// # Errors
    /// [`PublishError`] when shared memory is full.
    pub fn publish_events(
        &mut self,
        tick: u64,
        dropped: u64,
        events: &[EventRecord],
    ) -> Result<(), PublishError> {
        let header = EventHeader { run_id: self.run_id, tick, dropped, sequence: 0 };
        self.events.publish(header, events)
    }

    /// Publishes the commands that took effect in a tick, for readers of the command log.
    ///
    /// # Errors
    /// [`PublishError`] when shared memory is full.
    pub fn publish_command_log(
        &mut self,
        tick: u64,
        commands: &[CommandRecord],
    ) -> Result<(), PublishError> {
        let header = CommandLogHeader { run_id: self.run_id, tick, sequence: 0 };
        self.command_log.publish(header, commands)
    }

    /// Publishes the edges that are closed from a tick on, sorted by id, in place of those before.
    ///
    /// # Errors
    /// [`PublishError`] when shared memory is full.
    pub fn publish_closures(
        &mut self,
        tick: u64,
        edges: &[ClosedEdge],
    ) -> Result<(), PublishError> {
        self.closures.publish(ClosureHeader { run_id: self.run_id, tick, sequence: 0 }, edges)
    }

    /// Publishes the states of all doors, then of all lifts, from a tick on, in place of those
    /// before.
    ///
    /// # Errors
    /// [`PublishError`] when shared memory is full.
    pub fn publish_facilities(
        &mut self,
        tick: u64,
        states: &[FacilityState],
    ) -> Result<(), PublishError> {
        self.facilities.publish(FacilityHeader { run_id: self.run_id, tick, sequence: 0 }, states)
    }

    /// Connects readers that have joined since, and gives them the newest frame, world, columns,
    /// closures and facilities. To be called every tick, and every now and then while the clock is
    /// paused. Cheap if no reader has joined.
    pub fn update(&self) {
        self.columns.values().for_each(ColumnPublisher::update);
        self.command_log.update();
        self.closures.update();
        self.facilities.update();
        self.world.update();
        self.frames.update();
        self.events.update();
    }

    /// Whether a process reads events; if not, there is no need to collect any.
    pub fn has_event_readers(&self) -> bool {
        self.events.readers() > 0
    }

    /// Whether a process reads the command log; if not, there is no need to keep one.
    pub fn has_command_log_readers(&self) -> bool {
        self.command_log.readers() > 0
    }

    /// The number of processes that read frames.
    pub fn frame_readers(&self) -> usize {
        self.frames.readers()
    }

    /// The process that owns the movement of the robots: its name and its number.
    pub fn owner(&mut self) -> Option<&str> {
        self.commands.owner()
    }

    /// Passes all commands that have arrived to `each`, sample by sample, with those that their
    /// sender may give; those of one sender in the order in which it sent them. At most
    /// [`COMMAND_BUFFER`](services::COMMAND_BUFFER) samples per sender and call.
    ///
    /// # Errors
    /// [`ReadError::Receive`] if a connection is broken.
    pub fn take_commands(
        &mut self,
        each: impl FnMut(&CommandHeader, Authority, &[CommandRecord]),
    ) -> Result<(), ReadError> {
        self.commands.take(each)
    }

    /// Takes the oldest control request that has arrived, with the ticket by which to
    /// [answer](Self::answer) it, at once or later.
    ///
    /// # Errors
    /// [`ReadError::Receive`] if a connection is broken.
    pub fn take_request(&mut self) -> Result<Option<(u64, ControlRequest)>, ReadError> {
        self.requests.take()
    }

    /// Answers the request with a ticket.
    pub fn answer(&mut self, ticket: u64, response: ControlResponse) {
        self.requests.answer(ticket, response);
    }
}

impl core::fmt::Debug for ProducerPorts {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let ports = &mut f.debug_struct("ProducerPorts");
        ports.field("run_id", &self.run_id).field("participant", &self.participant);
        ports.finish_non_exhaustive()
    }
}

/// Checks that shared memory has room for frames of some lines.
#[cfg(feature = "shared-memory")]
fn check_shared_room(lines: usize) -> Result<(), PublishError> {
    let bytes = lines * crate::records::frame::BYTES_PER_LINE * services::CHUNKS_IN_USE;
    let needed_bytes = bytes as u64;
    // If the system doesn't say how much there is, there is nothing to check.
    let available_bytes = crate::process::health::space().map_or(u64::MAX, |space| space.available);
    if available_bytes < needed_bytes {
        return Err(PublishError::NoRoom { what: "a frame", available_bytes, needed_bytes });
    }
    Ok(())
}

/// A new run id: the time and the process id, hashed with random keys, so that runs that start
/// together differ in every digit.
fn new_run_id() -> u64 {
    RandomState::new().hash_one((wall_time_nanos(), std::process::id()))
}
