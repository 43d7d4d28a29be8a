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
        let [id, x, y, theta] = fields(line, separator).ok_or(LineFault::Malformed)?;
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

fn fields(line: &[u8], separator: Separator) -> Option<[&[u8]; 4]> {
    match separator {
        Separator::Comma => four(line.split(|&byte| byte == b',').map(<[u8]>::trim_ascii)),
        Separator::Space => four(line.split(u8::is_ascii_whitespace).filter(|field| !field.is_empty())),
    }
}

fn four<'line>(mut fields: impl Iterator<Item = &'line [u8]>) -> Option<[&'line [u8]; 4]> {
    let four = [fields.next()?, fields.next()?, fields.next()?, fields.next()?];
    fields.next().is_none().then_some(four)
}

fn number(field: &[u8]) -> Result<f32, LineFault> {
    let text = core::str::from_utf8(field).map_err(|_| LineFault::Malformed)?;
    text.parse().map_err(|_| LineFault::Malformed)
}

fn id_of(field: &[u8]) -> Result<u32, LineFault> {
    let (negative, digits) = match field {
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
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn parsed(text: &str) -> Result<PoseLine, LineFault> {
        PoseLine::parse(text.as_bytes(), Separator::Comma)
    }

    #[test]
    fn lines_of_the_dissertation_are_read() {
        let pose = PoseLine { id: 7, x: 28.99, y: -15.54, theta: -90.0 };
        for text in ["7,28.99,-15.54,-90", " 7 , 28.99 , -15.54 , -90.00 ", "+7,2.899e1,-15.54,-90."] {
            assert_eq!(parsed(text), Ok(pose), "{text}");
        }
        for text in ["7 28.99 -15.54 -90", "7  28.99\t-15.54 -90.000"] {
            assert_eq!(PoseLine::parse(text.as_bytes(), Separator::Space), Ok(pose), "{text}");
        }
    }

    #[test]
    fn each_fault_has_its_kind() {
        use LineFault::{IdTooLarge, Malformed, NegativeId, NotFinite};
        for (text, fault) in [
            ("", Malformed),
            ("1,2,3", Malformed),
            ("1,2,3,4,5", Malformed),
            ("1,2,3,", Malformed),
            ("1 2 3 4", Malformed),
            ("1.5,2,3,4", Malformed),
            ("-,2,3,4", Malformed),
            ("1,2,x,4", Malformed),
            ("-1,2,x,4", Malformed),
            ("-1,2,3,4", NegativeId),
            ("-99999999999999999999,2,3,4", NegativeId),
            ("4294967296,2,3,4", IdTooLarge),
            ("99999999999999999999,2,3,4", IdTooLarge),
            ("1,nan,3,4", NotFinite),
            ("1,2,inf,4", NotFinite),
            ("1,2,3,1e39", NotFinite),
        ] {
            assert_eq!(parsed(text), Err(fault), "{text}");
        }
        assert_eq!(parsed("-0,1,2,3").map(|line| line.id), Ok(0));
        assert_eq!(PoseLine::parse(b"1,\xff,3,4", Separator::Comma), Err(Malformed));
    }

    #[test]
    fn a_datagram_is_cut_into_its_lines() {
        let all: Vec<_> = lines(b"1,2,3,4\r\n\n  \n5,6,7,8\n9").collect();
        assert_eq!(all, [&b"1,2,3,4"[..], b"5,6,7,8", b"9"]);
        assert_eq!(lines(b"").count(), 0);
    }

    #[test]
    fn angles_are_wrapped() {
        let degrees = |angle| AngleUnit::Degrees.to_radians(angle);
        assert_eq!((degrees(180.0), degrees(-180.0), degrees(540.0)), (PI, PI, PI));
        assert_eq!(degrees(360.0), 0.0);
        assert!((degrees(-450.0) + PI / 2.0).abs() < 1e-6);
        assert_eq!(AngleUnit::Radians.to_radians(-PI), PI);
        assert_eq!(AngleUnit::Degrees.from_radians(PI), 180.0);
    }

    fn format() -> impl Strategy<Value = LineFormat> {
        let separator = prop_oneof![Just(Separator::Comma), Just(Separator::Space)];
        let unit = prop_oneof![Just(AngleUnit::Degrees), Just(AngleUnit::Radians)];
        (separator, 1..=fixed::MAX_DECIMALS, unit).prop_map(|(separator, d, unit)| LineFormat::new(separator, d, unit))
    }

    proptest! {
        #[test]
        fn what_is_written_is_read_back(
            id: u32, x in -1e6_f32..1e6, y in -1e6_f32..1e6, theta in -400.0_f32..400.0, format in format()
        ) {
            let line = PoseLine { id, x, y, theta };
            let mut text = Vec::new();
            line.write(&mut text, format);
            prop_assert_eq!(text.pop(), Some(b'\n'));
            let read = PoseLine::parse(&text, format.separator).expect("a line");
            prop_assert_eq!(read.id, id);
            for (read, written, decimals) in
                [(read.x, x, format.decimals), (read.y, y, format.decimals), (read.theta, theta, format.theta_decimals)]
            {
                let half_a_unit = 0.5 * 10_f64.powi(-(decimals as i32));
                let rounding = f64::from(written.abs()) * f64::from(f32::EPSILON);
                prop_assert!((f64::from(read) - f64::from(written)).abs() <= half_a_unit + rounding);
            }
        }

        #[test]
        fn no_line_is_longer_than_the_longest(id: u32, x: u32, y: u32, theta: u32, format in format()) {
            let [x, y, theta] = [x, y, theta].map(f32::from_bits);
            let mut text = Vec::new();
            PoseLine { id, x, y, theta }.write(&mut text, format);
            prop_assert!(text.len() <= MAX_LINE_BYTES);
        }

        #[test]
        fn no_bytes_make_the_parser_panic(bytes: Vec<u8>) {
            for line in lines(&bytes) {
                for separator in [Separator::Comma, Separator::Space] {
                    if let Ok(line) = PoseLine::parse(line, separator) {
                        prop_assert!(line.x.is_finite() && line.y.is_finite() && line.theta.is_finite());
                    }
                }
            }
        }

        #[test]
        fn almost_lines_are_read_or_refused(text in "[-+0-9a-z.e]{0,12}(,[-+0-9a-z. ]{0,9}){2,4}") {
            if let Ok(line) = parsed(&text) {
                prop_assert!(line.x.is_finite() && line.y.is_finite() && line.theta.is_finite());
            }
        }

        #[test]
        fn any_angle_comes_into_range(angle: f32) {
            prop_assume!(angle.is_finite());
            for unit in [AngleUnit::Degrees, AngleUnit::Radians] {
                let radians = unit.to_radians(angle);
                prop_assert!(-PI < radians && radians <= PI, "{angle} becomes {radians}");
            }
        }
    }
}
