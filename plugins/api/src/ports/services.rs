//! The services of a fleet: their names and their quality of service, in one file because each
//! number is a memory decision.
//!
//! A publisher's segment holds `subscribers × (buffer + borrowed) + history + loaned` chunks.
//! Chunks are address space only until they are written, and the pool hands out the chunk freed
//! last, so what counts for resident memory is how many chunks are in use at one time. All segments
//! grow by powers of two.
//!
//! | service | subscribers | buffer | borrowed | history | loaned | chunks | chunk at 1 M robots |
//! |---|---|---|---|---|---|---|---|
//! | frames | 64 | 1 | 2 | 1 | 1 | 194 | 25.0 MB: 4.9 GB of address space, 6.5 GB if the fleet has grown |
//! | world | 64 | 1 | 2 | 1 | 1 | 194 | 9.6 MB at 100 k edges of one curve |
//! | events | 64 | 1024 | 1 | 0 | 1 | 1161 | 24 B an event, 64 events to begin with: 1.8 MB |
//! | commands, per sender | 1 | 256 | 1 | 0 | 1 | 258 | 40 B a record, 64 to begin with: 0.7 MB |
//! | columns, each | 64 | 1 or 8 | 2 | 1 | 1 | 642 | 4.0 MB |
//! | contacts | 64 | 1 or 8 | 2 | 1 | 1 | 642 | 48 B a pair, 64 pairs to begin with: 2.0 MB |
//! | traffic | 64 | 1 | 2 | 1 | 1 | 194 | 28 B an edge and period: 8.4 MB at 100 k edges |
//! | history, spots | 64 | 1 | 2 | 1 | 1 | 194 | 56 and 64 B each, 1,200 and 200 at most: 67 and 13 kB |
//! | closures | 64 | 1 | 2 | 1 | 1 | 194 | 4 B an edge, 64 edges to begin with: 50 kB |
//! | facilities | 64 | 1 | 2 | 1 | 1 | 194 | 48 B each, 64 to begin with: 0.6 MB of address space |
//! | recording | 64 | 1 | 2 | 1 | 1 | 194 | 24 B a mark, 64 marks to begin with, 65,536 at most: 1.6 MB |
//! | work | 64 | 1 | 2 | 1 | 1 | 194 | 56 B, 64 records to begin with: 0.7 MB of address space |
//! | contact events, command log, orders | 64 | 1024 | 1 | 0 | 1 | 1161 | 56, 40 and 40 B each, 64 to begin with: 4.2, 3.0 and 3.0 MB |
//! | done, per reader | 64 | 1 | 1 | 1 | 1 | 130 | 80 B |
//! | routes, the server's answers | 16 | 1 | 1 | 0 | 1 | 8 per client and open request | 1056 B: 0.3 MB |
//!
//! Resident for frames: the newest frame (history; its readers share it), the one being written,
//! and one more for each *different* old frame that a slow reader holds. At 1 M robots that is 50
//! MB, 75 MB with a reader that keeps its frame for longer than a tick, and 25 MB more for each
//! reader stopped on a frame of its own.
//!
//! Events and logs may not be lost, so that their readers have large buffers. All readers get the
//! same samples, and overflow leaves each of them the newest ones: whichever are stopped, they wait
//! for the same chunks. So the segment has room for one buffer, and for a sample that each reader
//! holds and one that it has just given back. While a reader is stopped, 1024 samples stay resident:
//! 5 MB in a fleet of 10,000 robots with 200 events a tick.
//!
//! A reader of columns or contacts takes only the newest, and has a buffer of 1. A reader that
//! wants all of them (a recorder) has a buffer of 8: while it is stopped, up to 8 old samples of
//! each stay resident for it.

use core::marker::PhantomData;

use crate::records::closure::{ClosedEdge, ClosureHeader};
use crate::records::column::ColumnHeader;
use crate::records::command::{CommandHeader, CommandRecord};
use crate::records::command_log::CommandLogHeader;
use crate::records::contact::{ContactEvent, ContactEventHeader, ContactHeader, ContactRecord};
use crate::records::control::{ControlRequest, ControlResponse};
use crate::records::event::{EventHeader, EventRecord};
use crate::records::facility::{FacilityHeader, FacilityState};
use crate::records::frame::{FrameHeader, Line};
use crate::records::history::{FleetSample, HistoryHeader, HotSpot};
use crate::records::manager::{ManagerRequest, ManagerResponse};
use crate::records::name::{ColumnName, FleetName};
use crate::records::order::{OrderHeader, OrderRecord};
use crate::records::recording::{RecordingHeader, RecordingMark};
use crate::records::route::{RouteRequest, RouteResponse};
use crate::records::traffic::{EdgeTraffic, TrafficHeader};
use crate::records::work::{WorkFigures, WorkHeader};
use crate::records::world::WorldHeader;

/// The chunks of the frames' segment that are written to while there are one or two readers, of the
/// many that it has room for: the loaned one, the newest, and one that a reader holds.
pub const CHUNKS_IN_USE: usize = 3;

/// The largest number of readers of frames, world, events or one column at the same time.
pub const MAX_READERS: usize = 64;
/// The largest number of frames, worlds, contacts or samples of one column that a reader may hold
/// at the same time. Readers in Rust hold one. In a loop over frames in Python, the variable still
/// refers to the last frame when the next is asked for.
pub const MAX_HELD: usize = 2;
/// The largest number of processes at one service: the producer, readers, senders of commands,
/// control clients.
pub const MAX_PARTICIPANTS: usize = 128;
/// The largest number of senders of commands at the same time.
pub const MAX_COMMAND_SENDERS: usize = 16;
/// The number of samples of a column, or of contacts, that a reader of all samples may lag behind
/// before it loses the oldest.
pub const COLUMN_BUFFER: usize = 8;
/// The largest number of samples of commands that wait for the next tick, per sender. More are
/// refused.
pub const COMMAND_BUFFER: usize = 256;
/// The number of ticks with events that a reader may lag behind before it loses the oldest: 20 s in
/// real time at 50 Hz, and a second at 20 times its speed.
pub const EVENT_BUFFER: usize = 1024;
/// The number of ticks with events after which readers are woken, if there is no frame before.
pub const EVENT_WAKE: usize = 32;
/// The largest number of control clients at the same time.
pub const MAX_CONTROL_CLIENTS: usize = 16;
/// The largest number of unanswered requests of one client.
pub const MAX_OPEN_REQUESTS: usize = 4;
/// The largest number of clients that ask for routes at the same time.
pub const MAX_ROUTE_CLIENTS: usize = 16;
/// The largest number of routes that one client may ask for at once.
pub const MAX_OPEN_ROUTES: usize = 8;

/// The number of records in the first segment of events and of commands; more records make it grow.
pub(crate) const FIRST_RECORDS: usize = 64;

/// The service attribute that carries [`CONTRACT_VERSION`](crate::frame::CONTRACT_VERSION).
pub const VERSION_ATTRIBUTE: &str = "regatta-contract";

/// A publish-subscribe service whose samples are slices of records `T` under headers `H`.
pub(crate) struct SliceService<T, H> {
    /// The last part of its name.
    pub(crate) name: &'static str,
    /// The subject of error messages.
    pub(crate) subject: &'static str,
    pub(crate) quality: Quality,
    sample: PhantomData<(T, H)>,
}

/// The quality of a publish-subscribe service.
#[derive(Clone, Copy)]
pub(crate) struct Quality {
    /// Whether the publisher overwrites the oldest sample of a slow reader. If not, the publisher
    /// gets an error.
    pub(crate) overflows: bool,
    pub(crate) history: usize,
    pub(crate) buffer: usize,
    pub(crate) borrowed: usize,
    pub(crate) publishers: usize,
    pub(crate) subscribers: usize,
}

/// One publisher. Readers, late ones too, get the newest sample, or up to the last `buffer`
/// samples. The publisher never waits for them.
const fn newest(buffer: usize) -> Quality {
    Quality {
        overflows: true,
        history: 1,
        buffer,
        borrowed: MAX_HELD,
        publishers: 1,
        subscribers: MAX_READERS,
    }
}

/// One publisher. Readers get the last [`EVENT_BUFFER`] samples since they joined. The publisher
/// never waits for them.
const RECENT: Quality = Quality {
    overflows: true,
    history: 0,
    buffer: EVENT_BUFFER,
    borrowed: 1,
    publishers: 1,
    subscribers: MAX_READERS,
};

/// No overflow: a command is delivered, or its sender gets an error.
const DELIVERED: Quality = Quality {
    overflows: false,
    history: 0,
    buffer: COMMAND_BUFFER,
    borrowed: 1,
    publishers: MAX_COMMAND_SENDERS,
    subscribers: 1,
};

/// The frames. Their publisher is also the lock against a second producer of the fleet.
pub(crate) const FRAMES: SliceService<Line, FrameHeader> =
    SliceService::new("frames", "a frame", newest(1));
/// The world: the route graph and the robot types.
pub(crate) const WORLD: SliceService<Line, WorldHeader> =
    SliceService::new("world", "the world", newest(1));
/// The columns: one value per robot each, from a plugin.
pub(crate) const COLUMNS: SliceService<Line, ColumnHeader> =
    SliceService::new("columns", "a column", newest(COLUMN_BUFFER));
/// The events of robots.
pub(crate) const EVENTS: SliceService<EventRecord, EventHeader> =
    SliceService::new("events", "events", RECENT);
/// The contacts: pairs of robots that touch, or may.
pub(crate) const CONTACTS: SliceService<ContactRecord, ContactHeader> =
    SliceService::new("contacts", "contacts", newest(COLUMN_BUFFER));
/// The changes of contacts.
pub(crate) const CONTACT_EVENTS: SliceService<ContactEvent, ContactEventHeader> =
    SliceService::new("contact_events", "contact events", RECENT);
/// The command log: the commands that the producer applied.
pub(crate) const COMMAND_LOG: SliceService<CommandRecord, CommandLogHeader> =
    SliceService::new("command_log", "the command log", RECENT);
/// The order log of transport orders, from the fleet manager.
pub(crate) const ORDERS: SliceService<OrderRecord, OrderHeader> =
    SliceService::new("orders", "the order log", RECENT);
/// The traffic on edges, from a plugin.
pub(crate) const TRAFFIC: SliceService<EdgeTraffic, TrafficHeader> =
    SliceService::new("traffic", "traffic", newest(1));
/// The figures of the run over time, from a plugin.
pub(crate) const HISTORY: SliceService<FleetSample, HistoryHeader> =
    SliceService::new("history", "history", newest(1));
/// The places where robots lose time, from a plugin.
pub(crate) const SPOTS: SliceService<HotSpot, HistoryHeader> =
    SliceService::new("spots", "spots", newest(1));
/// The closed edges. They aren't part of the world, because a new world makes every reader begin
/// anew.
pub(crate) const CLOSURES: SliceService<ClosedEdge, ClosureHeader> =
    SliceService::new("closures", "closures", newest(1));
/// The states of doors and lifts. The facilities themselves are part of the world.
pub(crate) const FACILITIES: SliceService<FacilityState, FacilityHeader> =
    SliceService::new("facilities", "facilities", newest(1));
/// The recording that a replay plays.
pub(crate) const RECORDING: SliceService<RecordingMark, RecordingHeader> =
    SliceService::new("recording", "recording", newest(1));
/// The figures of the fleet's work, from the fleet manager.
pub(crate) const WORK: SliceService<WorkFigures, WorkHeader> =
    SliceService::new("work", "the figures of work", newest(1));
/// The commands to robots.
pub(crate) const COMMANDS: SliceService<CommandRecord, CommandHeader> =
    SliceService::new("commands", "commands", DELIVERED);

impl Quality {
    /// The number of chunks of a segment that all readers share, if it is less than one buffer for
    /// each reader.
    pub(crate) const fn shared_chunks(&self) -> Option<usize> {
        match self.overflows && self.history == 0 {
            true => Some(self.buffer + self.subscribers * (self.borrowed + 1) + 1 + SPARE_CHUNKS),
            false => None,
        }
    }
}

/// Chunks beyond those that are needed.
const SPARE_CHUNKS: usize = 8;

impl<T, H> SliceService<T, H> {
    const fn new(name: &'static str, subject: &'static str, quality: Quality) -> Self {
        Self { name, subject, quality, sample: PhantomData }
    }
}

/// A request-response service with one server, which gives each request `Q` one answer `A`.
pub(crate) struct RequestService<Q, A> {
    /// The last part of its name.
    pub(crate) name: &'static str,
    /// The subject of error messages.
    pub(crate) subject: &'static str,
    /// The server in error messages.
    pub(crate) server: &'static str,
    /// The largest number of clients.
    pub(crate) clients: usize,
    /// The largest number of unanswered requests of a client.
    pub(crate) open_requests: usize,
    exchange: PhantomData<(Q, A)>,
}

/// The claim on the movement of the robots: an event service with one notifier, which notifies
/// nobody.
pub(crate) const OWNER: &str = "owner";

/// The control service: pause, resume, step, speed, number of robots, status.
pub(crate) const CONTROL: RequestService<ControlRequest, ControlResponse> =
    RequestService::new("control", "control requests", "the engine", MAX_CONTROL_CLIENTS);
/// The routes: the remaining legs of robots.
pub(crate) const ROUTES: RequestService<RouteRequest, RouteResponse> = RequestService {
    open_requests: MAX_OPEN_ROUTES,
    ..RequestService::new("routes", "route requests", "the engine", MAX_ROUTE_CLIENTS)
};
/// The requests to the fleet manager.
pub(crate) const MANAGER: RequestService<ManagerRequest, ManagerResponse> = RequestService::new(
    "manager",
    "requests to the manager",
    "the fleet manager",
    MAX_CONTROL_CLIENTS,
);

impl<Q, A> RequestService<Q, A> {
    const fn new(
        name: &'static str,
        subject: &'static str,
        server: &'static str,
        clients: usize,
    ) -> Self {
        let open_requests = MAX_OPEN_REQUESTS;
        Self { name, subject, server, clients, open_requests, exchange: PhantomData }
    }
}

/// Returns the name of one of a fleet's services, for example `regatta/F/frames`.
pub fn service_name(fleet: &FleetName, service: &str) -> String {
    format!("regatta/{fleet}/{service}")
}

/// Returns the name of the service of a column.
pub(crate) fn column_service(name: &ColumnName) -> String {
    format!("{}/{name}", COLUMNS.name)
}
