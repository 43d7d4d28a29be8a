//! Views of recorded frames and columns, which borrow their values from the encoded message.

use prost::Message;
use prost::bytes::Buf;
use prost::encoding::{DecodeContext, WireType, decode_key, decode_varint};
use regatta_plugin::Frame;
use regatta_plugin::frame::{ColumnsMut, FrameHeader, Line, frame_lines, stride_lines};

use crate::decode::MessageError;
use crate::encode::{COLUMN_VALUES, FRAME_COLUMNS};
use crate::schema::regatta;

/// A recorded frame, whose columns are slices of the message.
#[derive(Clone, Debug)]
pub(crate) struct RecordedFrame<'message> {
    /// The recorded header; `stride_lines` is 0, because it describes shared memory.
    pub header: FrameHeader,
    columns: [&'message [u8]; 7],
}

impl<'message> RecordedFrame<'message> {
    pub fn parse(mut message: &'message [u8]) -> Result<Self, MessageError> {
        let mut scalars = regatta::Frame::default();
        let mut columns = [&message[..0]; 7];
        while !message.is_empty() {
            let (tag, wire_type) = decode_key(&mut message)?;
            match FRAME_COLUMNS.iter().position(|column| *column == tag) {
                Some(column) => columns[column] = packed(wire_type, &mut message)?,
                None => {
                    scalars.merge_field(tag, wire_type, &mut message, DecodeContext::default())?
                }
            }
        }
        let robots = scalars.robots as usize;
        let widths = [4, 4, 4, 4, 4, 4, 1];
        match columns.iter().zip(widths).find(|(column, width)| column.len() != robots * width) {
            Some((column, _)) => Err(MessageError::ColumnLength { bytes: column.len(), robots }),
            None => Ok(Self { header: frame_header(&scalars), columns }),
        }
    }

    /// Returns the number of robots.
    pub fn len(&self) -> usize {
        self.header.robots as usize
    }

    /// Copies the columns to those of a frame with the same number of robots.
    pub fn copy_to(&self, columns: &mut ColumnsMut<'_>) {
        let robots = self.len();
        let [x, y, theta, speed, s, edge, state] = self.columns;
        for (target, source) in [
            (&mut *columns.x, x),
            (&mut *columns.y, y),
            (&mut *columns.theta, theta),
            (&mut *columns.speed, speed),
            (&mut *columns.s, s),
        ] {
            bytemuck::cast_slice_mut::<f32, u8>(&mut target[..robots]).copy_from_slice(source);
        }
        bytemuck::cast_slice_mut::<u32, u8>(&mut columns.edge[..robots]).copy_from_slice(edge);
        columns.state[..robots].copy_from_slice(state);
    }

    /// Returns the `state` column.
    pub fn states(&self) -> &'message [u8] {
        self.columns[6]
    }

    /// Returns a robot's row, or `None` if the frame has no such row.
    pub fn row(&self, robot: usize) -> Option<Row> {
        let [x, y, theta, speed, s, edge, state] = self.columns;
        Some(Row {
            state: *state.get(robot)?,
            x: float(x, robot)?,
            y: float(y, robot)?,
            theta: float(theta, robot)?,
            speed: float(speed, robot)?,
            s: float(s, robot)?,
            edge: word(edge, robot)?,
        })
    }
}

/// Returns a robot's value in a column of 32-bit numbers.
fn word(column: &[u8], robot: usize) -> Option<u32> {
    column.as_chunks().0.get(robot).map(|bytes| u32::from_le_bytes(*bytes))
}

fn float(column: &[u8], robot: usize) -> Option<f32> {
    word(column, robot).map(f32::from_bits)
}

/// A buffer in which a recorded frame is laid out like a live one.
#[derive(Debug, Default)]
pub(crate) struct FrameBuffer {
    header: FrameHeader,
    lines: Vec<Line>,
}

impl FrameBuffer {
    /// Copies a recorded frame to the buffer, and returns it as readers of a fleet see it.
    pub fn fill(&mut self, recorded: &RecordedFrame<'_>) -> Option<Frame<'_>> {
        let robots = recorded.len();
        self.header = FrameHeader { stride_lines: stride_lines(robots) as u32, ..recorded.header };
        self.lines.resize(frame_lines(robots), Line::default());
        recorded.copy_to(&mut ColumnsMut::split(&mut self.lines, robots));
        Frame::new(&self.header, &self.lines)
    }
}

/// One robot in one frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Row {
    pub x: f32,
    pub y: f32,
    pub theta: f32,
    pub speed: f32,
    pub s: f32,
    pub edge: u32,
    pub state: u8,
}

fn frame_header(frame: &regatta::Frame) -> FrameHeader {
    FrameHeader {
        run_id: frame.run_id,
        tick: frame.tick,
        sim_time_nanos: frame.sim_time_nanos,
        wall_time_nanos: frame.wall_time_nanos,
        late_ticks: frame.late_ticks,
        world_revision: frame.world_revision,
        tick_cost_nanos: frame.tick_cost_nanos,
        tick_period_nanos: frame.tick_period_nanos,
        speed: frame.wanted_speed,
        robots: frame.robots,
        clock: frame.clock as u32,
        lockstep: frame.lockstep,
        sequence: frame.sequence,
        ..FrameHeader::default()
    }
}

/// Splits the bytes of a packed field off the message.
fn packed<'message>(
    wire_type: WireType,
    message: &mut &'message [u8],
) -> Result<&'message [u8], MessageError> {
    prost::encoding::check_wire_type(WireType::LengthDelimited, wire_type)?;
    let length = usize::try_from(decode_varint(message)?).unwrap_or(usize::MAX);
    // A field that claims to be longer than the message gets the rest of it, which then fails the
    // length check.
    let (bytes, rest) = message.split_at(length.min(message.remaining()));
    *message = rest;
    Ok(bytes)
}

/// A recorded column, whose values are a slice of the message.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RecordedColumn<'message> {
    pub run_id: u64,
    pub tick: u64,
    /// Whether the same column was recorded before.
    pub is_repeated: bool,
    values: &'message [u8],
}

impl<'message> RecordedColumn<'message> {
    pub fn parse(mut message: &'message [u8]) -> Result<Self, MessageError> {
        let (mut head, mut values) = (regatta::Column::default(), &message[..0]);
        while !message.is_empty() {
            let (tag, wire_type) = decode_key(&mut message)?;
            match tag {
                COLUMN_VALUES => values = packed(wire_type, &mut message)?,
                _ => head.merge_field(tag, wire_type, &mut message, DecodeContext::default())?,
            }
        }
        match values.len() % 4 {
            0 => {
                let regatta::Column { run_id, tick, is_repeated, .. } = head;
                Ok(Self { run_id, tick, is_repeated, values })
            }
            _ => Err(MessageError::ColumnLength { bytes: values.len(), robots: values.len() / 4 }),
        }
    }

    /// Returns the number of values.
    pub fn len(&self) -> usize {
        self.values.len() / 4
    }

    /// Copies the values to a slice of the same length.
    pub fn copy_to(&self, target: &mut [f32]) {
        bytemuck::cast_slice_mut::<f32, u8>(target).copy_from_slice(self.values);
    }

    /// Returns a copy of the values.
    pub fn values(&self) -> Vec<f32> {
        let mut values = vec![0.0; self.len()];
        self.copy_to(&mut values);
        values
    }
}
