//! Decodes recorded messages to the records of the plugin contract.

use prost::Message;
use regatta_plugin::command::CommandRecord;
use regatta_plugin::contact::{ContactEvent, ContactHeader, ContactRecord};
use regatta_plugin::event::{EventHeader, EventRecord};
use regatta_plugin::facility::FacilityState;
use regatta_plugin::order::{OrderHeader, OrderRecord};
use regatta_plugin::world::{
    CurveRecord, DoorRecord, EdgeRecord, LiftRecord, NodeRecord, OtherNameRecord, RobotTypeRecord,
    StationRecord, Texts, WorldData, ZoneRecord, ZoneRule,
};

use crate::schema::regatta;

/// The error of decoding a message.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MessageError {
    /// The message isn't a valid protocol buffer of its type.
    #[error("{0}")]
    Malformed(#[from] prost::DecodeError),
    /// A column's length doesn't match the frame's number of robots.
    #[error("a column of {bytes} bytes doesn't fit {robots} robots")]
    ColumnLength {
        /// The column's length in bytes.
        bytes: usize,
        /// The number of robots in the frame.
        robots: usize,
    },
    /// An update of contacts doesn't fit the list before it.
    #[error("an update of contacts doesn't fit the list before it")]
    ContactUpdate,
}

/// A recorded world: the route graph and the robot types.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct RecordedWorld {
    pub run_id: u64,
    pub data: WorldData,
    /// Whether the same world was recorded before.
    pub is_repeated: bool,
}

pub(crate) fn world(message: &[u8]) -> Result<RecordedWorld, MessageError> {
    let world = regatta::World::decode(message)?;
    let mut data = WorldData {
        origin: [world.origin_x, world.origin_y],
        robot_types: world.robot_types.iter().map(robot_type).collect(),
        ..WorldData::default()
    };
    data.nodes = world.nodes.iter().map(|record| node(record, &mut data.texts)).collect();
    for recorded in &world.edges {
        let record = edge(recorded, &mut data.texts);
        data.add_edge(record, curves(&recorded.control_points));
    }
    for recorded in &world.zones {
        let record = zone(recorded, &mut data.texts);
        data.add_zone(record, recorded.nodes.iter().copied(), recorded.edges.iter().copied());
    }
    for recorded in &world.doors {
        let record = door(recorded, &mut data.texts);
        data.add_door(record, recorded.edges.iter().copied());
    }
    for recorded in &world.lifts {
        add_lift(recorded, &mut data);
    }
    for other in &world.other_names {
        let name = data.texts.add(&other.name);
        data.other_names.push(OtherNameRecord { name, node: other.node });
    }
    for recorded in &world.stations {
        let record = station(recorded, &mut data.texts);
        data.add_station(record, recorded.nodes.iter().copied());
    }
    for line in &world.background {
        let level = data.texts.add(&line.level);
        data.add_background_line(level, line.points.as_chunks::<2>().0.iter().copied());
    }
    Ok(RecordedWorld { run_id: world.run_id, data, is_repeated: world.is_repeated })
}

/// Returns a station without its nodes.
fn station(station: &regatta::Station, texts: &mut Texts) -> StationRecord {
    StationRecord {
        name: texts.add(&station.name),
        level: texts.add(&station.level),
        x: station.x,
        y: station.y,
        role: station.role as u32,
        ..StationRecord::default()
    }
}

/// Returns a door without its edges.
fn door(door: &regatta::Door, texts: &mut Texts) -> DoorRecord {
    let line = match *door.line {
        [x0, y0, x1, y1] => [[x0, y0], [x1, y1]],
        _ => [[0.0; 2]; 2],
    };
    DoorRecord {
        name: texts.add(&door.name),
        opening_secs: door.opening_secs,
        closing_secs: door.closing_secs,
        line,
        ..DoorRecord::default()
    }
}

fn add_lift(lift: &regatta::Lift, data: &mut WorldData) {
    let [x, y, width, depth, yaw] = *lift.cabin else { return };
    let record = LiftRecord {
        name: data.texts.add(&lift.name),
        capacity: lift.capacity,
        level_secs: lift.level_secs,
        opening_secs: lift.opening_secs,
        closing_secs: lift.closing_secs,
        centre: [x, y],
        size: [width, depth],
        yaw,
        ..LiftRecord::default()
    };
    let names: Vec<u32> = lift.levels.iter().map(|level| data.texts.add(&level.name)).collect();
    let nodes = lift.levels.iter().map(|level| level.nodes.iter().copied());
    data.add_lift(record, names.into_iter().zip(nodes), lift.rides.iter().copied());
}

/// Returns a zone without its members.
fn zone(zone: &regatta::Zone, texts: &mut Texts) -> ZoneRecord {
    let rule = if zone.capacity == 0 { ZoneRule::SameDirection } else { ZoneRule::Capacity };
    ZoneRecord {
        name: texts.add(&zone.name),
        rule: rule as u32,
        capacity: zone.capacity,
        ..ZoneRecord::default()
    }
}

fn node(node: &regatta::Node, texts: &mut Texts) -> NodeRecord {
    NodeRecord {
        id: node.id,
        x: node.x,
        y: node.y,
        theta: node.theta,
        name: texts.add(&node.name),
        level: texts.add(&node.level),
        zone: texts.add(&node.zone),
        role: node.role as u32,
    }
}

/// Returns the curves with these control points, eight numbers each.
fn curves(numbers: &[f32]) -> impl Iterator<Item = CurveRecord> + '_ {
    let (curves, _) = numbers.as_chunks::<8>();
    curves.iter().map(|&[ax, ay, bx, by, cx, cy, dx, dy]| CurveRecord {
        control_points: [[ax, ay], [bx, by], [cx, cy], [dx, dy]],
    })
}

/// Returns an edge without its curves.
fn edge(edge: &regatta::Edge, texts: &mut Texts) -> EdgeRecord {
    EdgeRecord {
        id: edge.id,
        origin: edge.origin,
        destination: edge.destination,
        length: edge.length,
        speed: edge.speed,
        reverse_speed: edge.reverse_speed,
        name: texts.add(&edge.name),
        level: texts.add(&edge.level),
        zone: texts.add(&edge.zone),
        orientation: edge.orientation as u32,
        orientation_angle: edge.orientation_angle,
        ..EdgeRecord::default()
    }
}

fn robot_type(robot_type: &regatta::RobotType) -> RobotTypeRecord {
    RobotTypeRecord {
        name: RobotTypeRecord::padded_name(&robot_type.name),
        shape: robot_type.shape as u32,
        length: robot_type.length,
        width: robot_type.width,
        max_speed: robot_type.max_speed,
        max_acceleration: robot_type.max_acceleration,
        max_rotation_speed: robot_type.max_rotation_speed,
        // Recordings of contract version 4 and before don't have it.
        max_rotation_acceleration: robot_type.max_rotation_acceleration.unwrap_or(f32::INFINITY),
        battery_capacity: robot_type.battery_capacity,
        drain_moving: robot_type.drain_moving,
        drain_standing: robot_type.drain_standing,
        charge_rate: robot_type.charge_rate,
    }
}

pub(crate) fn events(message: &[u8]) -> Result<(EventHeader, Vec<EventRecord>), MessageError> {
    let events = regatta::Events::decode(message)?;
    let header = EventHeader {
        run_id: events.run_id,
        tick: events.tick,
        dropped: events.dropped,
        ..EventHeader::default()
    };
    Ok((header, events.events.iter().map(event).collect()))
}

fn event(event: &regatta::Event) -> EventRecord {
    EventRecord {
        token: event.token,
        kind: event.kind as u32,
        robot: event.robot,
        id: event.id,
        detail: (event.detail | event.cause) as u32,
    }
}

/// Returns the tick, and the states of doors and lifts since then.
pub(crate) fn facilities(message: &[u8]) -> Result<(u64, Vec<FacilityState>), MessageError> {
    let facilities = regatta::Facilities::decode(message)?;
    Ok((facilities.tick, facilities.states.iter().map(facility).collect()))
}

fn facility(state: &regatta::Facility) -> FacilityState {
    FacilityState {
        since_tick: state.since_tick,
        ticks: state.ticks,
        kind: state.kind as u32,
        index: state.index,
        door: state.door as u32,
        level: state.level,
        next_level: state.next_level,
        called_level: state.called_level,
        robot: state.robot,
        requests: state.requests,
        reserved: 0,
    }
}

/// Returns the run, the tick, and the commands that took effect or were refused in it.
pub(crate) fn commands(message: &[u8]) -> Result<(u64, u64, Vec<CommandRecord>), MessageError> {
    let commands = regatta::Commands::decode(message)?;
    Ok((commands.run_id, commands.tick, commands.commands.iter().map(command).collect()))
}

fn command(command: &regatta::Command) -> CommandRecord {
    CommandRecord {
        token: command.token,
        kind: command.kind as u32,
        robot: command.robot,
        legs: command.legs,
        id: command.id,
        reverse: command.reverse,
        released: command.released,
        robot_type: command.robot_type,
        s: command.s,
    }
}

/// Returns the header of the order log's records of a tick, the records, and the number of ticks
/// that the recorder missed before it.
pub(crate) fn orders(message: &[u8]) -> Result<(OrderHeader, Vec<OrderRecord>, u64), MessageError> {
    let orders = regatta::TransportOrders::decode(message)?;
    let regatta::TransportOrders { run_id, tick, dropped, sequence, .. } = orders;
    let header = OrderHeader { run_id, tick, dropped, sequence };
    Ok((header, orders.orders.iter().map(order).collect(), orders.missed))
}

fn order(order: &regatta::TransportOrder) -> OrderRecord {
    OrderRecord {
        order: order.order,
        kind: order.kind as u32,
        robot: order.robot,
        stop: order.stop,
        node: order.node,
        action: order.action as u32,
        dwell_secs: order.dwell_secs,
        detail: order.detail,
        due_secs: order.due_secs,
    }
}

/// Returns the header of a list of contacts.
pub(crate) fn contact_header(update: &regatta::ContactUpdate) -> ContactHeader {
    ContactHeader {
        run_id: update.run_id,
        tick: update.tick,
        sim_time_nanos: update.sim_time_nanos,
        touching_ever: update.touching_ever,
        possible_ever: update.possible_ever,
        frames_skipped: update.frames_skipped,
        touching: update.touching,
        possible: update.possible,
        capped: update.capped,
        ..ContactHeader::default()
    }
}

pub(crate) fn contact(pair: &regatta::Contact) -> ContactRecord {
    ContactRecord {
        since_tick: pair.since_tick,
        since_nanos: pair.since_nanos,
        robots: [pair.robot, pair.other_robot],
        level: pair.level as u32,
        edge: pair.edge,
        x: pair.x(),
        y: pair.y(),
        relative_speed: pair.relative_speed(),
        reserved: 0,
    }
}

/// Returns the run, the tick, and the contacts that began or ended in it.
pub(crate) fn contact_events(
    message: &[u8],
) -> Result<(u64, u64, Vec<ContactEvent>), MessageError> {
    let events = regatta::ContactEvents::decode(message)?;
    Ok((events.run_id, events.tick, events.events.iter().map(contact_event).collect()))
}

fn contact_event(event: &regatta::ContactEvent) -> ContactEvent {
    ContactEvent {
        tick: event.tick,
        sim_time_nanos: event.sim_time_nanos,
        robots: [event.robot, event.other_robot],
        level: event.level as u32,
        change: event.change as u32,
        edge: event.edge,
        x: event.x,
        y: event.y,
        relative_speed: event.relative_speed,
    }
}

#[cfg(test)]
mod tests;
