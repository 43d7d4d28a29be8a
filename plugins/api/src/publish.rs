//! The producer's side: frames, the world and events go out; orders and requests come in ([`inbox`](crate::inbox)).

use std::cell::Cell;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

use iceoryx2::port::notifier::Notifier;
use iceoryx2::port::publisher::{Publisher, PublisherCreateError};
use iceoryx2::port::update_connections::UpdateConnections;
use iceoryx2::prelude::*;

use crate::column::{ColumnHeader, ColumnPublisher};
use crate::error::{OpenError, PublishError};
use crate::event::{EventHeader, EventRecord};
use crate::fleet_name::{ColumnName, FleetName};
use crate::frame::{BYTES_PER_LINE, FrameHeader, Line, frame_lines, stride_lines};
pub use crate::frame_loan::FrameLoan;
use crate::frame_loan::wall_time_nanos;
use crate::health;
use crate::inbox::{OrderInbox, RequestInbox};
use crate::lockstep::Collector;
use crate::order::OrderRecord;
use crate::order_log::OrderLogPublisher;
use crate::participant::Participant;
use crate::qos::{self, Ipc};
use crate::world::{EdgeRecord, NodeRecord, RobotTypeRecord, WorldHeader, WorldLayout};

/// What writes a fleet into shared memory. One per fleet is alive at a time.
///
/// ```
/// use regatta_plugin::publish::Producer;
/// use regatta_plugin::{FleetName, Result, Subscriber};
///
/// # fn main() -> Result {
/// # let fleet: FleetName = format!("doc-producer-{}", std::process::id()).parse()?;
/// let mut producer = Producer::create(&fleet, 2)?;
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
#[derive(Debug)]
pub struct Producer {
    run_id: u64,
    revision: u64,
    frames: Publisher<Ipc, [Line], FrameHeader>,
    wake: Notifier<Ipc>,
    world: Publisher<Ipc, [Line], WorldHeader>,
    events: Publisher<Ipc, [EventRecord], EventHeader>,
    events_sent: u64,
    order_log: OrderLogPublisher,
    columns: BTreeMap<ColumnName, ColumnPublisher>,
    events_service: qos::Events,
    frames_service: qos::Frames,
    pub(crate) orders: OrderInbox,
    pub(crate) requests: RequestInbox,
    pub(crate) collector: Collector,
    participant: Participant,
    /// The largest frame, in lines, that shared memory was found to have room for.
    roomy_lines: Cell<usize>,
}

impl Producer {
    /// Opens all services of a fleet, with room for frames of `robots` robots (they can grow later).
    ///
    /// # Errors
    /// [`OpenError::AlreadyRunning`] if the fleet has a live producer, [`OpenError::OtherVersion`] if a process
    /// with another contract has a service open, else [`OpenError::SharedMemory`].
    pub fn create(fleet: &FleetName, robots: usize) -> Result<Self, OpenError> {
        Self::create_on(Participant::join(fleet, "producer")?, robots)
    }

    /// The same, on a place that the process already has.
    ///
    /// # Errors
    /// As [`create`](Self::create).
    pub fn create_on(participant: Participant, robots: usize) -> Result<Self, OpenError> {
        let (node, fleet) = (&*participant.node, participant.fleet());
        let frames_service = qos::frames(node, fleet)?;
        // First, because this publisher is the lock against a second producer.
        let frames = frames_publisher(&frames_service, &participant, robots)?;
        let world = qos::world(node, fleet)?;
        let events_service = qos::events(node, fleet)?;
        Ok(Self {
            run_id: new_run_id(),
            revision: 0,
            frames,
            wake: qos::notifier(&qos::event(node, fleet, "wake")?)?,
            world: world
                .publisher_builder()
                .max_loaned_samples(1)
                .backpressure_strategy(BackpressureStrategy::DiscardData)
                .initial_max_slice_len(1)
                .allocation_strategy(qos::GROWTH)
                .create()
                .map_err(|e| qos::full_or(world.name(), 1, e))?,
            events: events_service
                .publisher_builder()
                .max_loaned_samples(1)
                .backpressure_strategy(BackpressureStrategy::DiscardData)
                .initial_max_slice_len(qos::FIRST_RECORDS)
                .allocation_strategy(qos::GROWTH)
                .create()
                .map_err(|e| qos::full_or(events_service.name(), 1, e))?,
            events_sent: 0,
            order_log: OrderLogPublisher::open_on(&participant)?,
            columns: BTreeMap::new(),
            events_service,
            frames_service,
            orders: OrderInbox::open(&participant)?,
            requests: RequestInbox::open(&participant)?,
            collector: Collector::open(&participant)?,
            participant,
            roomy_lines: Cell::new(0),
        })
    }

    /// The run: differs between any two starts of a producer. It stands in every header that this one sends.
    pub fn run_id(&self) -> u64 {
        self.run_id
    }

    /// Begins another run: what is sent from here on carries a new [run id](Self::run_id). For a replay that goes back
    /// in time, say: readers then start afresh. The world must be published again.
    pub fn begin_run(&mut self) {
        self.run_id = new_run_id();
        self.revision = 0;
        self.collector.forget();
    }

    /// The place in the fleet that this producer is opened on.
    pub fn participant(&self) -> &Participant {
        &self.participant
    }

    /// Loans the chunk for the next frame. `run_id`, `world_revision`, `robots` and `stride_lines` are set in
    /// its header, the rest is zero; what the columns hold is left over from an older frame.
    ///
    /// Copies nothing and takes no lock. (iceoryx2 allocates one small reference count per loan, and a larger
    /// segment when the fleet has outgrown the last.)
    ///
    /// # Errors
    /// [`PublishError::Loan`] when shared memory is full, or while another loan is alive.
    #[expect(unsafe_code, reason = "the one way to loan a chunk without writing it twice")]
    pub fn loan(&self, robots: usize) -> Result<FrameLoan, PublishError> {
        self.check_room(robots)?;
        let sample = self
            .frames
            .loan_slice_uninit(frame_lines(robots))
            .map_err(|e| PublishError::Loan { what: "a frame", reason: e.to_string() })?;
        // SAFETY: a `Line` is plain data, for which every bit pattern is a value, and the chunk is mapped from a
        // shared-memory file: its bytes are zero or those of an older frame, never undefined.
        let mut sample = unsafe { sample.assume_init() };
        *sample.user_header_mut() = FrameHeader {
            run_id: self.run_id,
            world_revision: self.revision,
            robots: robots as u32,
            stride_lines: stride_lines(robots) as u32,
            ..FrameHeader::default()
        };
        Ok(FrameLoan::new(sample, robots))
    }

    /// Whether frames of that many robots have room. The operating system hands out shared memory that it doesn't
    /// have, and ends the process that writes to it (`SIGBUS`): so this looks before the first frame of a size.
    ///
    /// # Errors
    /// [`PublishError::Loan`] says how much is missing.
    pub fn check_room(&self, robots: usize) -> Result<(), PublishError> {
        let lines = frame_lines(robots);
        if lines <= self.roomy_lines.get() {
            return Ok(());
        }
        let needed = (lines * BYTES_PER_LINE * qos::CHUNKS_IN_USE) as u64;
        // Where the system doesn't say how much there is, there is nothing to go by.
        let available = health::space().map_or(u64::MAX, |space| space.available);
        if available < needed {
            let [needed, available] = [needed, available].map(|bytes| bytes as f64 * 1e-6);
            return Err(PublishError::Loan {
                what: "a frame",
                reason: format!("{available:.1} MB are left and {needed:.1} MB are needed"),
            });
        }
        self.roomy_lines.set(lines);
        Ok(())
    }

    /// Wakes the readers that wait for a frame. Never blocks: see `qos::event`.
    pub fn notify(&self) {
        // A reader that can't be woken polls; that is no reason to stop the fleet.
        if let Err(error) = self.wake.notify() {
            tracing::debug!(%error, "waking readers");
        }
    }

    /// Publishes the route graph and the robot types, in place of those before. Returns the new revision,
    /// which later frames carry.
    ///
    /// # Errors
    /// [`PublishError`] when shared memory is full.
    #[expect(unsafe_code, reason = "the one way to loan a chunk without writing it twice")]
    pub fn publish_world(
        &mut self,
        nodes: &[NodeRecord],
        edges: &[EdgeRecord],
        robot_types: &[RobotTypeRecord],
    ) -> Result<u64, PublishError> {
        let layout = WorldLayout { nodes: nodes.len(), edges: edges.len(), robot_types: robot_types.len() };
        let sample = self
            .world
            .loan_slice_uninit(layout.lines())
            .map_err(|e| PublishError::Loan { what: "the world", reason: e.to_string() })?;
        // SAFETY: as for a frame in `loan`.
        let mut sample = unsafe { sample.assume_init() };
        layout.write(sample.payload_mut(), nodes, edges, robot_types);
        *sample.user_header_mut() = layout.header(self.run_id, self.revision + 1);
        sample.send().map_err(|e| PublishError::Send { what: "the world", reason: e.to_string() })?;
        self.revision += 1;
        Ok(self.revision)
    }

    /// Publishes a column of the producer's own. `run_id` and `robots` of the header are filled in.
    ///
    /// # Errors
    /// [`PublishError`]; among them that another process publishes a column of that name.
    pub fn publish_column(&mut self, name: &str, header: ColumnHeader, values: &[f32]) -> Result<(), PublishError> {
        let run_id = self.run_id;
        let column = self.open_column(name.parse()?)?;
        column.write(run_id, header.tick, values.len(), |chunk| chunk.copy_from_slice(values))
    }

    /// Opens a column of the producer's own, for readers to find before there are values.
    ///
    /// # Errors
    /// As [`ColumnPublisher::open_on`].
    pub fn open_column(&mut self, name: ColumnName) -> Result<&mut ColumnPublisher, OpenError> {
        Ok(match self.columns.entry(name) {
            Entry::Occupied(entry) => entry.into_mut(),
            Entry::Vacant(entry) => {
                let column = ColumnPublisher::open_on(&self.participant, entry.key())?;
                entry.insert(column)
            }
        })
    }

    /// Connects readers that have joined since, and gives them the newest frame and world. To be called every
    /// tick, and every now and then while the clock stands. Cheap when nobody has joined.
    pub fn update(&self) {
        self.columns.values().for_each(ColumnPublisher::update);
        self.order_log.update();
        // A reader that died half connected is cleaned up by the next one to join.
        for result in
            [self.world.update_connections(), self.frames.update_connections(), self.events.update_connections()]
        {
            if let Err(error) = result {
                tracing::debug!(%error, "connecting readers");
            }
        }
    }

    /// Whether anybody reads events; if not, there is no need to collect any.
    pub fn has_event_readers(&self) -> bool {
        self.events_service.dynamic_config().number_of_subscribers() > 0
    }

    /// Whether anybody reads the order log; if not, there is no need to keep one.
    pub fn has_order_log_readers(&self) -> bool {
        self.order_log.has_readers()
    }

    /// Tells readers of the order log which orders took effect in a tick.
    ///
    /// # Errors
    /// [`PublishError`] when shared memory is full.
    pub fn publish_order_log(&mut self, tick: u64, orders: &[OrderRecord]) -> Result<(), PublishError> {
        self.order_log.publish(self.run_id, tick, orders)
    }

    /// How many processes read frames.
    pub fn frame_readers(&self) -> usize {
        self.frames_service.dynamic_config().number_of_subscribers()
    }

    /// Publishes the events of one tick. `run_id` and `sequence` of the header are filled in.
    ///
    /// # Errors
    /// [`PublishError`] when shared memory is full.
    pub fn publish_events(&mut self, header: &EventHeader, events: &[EventRecord]) -> Result<(), PublishError> {
        let sample = self
            .events
            .loan_slice_uninit(events.len())
            .map_err(|e| PublishError::Loan { what: "events", reason: e.to_string() })?;
        let mut sample = sample.write_from_slice(events);
        self.events_sent += 1;
        *sample.user_header_mut() = EventHeader { run_id: self.run_id, sequence: self.events_sent, ..*header };
        sample.send().map_err(|e| PublishError::Send { what: "events", reason: e.to_string() })?;
        Ok(())
    }
}

fn frames_publisher(
    service: &qos::Frames,
    participant: &Participant,
    robots: usize,
) -> Result<Publisher<Ipc, [Line], FrameHeader>, OpenError> {
    let create = || {
        service
            .publisher_builder()
            .max_loaned_samples(1)
            .backpressure_strategy(BackpressureStrategy::DiscardData)
            .initial_max_slice_len(frame_lines(robots.max(1)))
            .allocation_strategy(qos::GROWTH)
            .create()
    };
    let taken = |e: &PublisherCreateError| *e == PublisherCreateError::ExceedsMaxSupportedPublishers;
    let mut publisher = create();
    if publisher.as_ref().is_err_and(taken) {
        // Its owner may have died just now, or another process may be cleaning up after it.
        service.blocking_cleanup_dead_nodes(core::time::Duration::from_secs(1));
        publisher = create();
    }
    publisher.map_err(|e| match taken(&e) {
        true => OpenError::AlreadyRunning {
            fleet: participant.fleet().clone(),
            owner: qos::publisher_owner(service, &participant.node),
        },
        false => qos::full_or(service.name(), 1, e),
    })
}

/// Time and process id, stirred (splitmix64) so that runs that start together differ in every digit.
fn new_run_id() -> u64 {
    let mut z = wall_time_nanos() ^ (u64::from(std::process::id()) << 48);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}
