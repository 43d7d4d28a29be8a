//! All messages but frames.

use regatta_plugin::World;
use regatta_plugin::column::ColumnHeader;
use regatta_plugin::command::CommandRecord;
use regatta_plugin::control::{ControlRequest, ControlResponse};
use regatta_plugin::event::{EventHeader, EventRecord};
use regatta_plugin::world::{WorldData, WorldHeader};

use super::{Kind, MAX_ROBOTS, WireError, message, rows, split, values};

/// The largest number of records in a message.
pub const MAX_RECORDS: u32 = 1 << 20;

/// Returns the message of a world.
pub fn encode_world(world: &World<'_>) -> Vec<u8> {
    message(Kind::World, world.header(), &world.sections())
}

/// Reads a world: its header, as the sender's fleet has it, and its content.
///
/// # Errors
/// A [`WireError`] if it isn't a world, or its sections contradict its header.
pub fn decode_world(bytes: &[u8]) -> Result<(WorldHeader, WorldData), WireError> {
    let (header, body) = split::<WorldHeader>(bytes, Kind::World)?;
    let world = WorldData::from_bytes(&header, body).ok_or(WireError::Length)?;
    Ok((header, world))
}

/// Returns the message of the events of a tick.
pub fn encode_events(header: &EventHeader, events: &[EventRecord]) -> Vec<u8> {
    message(Kind::Events, header, &[bytemuck::cast_slice(events)])
}

/// Reads the events of a tick.
///
/// # Errors
/// A [`WireError`] if they aren't events.
pub fn decode_events(bytes: &[u8]) -> Result<(EventHeader, Vec<EventRecord>), WireError> {
    let (header, body) = split::<EventHeader>(bytes, Kind::Events)?;
    Ok((header, records(body)?))
}

/// Returns the message of commands, each with its token and its legs after it.
pub fn encode_commands(commands: &[CommandRecord]) -> Vec<u8> {
    message(Kind::Commands, &[0_u8; 0], &[bytemuck::cast_slice(commands)])
}

/// Reads commands. The engine checks each of them.
///
/// # Errors
/// A [`WireError`] if they aren't commands.
pub fn decode_commands(bytes: &[u8]) -> Result<Vec<CommandRecord>, WireError> {
    let (_, body) = split::<[u8; 0]>(bytes, Kind::Commands)?;
    records(body)
}

/// A column from another host.
#[derive(Clone, Debug, PartialEq)]
pub struct ColumnMessage {
    /// The header, as the sender's fleet has it.
    pub header: ColumnHeader,
    /// One value per robot.
    pub values: Vec<f32>,
}

/// Returns the message of a column.
pub fn encode_column(header: &ColumnHeader, values: &[f32]) -> Vec<u8> {
    message(Kind::Column, header, &[bytemuck::cast_slice(values)])
}

/// Reads a column.
///
/// # Errors
/// A [`WireError`] if it isn't a column, or has another number of values than its header says.
pub fn decode_column(bytes: &[u8]) -> Result<ColumnMessage, WireError> {
    let (header, body) = split::<ColumnHeader>(bytes, Kind::Column)?;
    let robots = rows(header.robots, MAX_ROBOTS)?;
    if body.len() != size_of::<f32>() * robots {
        return Err(WireError::Length);
    }
    Ok(ColumnMessage { header, values: values(body) })
}

/// Returns the message of a control request.
pub fn encode_control_request(request: &ControlRequest) -> Vec<u8> {
    message(Kind::ControlRequest, request, &[])
}

/// Reads a control request.
///
/// # Errors
/// A [`WireError`] if it isn't one.
pub fn control_request(bytes: &[u8]) -> Result<ControlRequest, WireError> {
    alone(split(bytes, Kind::ControlRequest)?)
}

/// Returns the message of the answer to a control request.
pub fn encode_control_response(response: &ControlResponse) -> Vec<u8> {
    message(Kind::ControlResponse, response, &[])
}

/// Reads the answer to a control request.
///
/// # Errors
/// A [`WireError`] if it isn't one.
pub fn control_response(bytes: &[u8]) -> Result<ControlResponse, WireError> {
    alone(split(bytes, Kind::ControlResponse)?)
}

/// Returns a record that has nothing after it.
fn alone<T>((record, rest): (T, &[u8])) -> Result<T, WireError> {
    if rest.is_empty() { Ok(record) } else { Err(WireError::Length) }
}

/// Returns whole records.
fn records<T: bytemuck::Pod>(body: &[u8]) -> Result<Vec<T>, WireError> {
    if !body.len().is_multiple_of(size_of::<T>()) {
        return Err(WireError::Length);
    }
    let count = body.len() / size_of::<T>();
    if count > MAX_RECORDS as usize {
        return Err(WireError::TooMany { count: count as u64, max: MAX_RECORDS.into() });
    }
    Ok(values(body))
}
