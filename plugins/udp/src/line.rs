//! The lines that a datagram is made of.
//!
//! Poses go out as `id,x,y,theta`; the visualiser answers with `id x y theta`. Both are one type here, since they
//! differ in the separator only. A line ends with a newline, with or without a carriage return before it; the last
//! one of a datagram may go without.

use core::f32::consts::PI;
use core::f64::consts::TAU;

use crate::fixed;

/// A robot's pose as a line tells it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PoseLine {
    /// The robot.
    pub id: u32,
    /// Metres east; finite.
    pub x: f32,
    /// Metres north; finite.
    pub y: f32,
    /// Heading, counter-clockwise from east, in the protocol's [`AngleUnit`]; finite, in no particular range.
    pub theta: f32,
}

/// What stands between the four fields.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Separator {
    /// `id,x,y,theta`: poses. Blanks round a field are allowed.
    Comma,
    /// `id x y theta`: answers. Any run of blanks counts as one.
    Space,
}

/// The unit of a line's `theta`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AngleUnit {
    /// What the dissertation's visualiser takes.
    Degrees,
    /// As everywhere else in Regatta.
    Radians,
}

/// Why a line is not used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LineFault {
    /// Not an id and three numbers, set apart as they should be.
    #[error("malformed")]
    Malformed,
    /// The protocol says to ignore these.
    #[error("negative id")]
    NegativeId,
    /// More than the fleet has room for.
    #[error("id too large")]
    IdTooLarge,
    /// A coordinate or the angle is NaN, infinite, or too large for an `f32`.
    #[error("not finite")]
    NotFinite,
}

/// The form in which lines are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LineFormat {
    /// What stands between the fields.
    pub separator: Separator,
    /// Decimals of x and y, 1 to [`fixed::MAX_DECIMALS`].
    pub decimals: usize,
    /// Decimals of theta, 1 to [`fixed::MAX_DECIMALS`].
    pub theta_decimals: usize,
}

/// Longest line that [`PoseLine::write`] can write, in bytes.
pub const MAX_LINE_BYTES: usize = 176;

/// The lines of a datagram, without their ends and without empty ones.
pub fn lines(datagram: &[u8]) -> impl Iterator<Item = &[u8]> {
    datagram.split(|&byte| byte == b'\n').map(<[u8]>::trim_ascii).filter(|line| !line.is_empty())
}

impl PoseLine {
    /// Reads one line without its end.
    ///
    /// # Errors
    /// [`LineFault`].
    pub fn parse(line: &[u8], separator: Separator) -> Result<Self, LineFault> {
        let text = core::str::from_utf8(line).map_err(|_| LineFault::Malformed)?;
        let [id, x, y, theta] = fields(text, separator).ok_or(LineFault::Malformed)?;
        // The numbers first: a line of nonsense is malformed whatever its id.
        let (x, y, theta) = (number(x)?, number(y)?, number(theta)?);
        let line = Self { id: id_of(id)?, x, y, theta };
        if x.is_finite() && y.is_finite() && theta.is_finite() { Ok(line) } else { Err(LineFault::NotFinite) }
    }

    /// Appends the line and its end. [`MAX_LINE_BYTES`] are enough.
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
    /// A form with so many decimals. An angle in radians gets two more, since a radian is 57 degrees.
    pub fn new(separator: Separator, decimals: usize, unit: AngleUnit) -> Self {
        let theta_decimals = match unit {
            AngleUnit::Degrees => decimals,
            AngleUnit::Radians => (decimals + 2).min(fixed::MAX_DECIMALS),
        };
        Self { separator, decimals, theta_decimals }
    }
}

impl AngleUnit {
    /// An angle in this unit, given in radians.
    pub fn from_radians(self, radians: f32) -> f32 {
        match self {
            Self::Degrees => f64::from(radians).to_degrees() as f32,
            Self::Radians => radians,
        }
    }

    /// An angle of this unit in radians, wrapped into (-π, π].
    pub fn to_radians(self, angle: f32) -> f32 {
        let radians = match self {
            Self::Degrees => f64::from(angle).to_radians(),
            Self::Radians => f64::from(angle),
        };
        wrapped(radians)
    }

    /// A whole turn.
    pub fn turn(self) -> f64 {
        match self {
            Self::Degrees => 360.0,
            Self::Radians => TAU,
        }
    }
}

/// The `f32` nearest to π counts as π, though it is a little more.
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

/// `line.split(',')` in half the time: fields are too short for its search to pay.
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
    let (negative, digits) = match field.as_bytes() {
        [b'-', digits @ ..] => (true, digits),
        [b'+', digits @ ..] => (false, digits),
        digits => (false, digits),
    };
    if digits.is_empty() || !digits.iter().all(u8::is_ascii_digit) {
        return Err(LineFault::Malformed);
    }
    let id = digits.iter().try_fold(0_u32, |id, digit| id.checked_mul(10)?.checked_add(u32::from(digit - b'0')));
    match (negative, id) {
        (true, Some(0)) => Ok(0),
        (true, _) => Err(LineFault::NegativeId),
        (false, Some(id)) => Ok(id),
        (false, None) => Err(LineFault::IdTooLarge),
    }
}

#[cfg(test)]
mod tests;
