//! Encodes the records of the plugin contract as messages.
//!
//! A column's values have the same layout in the message as in memory, because protocol buffers
//! store packed numbers of fixed width contiguously and little-endian. Encoding a frame is
//! therefore a copy of its columns.

use bytemuck::Pod;
use prost::Message;
use prost::encoding::{WireType, encode_key, encode_varint};
use regatta_plugin::command::CommandRecord;
use regatta_plugin::contact::{ContactEvent, ContactHeader, ContactRecord};
use regatta_plugin::event::{EventKind, EventRecord};
use regatta_plugin::facility::{FacilityHeader, FacilityState};
use regatta_plugin::frame::FrameHeader;
use regatta_plugin::order::OrderRecord;
use regatta_plugin::world::{
    BackgroundLineRecord, DoorRecord, EdgeRecord, LiftRecord, NodeRecord, RobotTypeRecord,
    StationRecord, ZoneRecord,
};
use regatta_plugin::{ColumnValues, CommandLog, ContactEvents, Events, Frame, Orders, World};

use crate::schema::regatta;

const _: () =
    assert!(cfg!(target_endian = "little"), "columns are copied with their layout in memory");

/// Field numbers of a frame's columns: x, y, theta, speed, s, edge, state.
pub const FRAME_COLUMNS: [u32; 7] = [16, 17, 18, 19, 20, 21, 22];
/// The field number of a column's values.
pub const COLUMN_VALUES: u32 = 3;

/// The field number that marks a repeated world or column.
const IS_REPEATED: u32 = 15;

/// The largest size of a packed field's key and length, in bytes.
const FIELD_OVERHEAD: usize = 12;

/// Encodes a frame. Its columns are cut to the number of robots.
pub fn frame(frame: &Frame<'_>) -> Vec<u8> {
    let scalars = frame_scalars(frame.header());
    let columns = frame.columns();
    let bytes: [&[u8]; 7] = [
        bytemuck::cast_slice(columns.x),
        bytemuck::cast_slice(columns.y),
        bytemuck::cast_slice(columns.theta),
        bytemuck::cast_slice(columns.speed),
        bytemuck::cast_slice(columns.s),
        bytemuck::cast_slice(columns.edge),
        columns.state,
    ];
    let length: usize = bytes.iter().map(|column| column.len() + FIELD_OVERHEAD).sum();
    let mut out = Vec::with_capacity(scalars.encoded_len() + length);
    scalars.encode_raw(&mut out);
    for (tag, column) in FRAME_COLUMNS.into_iter().zip(bytes) {
        packed(tag, column, &mut out);
    }
    out
}

fn frame_scalars(header: &FrameHeader) -> regatta::Frame {
    regatta::Frame {
        run_id: header.run_id,
        tick: header.tick,
        sim_time_nanos: header.sim_time_nanos,
        wall_time_nanos: header.wall_time_nanos,
        late_ticks: header.late_ticks,
        world_revision: header.world_revision,
        tick_cost_nanos: header.tick_cost_nanos,
        tick_period_nanos: header.tick_period_nanos,
        wanted_speed: header.speed,
        robots: header.robots,
        clock: header.clock as i32,
        lockstep: header.lockstep,
        sequence: header.sequence,
        ..regatta::Frame::default()
    }
}

/// Encodes a plugin's column.
pub fn column(column: &ColumnValues<'_>) -> Vec<u8> {
    let (run_id, tick) = (column.header.run_id, column.header.tick);
    let head = regatta::Column { run_id, tick, ..regatta::Column::default() };
    let mut out =
        Vec::with_capacity(head.encoded_len() + size_of_val(column.values) + FIELD_OVERHEAD);
    head.encode_raw(&mut out);
    packed(COLUMN_VALUES, column.values, &mut out);
    out
}

/// Marks an encoded world or column as one that was recorded before.
pub fn mark_repeated(message: &mut Vec<u8>) {
    encode_key(IS_REPEATED, WireType::Varint, message);
    encode_varint(1, message);
}

/// Appends a field of packed numbers, or of bytes, which have the same encoding.
fn packed<T: Pod>(tag: u32, values: &[T], out: &mut Vec<u8>) {
    let bytes: &[u8] = bytemuck::cast_slice(values);
    if !bytes.is_empty() {
        encode_key(tag, WireType::LengthDelimited, out);
        encode_varint(bytes.len() as u64, out);
        out.extend_from_slice(bytes);
    }
}

/// Encodes the route graph and the robot types.
pub fn world(world: &World<'_>) -> Vec<u8> {
    let [origin_x, origin_y] = world.origin();
    regatta::World {
        run_id: world.run_id(),
        revision: world.revision(),
        nodes: world.nodes().iter().map(|record| node(world, record)).collect(),
        edges: world.edges().iter().map(|record| edge(world, record)).collect(),
        robot_types: world.robot_types().iter().map(robot_type).collect(),
        origin_x,
        origin_y,
        zones: world.zones().iter().map(|record| zone(world, record)).collect(),
        other_names: other_names(world),
        doors: world.doors().iter().map(|record| door(world, record)).collect(),
        lifts: world.lifts().iter().map(|record| lift(world, record)).collect(),
        stations: world.stations().iter().map(|record| station(world, record)).collect(),
        background: world.background_lines().iter().map(|line| background(world, line)).collect(),
        is_repeated: false,
    }
    .encode_to_vec()
}

fn other_names(world: &World<'_>) -> Vec<regatta::OtherName> {
    let names = world.other_names().iter();
    let names = names
        .map(|other| regatta::OtherName { name: world.text(other.name).into(), node: other.node });
    names.collect()
}

fn station(world: &World<'_>, station: &StationRecord) -> regatta::Station {
    regatta::Station {
        name: world.text(station.name).to_owned(),
        level: world.text(station.level).to_owned(),
        x: station.x,
        y: station.y,
        role: station.role as i32,
        nodes: world.station_nodes(station).to_vec(),
    }
}

fn background(world: &World<'_>, line: &BackgroundLineRecord) -> regatta::BackgroundLine {
    regatta::BackgroundLine {
        level: world.text(line.level).to_owned(),
        points: world.background_points(line).concat(),
    }
}

fn door(world: &World<'_>, door: &DoorRecord) -> regatta::Door {
    regatta::Door {
        name: world.text(door.name).to_owned(),
        edges: world.door_edges(door).to_vec(),
        opening_secs: door.opening_secs,
        closing_secs: door.closing_secs,
        line: door.line.concat(),
    }
}

fn lift(world: &World<'_>, lift: &LiftRecord) -> regatta::Lift {
    let levels = world.lift_levels(lift).iter().map(|level| regatta::LiftLevel {
        name: world.text(level.name).to_owned(),
        nodes: world.level_nodes(level).to_vec(),
    });
    let ([x, y], [width, depth]) = (lift.centre, lift.size);
    regatta::Lift {
        name: world.text(lift.name).to_owned(),
        levels: levels.collect(),
        rides: world.lift_rides(lift).to_vec(),
        capacity: lift.capacity,
        level_secs: lift.level_secs,
        opening_secs: lift.opening_secs,
        closing_secs: lift.closing_secs,
        cabin: vec![x, y, width, depth, lift.yaw],
    }
}

fn zone(world: &World<'_>, zone: &ZoneRecord) -> regatta::Zone {
    regatta::Zone {
        name: world.text(zone.name).to_owned(),
        capacity: zone.capacity,
        nodes: world.zone_nodes(zone).to_vec(),
        edges: world.zone_edges(zone).to_vec(),
    }
}

fn node(world: &World<'_>, node: &NodeRecord) -> regatta::Node {
    regatta::Node {
        id: node.id,
        x: node.x,
        y: node.y,
        theta: node.theta,
        name: world.text(node.name).to_owned(),
        level: world.text(node.level).to_owned(),
        zone: world.text(node.zone).to_owned(),
        role: node.role as i32,
    }
}

fn edge(world: &World<'_>, edge: &EdgeRecord) -> regatta::Edge {
    let points = world.curves(edge).iter().flat_map(|curve| curve.control_points);
    regatta::Edge {
        id: edge.id,
        origin: edge.origin,
        destination: edge.destination,
        length: edge.length,
        control_points: points.flatten().collect(),
        speed: edge.speed,
        reverse_speed: edge.reverse_speed,
        name: world.text(edge.name).to_owned(),
        level: world.text(edge.level).to_owned(),
        zone: world.text(edge.zone).to_owned(),
        orientation: edge.orientation as i32,
        orientation_angle: edge.orientation_angle,
    }
}

fn robot_type(robot_type: &RobotTypeRecord) -> regatta::RobotType {
    regatta::RobotType {
        name: robot_type.name().to_owned(),
        shape: robot_type.shape as i32,
        length: robot_type.length,
        width: robot_type.width,
        max_speed: robot_type.max_speed,
        max_acceleration: robot_type.max_acceleration,
        max_rotation_speed: robot_type.max_rotation_speed,
        max_rotation_acceleration: Some(robot_type.max_rotation_acceleration),
        battery_capacity: robot_type.battery_capacity,
        drain_moving: robot_type.drain_moving,
        drain_standing: robot_type.drain_standing,
        charge_rate: robot_type.charge_rate,
    }
}

/// Encodes the events of a tick.
pub fn events(events: &Events<'_>) -> Vec<u8> {
    regatta::Events {
        run_id: events.header.run_id,
        tick: events.header.tick,
        dropped: events.header.dropped,
        missed: events.missed,
        events: events.records.iter().map(event).collect(),
    }
    .encode_to_vec()
}

fn event(event: &EventRecord) -> regatta::Event {
    let is_breakdown = event.kind == EventKind::BrokenDown as u32;
    let detail = event.detail as i32;
    regatta::Event {
        token: event.token,
        kind: event.kind as i32,
        robot: event.robot,
        id: event.id,
        detail: if is_breakdown { 0 } else { detail },
        cause: if is_breakdown { detail } else { 0 },
    }
}

/// Encodes the commands of a tick, with those that were refused.
pub fn commands(log: &CommandLog<'_>) -> Vec<u8> {
    regatta::Commands {
        run_id: log.header.run_id,
        tick: log.header.tick,
        missed: log.missed,
        commands: log.records.iter().map(command).collect(),
    }
    .encode_to_vec()
}

fn command(command: &CommandRecord) -> regatta::Command {
    regatta::Command {
        token: command.token,
        kind: command.kind as i32,
        robot: command.robot,
        legs: command.legs,
        id: command.id,
        reverse: command.reverse,
        released: command.released,
        robot_type: command.robot_type,
        s: command.s,
    }
}

/// Encodes the records of transport orders of a tick.
pub fn orders(log: &Orders<'_>) -> Vec<u8> {
    regatta::TransportOrders {
        run_id: log.header.run_id,
        tick: log.header.tick,
        dropped: log.header.dropped,
        missed: log.missed,
        sequence: log.header.sequence,
        orders: log.records.iter().map(order).collect(),
    }
    .encode_to_vec()
}

fn order(order: &OrderRecord) -> regatta::TransportOrder {
    regatta::TransportOrder {
        order: order.order,
        kind: order.kind as i32,
        robot: order.robot,
        stop: order.stop,
        node: order.node,
        action: order.action as i32,
        dwell_secs: order.dwell_secs,
        detail: order.detail,
        due_secs: order.due_secs,
    }
}

/// Returns a whole list of contacts. It is an update that adds every pair: the fields of `Contacts`
/// are the first ones of `ContactUpdate`.
pub fn contacts(
    header: &ContactHeader,
    pairs: &[ContactRecord],
    number: u64,
) -> regatta::ContactUpdate {
    let added = pairs.iter().map(contact).collect();
    regatta::ContactUpdate { added, ..contact_update(header, number) }
}

/// Returns an update of contacts without pairs.
pub fn contact_update(header: &ContactHeader, number: u64) -> regatta::ContactUpdate {
    regatta::ContactUpdate {
        run_id: header.run_id,
        tick: header.tick,
        sim_time_nanos: header.sim_time_nanos,
        touching_ever: header.touching_ever,
        possible_ever: header.possible_ever,
        frames_skipped: header.frames_skipped,
        touching: header.touching,
        possible: header.possible,
        capped: header.capped,
        number,
        ..regatta::ContactUpdate::default()
    }
}

/// Returns the message of a pair of robots.
pub fn contact(pair: &ContactRecord) -> regatta::Contact {
    regatta::Contact {
        since_tick: pair.since_tick,
        since_nanos: pair.since_nanos,
        robot: pair.robots[0],
        other_robot: pair.robots[1],
        level: pair.level as i32,
        edge: pair.edge,
        x: Some(pair.x),
        y: Some(pair.y),
        relative_speed: Some(pair.relative_speed),
    }
}

/// Encodes contacts that began or ended.
pub fn contact_events(events: &ContactEvents<'_>) -> Vec<u8> {
    regatta::ContactEvents {
        run_id: events.header.run_id,
        tick: events.header.tick,
        missed: events.missed,
        events: events.records.iter().map(contact_event).collect(),
    }
    .encode_to_vec()
}

fn contact_event(event: &ContactEvent) -> regatta::ContactEvent {
    regatta::ContactEvent {
        tick: event.tick,
        sim_time_nanos: event.sim_time_nanos,
        robot: event.robots[0],
        other_robot: event.robots[1],
        level: event.level as i32,
        change: event.change as i32,
        edge: event.edge,
        x: event.x,
        y: event.y,
        relative_speed: event.relative_speed,
    }
}

/// Encodes the states of doors and lifts.
pub fn facilities(header: &FacilityHeader, states: &[FacilityState]) -> Vec<u8> {
    regatta::Facilities {
        run_id: header.run_id,
        tick: header.tick,
        states: states.iter().map(facility).collect(),
    }
    .encode_to_vec()
}

fn facility(state: &FacilityState) -> regatta::Facility {
    regatta::Facility {
        since_tick: state.since_tick,
        ticks: state.ticks,
        kind: state.kind as i32,
        index: state.index,
        door: state.door as i32,
        level: state.level,
        next_level: state.next_level,
        called_level: state.called_level,
        robot: state.robot,
        requests: state.requests,
    }
}
