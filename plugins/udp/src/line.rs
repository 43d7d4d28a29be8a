//! The text lines of a datagram.
//!
//! Poses are sent as `id,x,y,theta`; the visualiser answers with `id x y theta`. One type
//! represents both, since they differ only in the separator. A line ends with a newline, optionally
//! after a carriage return; the last line of a datagram may have no newline.

use core::f32::consts::PI;
use core::f64::consts::TAU;
use core::num::IntErrorKind;

use crate::fixed;

/// A line: a robot's id and pose.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PoseLine {
    /// The robot's id.
    pub id: u32,
    /// Metres east; finite.
    pub x: f32,
    /// Metres north; finite.
    pub y: f32,
    /// Heading, counter-clockwise from east, in the protocol's [`AngleUnit`]; finite, not limited
    /// to one turn.
    pub theta: f32,
}

/// The separator of the four fields.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Separator {
    /// `id,x,y,theta`: poses. Fields may be surrounded by whitespace.
    Comma,
    /// `id x y theta`: answers. Any amount of whitespace separates two fields.
    Space,
}

/// The unit of a line's `theta`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AngleUnit {
    /// The unit of the dissertation's visualiser.
    Degrees,
    /// The unit of the rest of Regatta.
    Radians,
}

/// The reason why a line is ignored.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LineFault {
    /// The line isn't an id and three numbers with the expected separator.
    #[error("malformed")]
    Malformed,
    /// The id is negative, which the protocol says to ignore.
    #[error("negative id")]
    NegativeId,
    /// The id is larger than the fleet allows.
    #[error("id too large")]
    IdTooLarge,
    /// A coordinate or the angle is NaN, infinite, or too large for an `f32`.
    #[error("not finite")]
    NotFinite,
}

/// The format of written lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LineFormat {
    /// The separator of the fields.
    pub separator: Separator,
    /// The number of decimals of x and y, 1 to [`fixed::MAX_DECIMALS`].
    pub decimals: usize,
    /// The number of decimals of theta, 1 to [`fixed::MAX_DECIMALS`].
    pub theta_decimals: usize,
}

/// The length of the longest line that [`PoseLine::write`] can write, in bytes.
pub const MAX_LINE_BYTES: usize = 176;

/// Returns the non-empty lines of a datagram, without newlines.
pub fn lines(datagram: &[u8]) -> impl Iterator<Item = &[u8]> {
    datagram.split(|&byte| byte == b'\n').map(<[u8]>::trim_ascii).filter(|line| !line.is_empty())
}

impl PoseLine {
    /// Parses one line without its newline.
    ///
    /// # Errors
    /// Returns a [`LineFault`] if the line has to be ignored.
    pub fn parse(line: &[u8], separator: Separator) -> Result<Self, LineFault> {
        let text = core::str::from_utf8(line).map_err(|_| LineFault::Malformed)?;
        let [id, x, y, theta] = fields(text, separator).ok_or(LineFault::Malformed)?;
        // The numbers are parsed before the id, because a malformed line is counted as malformed
        // whatever its id.
        let (x, y, theta) = (number(x)?, number(y)?, number(theta)?);
        let line = Self { id: id_of(id)?, x, y, theta };
        if line.is_finite() { Ok(line) } else { Err(LineFault::NotFinite) }
    }

    /// Whether all numbers are finite.
    pub fn is_finite(&self) -> bool {
        self.x.is_finite() && self.y.is_finite() && self.theta.is_finite()
    }

    /// Appends the line with its newline, at most [`MAX_LINE_BYTES`] bytes.
    pub fn write(&self, out: &mut Vec<u8>, format: LineFormat) {
        let separator = format.separator.byte();
        out.extend_from_slice(itoa::Buffer::new().format(self.id).as_bytes());
        out.push(separator);
        fixed::write(out, self.x, format.decimals);
        out.push(separator);
        fixed::write(out, self.y, format.decimals);
        out.push(separator);
        fixed::write(out, self.theta, format.theta_decimals);
        out.push(b'\n');
    }
}

impl Separator {
    fn byte(self) -> u8 {
        match self {
            Self::Comma => b',',
            Self::Space => b' ',
        }
    }
}

impl LineFormat {
    /// Creates a format with `decimals` decimals. Angles in radians get two more, since a radian is
    /// 57 degrees.
    pub fn new(separator: Separator, decimals: usize, unit: AngleUnit) -> Self {
        let theta_decimals = match unit {
            AngleUnit::Degrees => decimals,
            AngleUnit::Radians => (decimals + 2).min(fixed::MAX_DECIMALS),
        };
        Self { separator, decimals, theta_decimals }
    }
}

impl AngleUnit {
    /// Converts an angle from radians to this unit.
    pub fn from_radians(self, radians: f32) -> f32 {
        match self {
            Self::Degrees => f64::from(radians).to_degrees() as f32,
            Self::Radians => radians,
        }
    }

    /// Converts an angle from this unit to radians, wrapped into (-π, π].
    pub fn to_radians(self, angle: f32) -> f32 {
        let radians = match self {
            Self::Degrees => f64::from(angle).to_radians(),
            Self::Radians => f64::from(angle),
        };
        wrapped(radians)
    }

    /// Returns a full turn in this unit.
    pub fn turn(self) -> f64 {
        match self {
            Self::Degrees => 360.0,
            Self::Radians => TAU,
        }
    }
}

/// Wraps an angle into (-π, π]. The `f32` nearest to π counts as π, though it is slightly larger.
fn wrapped(radians: f64) -> f32 {
    let pi = f64::from(PI);
    let turned = if (-pi..=pi).contains(&radians) { radians } else { radians.rem_euclid(TAU) };
    let wrapped = (if turned > pi { turned - TAU } else { turned }) as f32;
    if wrapped <= -PI { PI } else { wrapped }
}

fn fields(line: &str, separator: Separator) -> Option<[&str; 4]> {
    match separator {
        Separator::Comma => four(at_commas(line).map(str::trim_ascii)),
        Separator::Space => four(line.split_ascii_whitespace()),
    }
}

/// Splits a line like `line.split(',')` in half the time, because its vectorised search is slow for
/// short fields.
fn at_commas(line: &str) -> impl Iterator<Item = &str> {
    let mut rest = Some(line);
    core::iter::from_fn(move || {
        let text = rest?;
        let comma = text.bytes().position(|byte| byte == b',');
        rest = comma.map(|at| &text[at + 1..]);
        Some(&text[..comma.unwrap_or(text.len())])
    })
}

fn four<'line>(mut fields: impl Iterator<Item = &'line str>) -> Option<[&'line str; 4]> {
    let four = [fields.next()?, fields.next()?, fields.next()?, fields.next()?];
    fields.next().is_none().then_some(four)
}

fn number(field: &str) -> Result<f32, LineFault> {
    field.parse().map_err(|_| LineFault::Malformed)
}

fn id_of(field: &str) -> Result<u32, LineFault> {
    // Parsing may overflow before it finds another character.
    if field.bytes().skip(1).any(|byte| !byte.is_ascii_digit()) {
        return Err(LineFault::Malformed);
    }
    match field.parse::<i64>() {
        Ok(..0) => Err(LineFault::NegativeId),
        Ok(id) => u32::try_from(id).map_err(|_| LineFault::IdTooLarge),
        Err(error) => Err(match error.kind() {
            IntErrorKind::NegOverflow => LineFault::NegativeId,
            IntErrorKind::PosOverflow => LineFault::IdTooLarge,
            _ => LineFault::Malformed,
        }),
    }
}

#[cfg(test)]
mod tests;
