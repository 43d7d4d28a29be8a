//! Settings of the caller for reading a layout.

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

use super::format::Format;
use super::spline::Handles;

/// Settings of the caller that override those in the file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ReadOptions {
    /// The handle convention; `None` for that of the file, which is [`Handles::BAtOrigin`] if the
    /// file has none.
    pub handles: Option<Handles>,
    /// The format; `None` to detect it by the content.
    pub format: Option<Format>,
    /// The only level (floor) or layout to read, by name; `None` for all.
    pub level: Option<String>,
    /// The vehicle type whose speeds and headings are read, by id; `None` for the first of the
    /// file.
    pub vehicle_type: Option<String>,
    /// The layers of a drawing whose lines are edges; empty for all. The others are background.
    pub layers: Vec<String>,
    /// The unit of lengths; `None` for that of the file, which is metres if it has none.
    pub units: Option<LengthUnit>,
    /// The width of robots for which a roadmap is derived from a map without a graph; `None` for no
    /// roadmap.
    pub skeleton: Option<Millimetres>,
    /// The length of the side of a grid map's cells; `None` for 1 m.
    pub cell_size: Option<Millimetres>,
    /// A map of the ROS map server whose outlines are drawn behind the layout.
    pub background: Option<PathBuf>,
}

/// A unit of length.
#[derive(Clone, Copy, Debug, PartialEq, Eq, strum::IntoStaticStr, strum::VariantArray)]
pub enum LengthUnit {
    /// Millimetres.
    #[strum(serialize = "mm")]
    Millimetre,
    /// Centimetres.
    #[strum(serialize = "cm")]
    Centimetre,
    /// Metres.
    #[strum(serialize = "m")]
    Metre,
    /// Inches of 25.4 mm.
    #[strum(serialize = "in")]
    Inch,
    /// Feet of 304.8 mm.
    #[strum(serialize = "ft")]
    Foot,
}

regatta_base::named!(LengthUnit, "a unit");

impl LengthUnit {
    /// Returns the metres of one unit.
    pub fn metres(self) -> f64 {
        match self {
            Self::Millimetre => 0.001,
            Self::Centimetre => 0.01,
            Self::Metre => 1.0,
            Self::Inch => 0.0254,
            Self::Foot => 0.3048,
        }
    }
}

/// A length in whole millimetres.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Millimetres(pub u32);

impl Millimetres {
    /// Returns the length in metres.
    pub fn metres(self) -> f64 {
        f64::from(self.0) / 1000.0
    }
}

/// The error of parsing [`Millimetres`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{}` is not a length: give metres from 0.001 to 1000", .0.escape_debug())]
pub struct ParseLengthError(String);

impl FromStr for Millimetres {
    type Err = ParseLengthError;

    /// Parses metres.
    fn from_str(text: &str) -> Result<Self, ParseLengthError> {
        match text.trim().parse::<f64>() {
            Ok(metres) if (0.001..=1000.0).contains(&metres) => {
                Ok(Self((metres * 1000.0).round() as u32))
            }
            _ => Err(ParseLengthError(text.trim().to_owned())),
        }
    }
}

impl fmt::Display for Millimetres {
    /// Writes metres.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.metres())
    }
}
