//! Frames: raw, bit by bit, with 25 bytes a robot; or `q16`, with 15 bytes a robot.

use bytemuck::{Pod, Zeroable};
use regatta_plugin::Frame;
use regatta_plugin::frame::{ColumnsMut, FrameHeader, RobotState};

use super::{Kind, MAX_ROBOTS, WireError, message, rows, split};

/// The encoding of frames.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "zenoh", derive(clap::ValueEnum))]
pub enum Encoding {
    /// All bits of a frame: 25 bytes a robot.
    #[default]
    Raw,
    /// Positions and distances in steps of 1/65535 of their extent, headings in steps of 0.1 mrad,
    /// speeds in steps of 2 mm/s up to 65 m/s: 15 bytes a robot.
    Q16,
}

impl Encoding {
    /// All encodings.
    pub const ALL: [Self; 2] = [Self::Raw, Self::Q16];

    /// The last part of its key.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Raw => "raw",
            Self::Q16 => "q16",
        }
    }

    const fn kind(self) -> Kind {
        match self {
            Self::Raw => Kind::RawFrame,
            Self::Q16 => Kind::Q16Frame,
        }
    }

    /// Bytes of each column: x, y, theta, speed, s, edge, state.
    const fn widths(self) -> [usize; 7] {
        match self {
            Self::Raw => [4, 4, 4, 4, 4, 4, 1],
            Self::Q16 => [2, 2, 2, 2, 2, 4, 1],
        }
    }
}

/// Steps per unit of a speed in metres per second.
const SPEED_STEPS: f32 = 500.0;
/// Steps of a heading in π.
const HEADING_STEPS: f32 = 32767.0;

/// The smallest and the largest value of a column.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
struct Extent {
    from: f32,
    to: f32,
}

/// The extents of x, y and s.
type Extents = [Extent; 3];

impl Extent {
    /// Returns the extent of the finite values of a column.
    fn of(values: &[f32]) -> Self {
        let finite = values.iter().copied().filter(|value| value.is_finite());
        let empty = Self { from: f32::INFINITY, to: f32::NEG_INFINITY };
        let extent = finite.fold(empty, |extent, value| Self {
            from: extent.from.min(value),
            to: extent.to.max(value),
        });
        if extent.from <= extent.to { extent } else { Self::default() }
    }

    fn is_valid(self) -> bool {
        self.from.is_finite() && self.to.is_finite() && self.from <= self.to
    }

    fn quantize(self, value: f32) -> u16 {
        let span = f64::from(self.to) - f64::from(self.from);
        let part = (f64::from(value) - f64::from(self.from)) / span.max(f64::MIN_POSITIVE);
        (part * 65535.0).round() as u16
    }

    fn value(self, step: u16) -> f32 {
        let span = f64::from(self.to) - f64::from(self.from);
        (f64::from(self.from) + span * f64::from(step) / 65535.0) as f32
    }
}

/// Returns the message of a frame.
pub fn encode_frame(frame: &Frame<'_>, encoding: Encoding) -> Vec<u8> {
    match encoding {
        Encoding::Raw => raw(frame),
        Encoding::Q16 => q16(frame),
    }
}

fn raw(frame: &Frame<'_>) -> Vec<u8> {
    use bytemuck::cast_slice;
    let parts = [
        cast_slice(frame.x()),
        cast_slice(frame.y()),
        cast_slice(frame.theta()),
        cast_slice(frame.speed()),
        cast_slice(frame.s()),
        cast_slice(frame.edge()),
        frame.state(),
    ];
    message(Kind::RawFrame, frame.header(), &parts)
}

fn q16(frame: &Frame<'_>) -> Vec<u8> {
    let extents: Extents = [frame.x(), frame.y(), frame.s()].map(Extent::of);
    let [x, y, s] = extents;
    let mut steps: Vec<u16> = Vec::with_capacity(5 * frame.len());
    steps.extend(frame.x().iter().map(|&value| x.quantize(value)));
    steps.extend(frame.y().iter().map(|&value| y.quantize(value)));
    steps.extend(
        frame
            .theta()
            .iter()
            .map(|theta| (theta / core::f32::consts::PI * HEADING_STEPS).round() as i16 as u16),
    );
    steps.extend(frame.speed().iter().map(|speed| (speed * SPEED_STEPS).round() as i16 as u16));
    steps.extend(frame.s().iter().map(|&value| s.quantize(value)));
    let parts = [
        bytemuck::bytes_of(&extents),
        bytemuck::cast_slice(&steps),
        bytemuck::cast_slice(frame.edge()),
        frame.state(),
    ];
    message(Kind::Q16Frame, frame.header(), &parts)
}

/// The bytes of the columns of a frame.
#[derive(Clone, Copy, Debug)]
pub struct Columns<'message> {
    parts: [&'message [u8]; 7],
    extents: Extents,
    encoding: Encoding,
}

/// A frame from another host, whose lengths are checked.
#[derive(Clone, Copy, Debug)]
pub struct FrameMessage<'message> {
    /// The header, as the sender's fleet has it.
    pub header: FrameHeader,
    columns: Columns<'message>,
}

impl<'message> FrameMessage<'message> {
    /// Parses a message.
    ///
    /// # Errors
    /// A [`WireError`] if it isn't a frame in this encoding.
    pub fn parse(bytes: &'message [u8], encoding: Encoding) -> Result<Self, WireError> {
        let (header, mut rest): (FrameHeader, _) = split(bytes, encoding.kind())?;
        let robots = rows(header.robots, MAX_ROBOTS)?;
        let mut extents = Extents::default();
        if encoding == Encoding::Q16 {
            let (first, after) =
                rest.split_at_checked(size_of::<Extents>()).ok_or(WireError::Length)?;
            (extents, rest) = (bytemuck::pod_read_unaligned(first), after);
            if !extents.iter().all(|extent| extent.is_valid()) {
                return Err(WireError::Value);
            }
        }
        let mut parts = [&rest[..0]; 7];
        for (part, width) in parts.iter_mut().zip(encoding.widths()) {
            (*part, rest) = rest.split_at_checked(width * robots).ok_or(WireError::Length)?;
        }
        if !rest.is_empty() {
            return Err(WireError::Length);
        }
        Ok(Self { header, columns: Columns { parts, extents, encoding } })
    }

    /// The number of robots.
    pub fn len(&self) -> usize {
        self.header.robots as usize
    }

    /// Whether there are no robots.
    pub fn is_empty(&self) -> bool {
        self.header.robots == 0
    }

    /// Writes the columns of a frame of as many robots.
    ///
    /// # Panics
    /// If the frame has fewer rows than [`len`](Self::len).
    pub fn write(&self, columns: &mut ColumnsMut<'_>) {
        let robots = self.len();
        let Columns { parts, extents, encoding } = self.columns;
        let [x, y, theta, speed, s, edge, state] = parts;
        match encoding {
            Encoding::Raw => {
                copy(x, &mut columns.x[..robots]);
                copy(y, &mut columns.y[..robots]);
                copy(theta, &mut columns.theta[..robots]);
                copy(speed, &mut columns.speed[..robots]);
                copy(s, &mut columns.s[..robots]);
            }
            Encoding::Q16 => {
                let heading = core::f32::consts::PI / HEADING_STEPS;
                expand(x, columns.x, |step| extents[0].value(step));
                expand(y, columns.y, |step| extents[1].value(step));
                expand(theta, columns.theta, |step| f32::from(step as i16) * heading);
                expand(speed, columns.speed, |step| f32::from(step as i16) / SPEED_STEPS);
                expand(s, columns.s, |step| extents[2].value(step));
            }
        }
        bytemuck::cast_slice_mut::<u32, u8>(&mut columns.edge[..robots]).copy_from_slice(edge);
        columns.state[..robots].copy_from_slice(state);
    }

    /// Returns the number of robots by state.
    pub fn robots_by_state(&self) -> [u32; RobotState::COUNT] {
        let mut counts = [0; RobotState::COUNT];
        for state in self.columns.parts[6] {
            if let Some(count) = counts.get_mut(usize::from(*state)) {
                *count += 1;
            }
        }
        counts
    }
}

fn copy(bytes: &[u8], column: &mut [f32]) {
    bytemuck::cast_slice_mut::<f32, u8>(column).copy_from_slice(bytes);
}

fn expand(bytes: &[u8], column: &mut [f32], value: impl Fn(u16) -> f32) {
    for (target, step) in column.iter_mut().zip(bytes.as_chunks::<2>().0) {
        *target = value(u16::from_le_bytes(*step));
    }
}
