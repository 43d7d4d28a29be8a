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
//! | events | 64 | 64 | 1 | 0 | 1 | 4161 | 24 B an event, 64 events to begin with: 6.4 MB |
//! | orders, per sender | 1 | 256 | 1 | 0 | 1 | 258 | 40 B a record, 64 to begin with: 0.7 MB |
//! | columns, each | 64 | 1 or 8 | 2 | 1 | 1 | 642 | 4.0 MB |
//! | contacts | 64 | 1 or 8 | 2 | 1 | 1 | 642 | 48 B a pair, 64 pairs to begin with: 2.0 MB |
//! | traffic | 64 | 1 | 2 | 1 | 1 | 194 | 28 B an edge and period: 8.4 MB at 100 k edges |
//! | history, spots | 64 | 1 | 2 | 1 | 1 | 194 | 56 and 64 B each, 1,200 and 200 at most: 67 and 13 kB |
//! | closures | 64 | 1 | 2 | 1 | 1 | 194 | 4 B an edge, 64 edges to begin with: 50 kB |
//! | recording | 64 | 1 | 2 | 1 | 1 | 194 | 24 B a mark, 64 marks to begin with, 65,536 at most: 1.6 MB |
//! | contact events, order log, tasks | 64 | 64 | 1 | 0 | 1 | 4161 | 56, 40 and 40 B each, 64 to begin with: 15, 11 and 11 MB |
//! | done, per reader | 64 | 1 | 1 | 1 | 1 | 130 | 80 B |
//! | routes, the server's answers | 16 | 1 | 1 | 0 | 1 | 8 per client and open request | 1056 B: 0.3 MB |
//!
//! Resident for frames: the newest frame (history; its readers share it), the one being written,
//! and one more for each *different* old frame that a slow reader holds. At 1 M robots that is 50
//! MB, 75 MB with a reader that keeps its frame for longer than a tick, and 25 MB more for each
//! reader stopped on a frame of its own.
//!
//! A reader of columns or contacts takes only the newest, and has a buffer of 1. A reader that
//! wants all of them (a recorder) has a buffer of 8: while it is stopped, up to 8 old samples of
//! each stay resident for it.

use iceoryx2::port::listener::Listener;
use iceoryx2::port::notifier::Notifier;
use iceoryx2::port::server::Server;
use iceoryx2::prelude::*;
use iceoryx2::service::attribute::{AttributeKey, AttributeValue};
use iceoryx2::service::port_factory::{event, publish_subscribe, request_response};

use super::error::OpenError;
use super::full_memory::{FULL, guarded};
use super::places::{MayBeFull, participants, place};
use crate::records::closure::{ClosedEdge, ClosureHeader};
use crate::records::column::ColumnHeader;
use crate::records::contact::{ContactEvent, ContactEventHeader, ContactHeader, ContactRecord};
use crate::records::control::{ControlRequest, ControlResponse};
use crate::records::event::{EventHeader, EventRecord};
use crate::records::frame::{CONTRACT_VERSION, FrameHeader, Line};
use crate::records::history::{FleetSample, HistoryHeader, HotSpot};
use crate::records::lockstep::Done;
use crate::records::manager::{ManagerRequest, ManagerResponse};
use crate::records::name::{ColumnName, FleetName};
use crate::records::order::{OrderHeader, OrderRecord};
use crate::records::order_log::OrderLogHeader;
use crate::records::recording::{RecordingHeader, RecordingMark};
use crate::records::route::{RouteRequest, RouteResponse};
use crate::records::task::{TaskHeader, TaskRecord};
use crate::records::traffic::{EdgeTraffic, TrafficHeader};
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
/// The largest number of processes at one service: the producer, readers, senders of orders,
/// control clients.
pub const MAX_PARTICIPANTS: usize = 128;
/// The largest number of senders of orders at the same time.
pub const MAX_ORDER_SENDERS: usize = 16;
/// The number of samples of a column, or of contacts, that a reader of all samples may lag behind
/// before it loses the oldest.
pub const COLUMN_BUFFER: usize = 8;
/// The largest number of samples of orders that wait for the next tick, per sender. More are
/// refused.
pub const ORDER_BUFFER: usize = 256;
/// The number of ticks with events that a reader may lag behind before it loses the oldest.
pub const EVENT_BUFFER: usize = 64;
/// The largest number of control clients at the same time.
pub const MAX_CONTROL_CLIENTS: usize = 16;
/// The largest number of unanswered requests of one client.
pub const MAX_OPEN_REQUESTS: usize = 4;
/// The largest number of clients that ask for routes at the same time.
pub const MAX_ROUTE_CLIENTS: usize = 16;
/// The largest number of routes that one client may ask for at once.
pub const MAX_OPEN_ROUTES: usize = 8;

/// The number of records in the first segment of events and of orders; more records make it grow.
pub(crate) const FIRST_RECORDS: usize = 64;

/// How segments grow. Readers map a new segment with the first chunk that they get from it.
pub(crate) const GROWTH: AllocationStrategy = AllocationStrategy::PowerOfTwo;

/// The service attribute that carries [`CONTRACT_VERSION`].
pub const VERSION_ATTRIBUTE: &str = "regatta-contract";

/// Within a process no port is shared between threads, so no operation takes a lock.
pub(crate) type Ipc = ipc::Service;
pub(crate) type Frames = publish_subscribe::PortFactory<Ipc, [Line], FrameHeader>;
pub(crate) type World = publish_subscribe::PortFactory<Ipc, [Line], WorldHeader>;
pub(crate) type Events = publish_subscribe::PortFactory<Ipc, [EventRecord], EventHeader>;
pub(crate) type Orders = publish_subscribe::PortFactory<Ipc, [OrderRecord], OrderHeader>;
pub(crate) type Column = publish_subscribe::PortFactory<Ipc, [Line], ColumnHeader>;
pub(crate) type Contacts = publish_subscribe::PortFactory<Ipc, [ContactRecord], ContactHeader>;
pub(crate) type ContactEvents =
    publish_subscribe::PortFactory<Ipc, [ContactEvent], ContactEventHeader>;
pub(crate) type OrderLogs = publish_subscribe::PortFactory<Ipc, [OrderRecord], OrderLogHeader>;
pub(crate) type Tasks = publish_subscribe::PortFactory<Ipc, [TaskRecord], TaskHeader>;
pub(crate) type Traffic = publish_subscribe::PortFactory<Ipc, [EdgeTraffic], TrafficHeader>;
pub(crate) type History = publish_subscribe::PortFactory<Ipc, [FleetSample], HistoryHeader>;
pub(crate) type Spots = publish_subscribe::PortFactory<Ipc, [HotSpot], HistoryHeader>;
pub(crate) type Closures = publish_subscribe::PortFactory<Ipc, [ClosedEdge], ClosureHeader>;
pub(crate) type Recording = publish_subscribe::PortFactory<Ipc, [RecordingMark], RecordingHeader>;
pub(crate) type Dones = publish_subscribe::PortFactory<Ipc, Done, ()>;
pub(crate) type Control =
    request_response::PortFactory<Ipc, ControlRequest, (), ControlResponse, ()>;
pub(crate) type Manager =
    request_response::PortFactory<Ipc, ManagerRequest, (), ManagerResponse, ()>;
pub(crate) type Routes = request_response::PortFactory<Ipc, RouteRequest, (), RouteResponse, ()>;

/// Returns the name of one of a fleet's services, for example `regatta/F/frames`.
pub fn service_name(fleet: &FleetName, service: &str) -> String {
    format!("regatta/{fleet}/{service}")
}

/// Opens the frames. A fleet has one producer at a time: its publisher is also the lock against a
/// second one.
pub(crate) fn frames(node: &Node<Ipc>, fleet: &FleetName) -> Result<Frames, OpenError> {
    open(node, fleet, "frames", MessagingPattern::PublishSubscribe, |builder, version| {
        newest_only(builder.publish_subscribe::<[Line]>().user_header::<FrameHeader>(), 1)
            .open_or_create_with_attributes(version)
    })
}

/// Opens the world: the route graph and the robot types.
pub(crate) fn world(node: &Node<Ipc>, fleet: &FleetName) -> Result<World, OpenError> {
    open(node, fleet, "world", MessagingPattern::PublishSubscribe, |builder, version| {
        newest_only(builder.publish_subscribe::<[Line]>().user_header::<WorldHeader>(), 1)
            .open_or_create_with_attributes(version)
    })
}

/// Opens a column: one value per robot, from a plugin.
pub(crate) fn column(
    node: &Node<Ipc>,
    fleet: &FleetName,
    column: &ColumnName,
) -> Result<Column, OpenError> {
    let service = format!("columns/{column}");
    open(node, fleet, &service, MessagingPattern::PublishSubscribe, |builder, version| {
        newest_only(
            builder.publish_subscribe::<[Line]>().user_header::<ColumnHeader>(),
            COLUMN_BUFFER,
        )
        .open_or_create_with_attributes(version)
    })
}

/// Opens the events.
pub(crate) fn events(node: &Node<Ipc>, fleet: &FleetName) -> Result<Events, OpenError> {
    open(node, fleet, "events", MessagingPattern::PublishSubscribe, |builder, version| {
        recent(builder.publish_subscribe::<[EventRecord]>().user_header::<EventHeader>())
            .open_or_create_with_attributes(version)
    })
}

/// Opens the contacts: pairs of robots that touch, or may.
pub(crate) fn contacts(node: &Node<Ipc>, fleet: &FleetName) -> Result<Contacts, OpenError> {
    open(node, fleet, "contacts", MessagingPattern::PublishSubscribe, |builder, version| {
        newest_only(
            builder.publish_subscribe::<[ContactRecord]>().user_header::<ContactHeader>(),
            COLUMN_BUFFER,
        )
        .open_or_create_with_attributes(version)
    })
}

/// Opens the changes of contacts.
pub(crate) fn contact_events(
    node: &Node<Ipc>,
    fleet: &FleetName,
) -> Result<ContactEvents, OpenError> {
    open(node, fleet, "contact_events", MessagingPattern::PublishSubscribe, |builder, version| {
        recent(builder.publish_subscribe::<[ContactEvent]>().user_header::<ContactEventHeader>())
            .open_or_create_with_attributes(version)
    })
}

/// Opens the order log: the orders that the producer applied.
pub(crate) fn order_log(node: &Node<Ipc>, fleet: &FleetName) -> Result<OrderLogs, OpenError> {
    open(node, fleet, "order_log", MessagingPattern::PublishSubscribe, |builder, version| {
        recent(builder.publish_subscribe::<[OrderRecord]>().user_header::<OrderLogHeader>())
            .open_or_create_with_attributes(version)
    })
}

/// Opens the task log: what became of transport tasks, from the fleet manager.
pub(crate) fn tasks(node: &Node<Ipc>, fleet: &FleetName) -> Result<Tasks, OpenError> {
    open(node, fleet, "tasks", MessagingPattern::PublishSubscribe, |builder, version| {
        recent(builder.publish_subscribe::<[TaskRecord]>().user_header::<TaskHeader>())
            .open_or_create_with_attributes(version)
    })
}

/// Opens the traffic on edges, from a plugin.
pub(crate) fn traffic(node: &Node<Ipc>, fleet: &FleetName) -> Result<Traffic, OpenError> {
    open(node, fleet, "traffic", MessagingPattern::PublishSubscribe, |builder, version| {
        newest_only(builder.publish_subscribe::<[EdgeTraffic]>().user_header::<TrafficHeader>(), 1)
            .open_or_create_with_attributes(version)
    })
}

/// Opens the figures of the run over time, from a plugin.
pub(crate) fn history(node: &Node<Ipc>, fleet: &FleetName) -> Result<History, OpenError> {
    open(node, fleet, "history", MessagingPattern::PublishSubscribe, |builder, version| {
        newest_only(builder.publish_subscribe::<[FleetSample]>().user_header::<HistoryHeader>(), 1)
            .open_or_create_with_attributes(version)
    })
}

/// Opens the places where robots lose time, from a plugin.
pub(crate) fn spots(node: &Node<Ipc>, fleet: &FleetName) -> Result<Spots, OpenError> {
    open(node, fleet, "spots", MessagingPattern::PublishSubscribe, |builder, version| {
        newest_only(builder.publish_subscribe::<[HotSpot]>().user_header::<HistoryHeader>(), 1)
            .open_or_create_with_attributes(version)
    })
}

/// Opens the closed edges. They aren't part of the world, because a new world makes every reader
/// begin anew.
pub(crate) fn closures(node: &Node<Ipc>, fleet: &FleetName) -> Result<Closures, OpenError> {
    open(node, fleet, "closures", MessagingPattern::PublishSubscribe, |builder, version| {
        newest_only(builder.publish_subscribe::<[ClosedEdge]>().user_header::<ClosureHeader>(), 1)
            .open_or_create_with_attributes(version)
    })
}

/// Opens what a replay tells about its recording.
pub(crate) fn recording(node: &Node<Ipc>, fleet: &FleetName) -> Result<Recording, OpenError> {
    open(node, fleet, "recording", MessagingPattern::PublishSubscribe, |builder, version| {
        newest_only(
            builder.publish_subscribe::<[RecordingMark]>().user_header::<RecordingHeader>(),
            1,
        )
        .open_or_create_with_attributes(version)
    })
}

/// Opens the orders. No overflow: an order is delivered, or its sender gets an error.
pub(crate) fn orders(node: &Node<Ipc>, fleet: &FleetName) -> Result<Orders, OpenError> {
    open(node, fleet, "orders", MessagingPattern::PublishSubscribe, |builder, version| {
        builder
            .publish_subscribe::<[OrderRecord]>()
            .user_header::<OrderHeader>()
            .enable_safe_overflow(false)
            .history_size(0)
            .subscriber_max_buffer_size(ORDER_BUFFER)
            .subscriber_max_borrowed_samples(1)
            .max_publishers(MAX_ORDER_SENDERS)
            .max_subscribers(1)
            .max_nodes(MAX_PARTICIPANTS)
            .open_or_create_with_attributes(version)
    })
}

/// Opens the lockstep reports: which tick each reader has finished. The producer reads them, and so
/// do plugins that come after others; one that joins late gets the last report of each.
pub(crate) fn done(node: &Node<Ipc>, fleet: &FleetName) -> Result<Dones, OpenError> {
    open(node, fleet, "done", MessagingPattern::PublishSubscribe, |builder, version| {
        builder
            .publish_subscribe::<Done>()
            .enable_safe_overflow(true)
            .history_size(1)
            .subscriber_max_buffer_size(1)
            .subscriber_max_borrowed_samples(1)
            .max_publishers(MAX_READERS)
            .max_subscribers(MAX_READERS)
            .max_nodes(MAX_PARTICIPANTS)
            .open_or_create_with_attributes(version)
    })
}

/// Opens the control service: pause, resume, step, speed, number of robots, status.
pub(crate) fn control(node: &Node<Ipc>, fleet: &FleetName) -> Result<Control, OpenError> {
    open(node, fleet, "control", MessagingPattern::RequestResponse, |builder, version| {
        one_server(builder.request_response::<ControlRequest, ControlResponse>())
            .max_active_requests_per_client(MAX_OPEN_REQUESTS)
            .max_clients(MAX_CONTROL_CLIENTS)
            .open_or_create_with_attributes(version)
    })
}

/// Opens the routes: the remaining legs of robots.
pub(crate) fn routes(node: &Node<Ipc>, fleet: &FleetName) -> Result<Routes, OpenError> {
    open(node, fleet, "routes", MessagingPattern::RequestResponse, |builder, version| {
        one_server(builder.request_response::<RouteRequest, RouteResponse>())
            .max_active_requests_per_client(MAX_OPEN_ROUTES)
            .max_clients(MAX_ROUTE_CLIENTS)
            .open_or_create_with_attributes(version)
    })
}

/// Opens the requests to the fleet manager.
pub(crate) fn manager(node: &Node<Ipc>, fleet: &FleetName) -> Result<Manager, OpenError> {
    open(node, fleet, "manager", MessagingPattern::RequestResponse, |builder, version| {
        one_server(builder.request_response::<ManagerRequest, ManagerResponse>())
            .max_active_requests_per_client(MAX_OPEN_REQUESTS)
            .max_clients(MAX_CONTROL_CLIENTS)
            .open_or_create_with_attributes(version)
    })
}

/// Opens an event service, which carries no data: `wake` wakes readers after a frame, `done` wakes
/// those that wait for lockstep reports.
///
/// Notifying can't block: a listener has a flag in shared memory and a datagram socket. Only the
/// notifier that sets the flag writes to the socket, it does so without blocking, and a full buffer
/// counts as success. A stopped reader thus costs one datagram, and nothing from then on.
pub(crate) fn event(
    node: &Node<Ipc>,
    fleet: &FleetName,
    service: &str,
) -> Result<event::PortFactory<Ipc>, OpenError> {
    open(node, fleet, service, MessagingPattern::Event, |builder, version| {
        builder
            .event()
            .event_id_max_value(0)
            .max_notifiers(MAX_READERS)
            .max_listeners(MAX_READERS)
            .max_nodes(MAX_PARTICIPANTS)
            .open_or_create_with_attributes(version)
    })
}

pub(crate) fn notifier(service: &event::PortFactory<Ipc>) -> Result<Notifier<Ipc>, OpenError> {
    place(service, MAX_READERS, || service.notifier_builder().create())
}

pub(crate) fn listener(service: &event::PortFactory<Ipc>) -> Result<Listener<Ipc>, OpenError> {
    place(service, MAX_READERS, || service.listener_builder().create())
}

type Builder<P, H> = iceoryx2::service::builder::publish_subscribe::Builder<[P], H, Ipc>;

/// One publisher. Readers, late ones too, get the newest sample, or up to the last `buffer`
/// samples. The publisher never waits for them.
fn newest_only<P, H>(builder: Builder<P, H>, buffer: usize) -> Builder<P, H>
where
    P: core::fmt::Debug + ZeroCopySend,
    H: core::fmt::Debug + ZeroCopySend,
{
    builder
        .enable_safe_overflow(true)
        .history_size(1)
        .subscriber_max_buffer_size(buffer)
        .subscriber_max_borrowed_samples(MAX_HELD)
        .max_publishers(1)
        .max_subscribers(MAX_READERS)
        .max_nodes(MAX_PARTICIPANTS)
}

/// One publisher. Readers get the last [`EVENT_BUFFER`] samples since they joined. The publisher
/// never waits for them.
fn recent<P, H>(builder: Builder<P, H>) -> Builder<P, H>
where
    P: core::fmt::Debug + ZeroCopySend,
    H: core::fmt::Debug + ZeroCopySend,
{
    builder
        .enable_safe_overflow(true)
        .history_size(0)
        .subscriber_max_buffer_size(EVENT_BUFFER)
        .subscriber_max_borrowed_samples(1)
        .max_publishers(1)
        .max_subscribers(MAX_READERS)
        .max_nodes(MAX_PARTICIPANTS)
}

type AskBuilder<Q, A> = iceoryx2::service::builder::request_response::Builder<Q, (), A, (), Ipc>;

/// One server, which gives each request one answer. No overflow: a request arrives, or its sender
/// gets an error.
fn one_server<Q, A>(builder: AskBuilder<Q, A>) -> AskBuilder<Q, A>
where
    Q: core::fmt::Debug + ZeroCopySend,
    A: core::fmt::Debug + ZeroCopySend,
{
    builder
        .enable_safe_overflow_for_requests(false)
        .enable_safe_overflow_for_responses(true)
        .enable_fire_and_forget_requests(false)
        .max_loaned_requests(1)
        .max_response_buffer_size(1)
        .max_borrowed_responses_per_pending_response(1)
        .max_servers(1)
        .max_nodes(MAX_PARTICIPANTS)
}

/// Opens the one server of a service.
pub(super) fn only_server<Q, A>(
    service: &request_response::PortFactory<Ipc, Q, (), A, ()>,
) -> Result<Server<Ipc, Q, (), A, ()>, OpenError>
where
    Q: core::fmt::Debug + ZeroCopySend,
    A: core::fmt::Debug + ZeroCopySend,
{
    place(service, 1, || {
        let builder =
            service.server_builder().backpressure_strategy(BackpressureStrategy::DiscardData);
        builder.max_loaned_responses_per_request(1).create()
    })
}

/// The number of attempts to open a service, 50 ms apart: services come and go while other
/// processes start and stop.
const ATTEMPTS: usize = 10;

fn open<S, E: MayBeFull>(
    node: &Node<Ipc>,
    fleet: &FleetName,
    service: &str,
    pattern: MessagingPattern,
    attempt: impl Fn(iceoryx2::service::builder::Builder<Ipc>, &AttributeVerifier) -> Result<S, E>,
) -> Result<S, OpenError> {
    let what = service_name(fleet, service);
    let failed = |reason: String| OpenError::SharedMemory { what: what.clone(), reason };
    let name = ServiceName::new(&what).map_err(|e| failed(format!("{e:?}")))?;
    let version = version_attribute(CONTRACT_VERSION).map_err(|e| failed(e.to_string()))?;
    let mut attempts = 0;
    loop {
        let (outcome, missing) = guarded(|| attempt(node.service_builder(&name), &version));
        if missing.any() {
            return Err(failed(FULL.to_owned()));
        }
        let error = match outcome {
            Ok(service) => return Ok(service),
            Err(error) => error,
        };
        // Even if iceoryx2 has already found that the payload types differ: the version explains
        // the reason.
        if let Some(theirs) = other_version(node, &name, pattern) {
            return Err(OpenError::OtherVersion { fleet: fleet.clone(), service: what, theirs });
        }
        attempts += 1;
        if attempts == ATTEMPTS {
            return Err(match error.is_full() {
                true => OpenError::Full {
                    service: what,
                    limit: MAX_PARTICIPANTS,
                    holders: participants(node, fleet),
                },
                false => failed(error.to_string()),
            });
        }
        std::thread::sleep(core::time::Duration::from_millis(50));
    }
}

/// Requires the contract version of an existing service, and defines that of a new one.
fn version_attribute(version: u32) -> Result<AttributeVerifier, OpenError> {
    let failed = |e: &dyn core::fmt::Debug| OpenError::SharedMemory {
        what: VERSION_ATTRIBUTE.to_owned(),
        reason: format!("{e:?}"),
    };
    let key = AttributeKey::new(VERSION_ATTRIBUTE.as_bytes()).map_err(|e| failed(&e))?;
    let value = AttributeValue::new(version.to_string().as_bytes()).map_err(|e| failed(&e))?;
    AttributeVerifier::new().require(&key, &value).map_err(|e| failed(&e))
}

/// Returns the contract version of an existing service if it isn't ours.
fn other_version(
    node: &Node<Ipc>,
    name: &ServiceName,
    pattern: MessagingPattern,
) -> Option<String> {
    let theirs = version_of(&Ipc::details(name, node.config(), pattern).ok()??.static_details);
    (theirs != CONTRACT_VERSION.to_string()).then_some(theirs)
}

/// Returns the contract version that a service was created with, or `unknown` if it has none.
pub(crate) fn version_of(service: &iceoryx2::service::static_config::StaticConfig) -> String {
    let key = AttributeKey::new(VERSION_ATTRIBUTE.as_bytes()).ok();
    match key.and_then(|key| service.attributes().key_value(&key, 0).copied()) {
        Some(value) => String::from_utf8_lossy(value.as_bytes()).into_owned(),
        None => "unknown".to_owned(),
    }
}
