//! The contract as data: `plugins/python/regatta/layout.json`, by which the Python package opens
//! services and checks its own structures. This test keeps that file true. After a change of the
//! contract, write it anew:
//!
//! ```console
//! $ REGATTA_WRITE_LAYOUT=1 cargo test -p regatta-plugin --test contract layout
//! ```

use std::any::type_name;
use std::mem::offset_of;
use std::path::Path;

use iceoryx2::prelude::*;
use iceoryx2::service::Service;
use regatta_plugin::ProducerPorts;
use regatta_plugin::activity::{Activity, Ground};
use regatta_plugin::closure::{ClosedEdge, ClosureHeader};
use regatta_plugin::column::ColumnHeader;
use regatta_plugin::command::{CommandHeader, CommandKind, CommandRecord};
use regatta_plugin::command_log::CommandLogHeader;
use regatta_plugin::contact::{
    ContactChange, ContactEvent, ContactEventHeader, ContactHeader, ContactLevel, ContactRecord,
};
use regatta_plugin::control::{ControlKind, ControlRequest, ControlResponse};
use regatta_plugin::event::{BreakdownCause, EventHeader, EventKind, EventRecord, Refusal};
use regatta_plugin::facility::{DoorState, FacilityHeader, FacilityKind, FacilityState};
use regatta_plugin::frame::{CONTRACT_VERSION, ClockState, FrameHeader, NO_EDGE, RobotState};
use regatta_plugin::history::{FleetSample, HistoryHeader, HotSpot, Trend};
use regatta_plugin::manager::{ManagerAnswer, ManagerRequest, ManagerRequestKind, ManagerResponse};
use regatta_plugin::order::{NO_ROBOT, Obstacle, OrderHeader, OrderKind, OrderRecord, StopAction};
use regatta_plugin::recording::{MarkKind, RecordingHeader, RecordingMark};
use regatta_plugin::records::lockstep::Done;
use regatta_plugin::route::{RouteRequest, RouteResponse};
use regatta_plugin::traffic::{EdgeTraffic, TrafficHeader};
use regatta_plugin::work::{WorkFigures, WorkHeader};
use regatta_plugin::world::{
    BackgroundLineRecord, CurveRecord, DoorRecord, EdgeRecord, LiftLevelRecord, LiftRecord,
    NodeRecord, OtherNameRecord, RobotTypeRecord, Role, Shape, StationRecord, WorldHeader,
    ZoneRecord, ZoneRule,
};
use regatta_plugin::{
    ColumnReader, CommandLogReader, ContactEventReader, ContactReader, FleetName, HistoryReader,
    ManagerServer, OrderReader, Ownership, Participant, RecordingReader, Result, RouteServer,
    TrafficReader, WorkReader, services,
};
use serde_json::{Map, Value, json};

const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../python/regatta/layout.json");

/// Size, alignment and fields of types. Doesn't compile if a field is left out.
macro_rules! records {
    ($($type:ident { $($field:ident),* })*) => {
        Map::from_iter([$({
            let $type { $($field: _),* } = bytemuck::Zeroable::zeroed();
            let fields = json!([$([stringify!($field), kind(|r: &$type| &r.$field), offset_of!($type, $field)]),*]);
            let record = json!({ "size": size_of::<$type>(), "alignment": align_of::<$type>(), "fields": fields });
            (stringify!($type).to_owned(), record)
        }),*])
    };
}

/// Numbers of enums' variants. Doesn't compile if a variant is left out.
macro_rules! enums {
    ($($type:ident { $($variant:ident),* })*) => {
        Map::from_iter([$({
            let number = |variant: $type| match variant { $($type::$variant => variant as u32),* };
            let variants = [$((stringify!($variant).to_owned(), json!(number($type::$variant)))),*];
            (stringify!($type).to_owned(), Value::Object(Map::from_iter(variants)))
        }),*])
    };
}

/// A field's type, as Rust writes it.
fn kind<T, F>(_: fn(&T) -> &F) -> &'static str {
    type_name::<F>()
}

fn all_records() -> Map<String, Value> {
    records! {
        FrameHeader { run_id, tick, sequence, sim_time_nanos, wall_time_nanos, late_ticks, world_revision, tick_cost_nanos,
            tick_period_nanos, speed, robots, stride_lines, clock, lockstep, repeated, jumps }
        WorldHeader { run_id, revision, origin, nodes, edges, curves, robot_types, text_bytes, zones, zone_members,
            other_names, doors, lifts, lift_levels, facility_members, stations, station_nodes, background_lines,
            background_points }
        StationRecord { name, level, x, y, role, first_node, nodes }
        BackgroundLineRecord { level, first_point, points }
        ZoneRecord { name, rule, capacity, first_member, nodes, edges }
        OtherNameRecord { name, node }
        DoorRecord { name, first_edge, edges, opening_secs, closing_secs, line }
        LiftRecord { name, first_level, levels, first_ride, rides, capacity, level_secs, opening_secs, closing_secs,
            centre, size, yaw }
        LiftLevelRecord { name, first_node, nodes }
        NodeRecord { id, x, y, theta, name, level, zone, role }
        EdgeRecord { id, origin, destination, length, first_curve, curves, speed, reverse_speed, name,
            level, zone, orientation, orientation_angle, reserved }
        CurveRecord { control_points }
        RobotTypeRecord { name, shape, length, width, max_speed, max_acceleration, max_rotation_speed,
            max_rotation_acceleration, battery_capacity, drain_moving, drain_standing, charge_rate }
        ColumnHeader { run_id, tick, sequence, robots, cost_micros }
        CommandHeader { sender }
        CommandRecord { token, kind, robot, legs, id, reverse, released, robot_type, s }
        CommandLogHeader { run_id, tick, sequence }
        EventHeader { run_id, tick, dropped, sequence }
        EventRecord { token, kind, robot, id, detail }
        OrderHeader { run_id, tick, dropped, sequence }
        OrderRecord { order, kind, robot, stop, node, action, dwell_secs, detail, due_secs }
        TrafficHeader { run_id, tick, sim_time_nanos, world_revision, sequence, period_secs, edges, has_contacts,
            has_routes }
        EdgeTraffic { occupancy, entered_per_hour, relative_speed, waiting_secs, contact_secs, released, planned }
        HistoryHeader { run_id, tick, sim_time_nanos, began_nanos, sequence }
        FleetSample { secs, activities, touching, throughput, mean_speed }
        HotSpot { contact_secs, standing_secs, seen, x, y, edges, trend, reserved }
        ContactHeader { run_id, tick, sim_time_nanos, touching_ever, possible_ever, frames_skipped, sequence, touching,
            possible, capped, reserved }
        ContactRecord { since_tick, since_nanos, robots, level, edge, x, y, relative_speed, reserved }
        ContactEventHeader { run_id, tick, sequence }
        ContactEvent { tick, sim_time_nanos, robots, level, change, edge, x, y, relative_speed }
        ControlRequest { count, kind, speed }
        ControlResponse { run_id, tick, sim_time_nanos, late_ticks, tick_cost_p50_nanos, tick_cost_p99_nanos,
            resident_bytes, wall_time_nanos, robots_by_state, robots, pid, clock, speed, real_time_factor, accepted,
            reason, owner }
        RouteRequest { robot, reserved }
        RouteResponse { run_id, tick, robot, found, legs, released, released_metres, reserved,
            listed }
        ManagerRequest { kind, robot, node, reserved }
        ManagerResponse { order, answer, robot }
        ClosureHeader { run_id, tick, sequence }
        ClosedEdge { edge }
        FacilityHeader { run_id, tick, sequence }
        FacilityState { since_tick, ticks, kind, index, door, level, next_level, called_level, robot, requests,
            reserved }
        WorkHeader { run_id, tick, sequence }
        WorkFigures { secs, finished, open, failed, orders_per_hour, service_p50_secs, service_p99_secs, waiting, busy,
            robots }
        RecordingHeader { run_id, sequence, start_nanos, end_nanos, ahead_nanos, searched_nanos, left_out, file, note }
        RecordingMark { time_nanos, kind, robot, count, reserved }
        Done { run_id, tick, name }
    }
}

fn all_enums() -> Map<String, Value> {
    enums! {
        RobotState { Idle, Driving, Waiting, Held, Faulted, Turning, Stalled, Broken, Absent }
        ClockState { Running, Paused, Stopped, WarmingUp }
        Shape { Rectangle, Circle }
        Role { None, Pick, Drop, Park, Charge, Transfer }
        ZoneRule { Capacity, SameDirection }
        CommandKind { Leg, Assign, Extend, Cancel, Hold, Resume, SpawnAtNode, SpawnOnEdge, Remove, Release, Break,
            Repair, CloseEdge, OpenEdge, RequestDoor, ReleaseDoor, CallLift, ReleaseLift }
        EventKind { ReachedNode, RouteDone, WaitingForRelease, Held, Resumed, Accepted, Refused, Spawned, Removed, Faulted,
            Stalled, Recovered, BrokenDown, Repaired, EdgeClosed, EdgeOpened, DoorOpened, DoorClosed, LiftArrived,
            ActionFailed }
        FacilityKind { Door, Lift }
        DoorState { Closed, Opening, Open, Closing }
        BreakdownCause { Unknown, FlatBattery }
        Refusal { UnknownRobot, UnknownEdge, UnknownNode, UnknownRobotType, NotConnected, NoReverse, MalformedRoute,
            DistanceOutOfRange, FleetFull, MalformedCommand, NotSteerable, NotAhead, EdgeClosed, NotOwner, NoDoor,
            NoLift, LiftInUse, NoCabin }
        OrderKind { Created, Stop, Assigned, Withdrawn, Arrived, Handled, Finished, Failed, Cancelled,
            Unroutable, Reopened, Queued }
        Activity { Idle, Fetching, Carrying, Handling, Waiting, Queued, Charging, Held, Broken, Faulted, Stalled,
            Moving, Rotating }
        StopAction { None, Pick, Drop, Charge, Park }
        Obstacle { NoWay, ClosedEdges, NoRobot, Battery, NoPlace }
        ContactLevel { Possible, Touching }
        ContactChange { Began, Ended }
        MarkKind { Contact, Fault, Stop, Note }
        ManagerRequestKind { Send, Recall }
        ManagerAnswer { Now, Later, UnknownRobot, UnknownNode, NoWay, NotSent, NotReady, UnknownKind }
        Trend { Growing, Steady, Easing, Over }
        ControlKind { Status, Pause, Resume, Step, Speed, Robots, Seek }
    }
}

/// The word of each activity, and its colours on a dark and on a light ground.
fn activities() -> Map<String, Value> {
    let entry = |activity: Activity| {
        let [dark, light] =
            [Ground::Dark, Ground::Light].map(|ground| format!("#{:06x}", activity.colour(ground)));
        (activity.name().to_owned(), json!({ "dark": dark, "light": light }))
    };
    Activity::ALL.into_iter().map(entry).collect()
}

/// The properties that iceoryx2 compares when a service is opened, for every service of a fleet, by
/// pattern and name.
fn all_services(fleet: &FleetName) -> Result<Map<String, Value>> {
    let producer = ProducerPorts::create(fleet, 1)?;
    let other = Participant::join(fleet, "layout")?;
    let _open = (
        ColumnReader::open_on(&other, "NAME")?,
        ContactReader::open_on(&other)?,
        ContactEventReader::open_on(&other)?,
    );
    let (_log, _routes) = (CommandLogReader::open_on(&other)?, RouteServer::open_on(&other)?);
    let (_orders, _traffic) = (OrderReader::open_on(&other)?, TrafficReader::open_on(&other)?);
    let (_manager, _owner) = (ManagerServer::open_on(&other)?, Ownership::claim(&other)?);
    let (_recording, _history) =
        (RecordingReader::open_on(&other)?, HistoryReader::open_on(&other)?);
    let _work = WorkReader::open_on(&other)?;
    let prefix = services::service_name(fleet, "");
    let mut services = Map::new();
    ipc::Service::list(regatta_plugin::iceoryx2_config()?, |service| {
        let service = &service.static_details;
        if let Some(name) = service.name().as_str().strip_prefix(&prefix) {
            let Value::Object(mut pattern) = json!(service.messaging_pattern()) else {
                unreachable!("an enum")
            };
            for (pattern, config) in &mut pattern {
                let group = services.entry(pattern).or_insert_with(|| json!({}));
                group[name] = config.take();
            }
        }
        CallbackProgression::Continue
    })?;
    drop(producer);
    Ok(services)
}

/// JSON with one line for whatever is `depth` levels down.
fn lines(value: &Value, depth: usize, indent: &str) -> String {
    match value {
        Value::Object(members) if depth > 0 => {
            let inner = format!("{indent}  ");
            let line = |(name, value)| {
                format!("{inner}{}: {}", json!(name), lines(value, depth - 1, &inner))
            };
            format!("{{\n{}\n{indent}}}", members.iter().map(line).collect::<Vec<_>>().join(",\n"))
        }
        value => value.to_string(),
    }
}

#[test]
fn the_layout_file_is_true() {
    let fleet = format!("test-layout-{}", std::process::id()).parse().expect("a name");
    let layout = json!({
        "contract_version": CONTRACT_VERSION,
        "version_attribute": services::VERSION_ATTRIBUTE,
        "no_edge": NO_EDGE,
        "no_robot": NO_ROBOT,
        "command_buffer": services::COMMAND_BUFFER,
        "event_buffer": services::EVENT_BUFFER,
        "activities": activities(),
        "records": all_records(),
        "enums": all_enums(),
        "services": all_services(&fleet).expect("services"),
    });
    let text = lines(&layout, 3, "") + "\n";
    if std::env::var_os("REGATTA_WRITE_LAYOUT").is_some() {
        std::fs::write(FILE, &text).expect("written");
    }
    let committed = std::fs::read_to_string(Path::new(FILE)).expect("the layout file");
    let differing = text.lines().find(|line| !committed.lines().any(|other| other == *line));
    assert_eq!(
        committed, text,
        "differs at {differing:?}; REGATTA_WRITE_LAYOUT=1 writes it anew (see above)"
    );
}
