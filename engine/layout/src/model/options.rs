//! Settings of the caller for reading a layout.

use std::path::PathBuf;

use super::format::Format;
use super::spline::Handles;

/// Settings of the caller that override those in the file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ReadOptions {
    /// The handle convention; `None` for that of the file, which is [`Handles::BAtOrigin`] if the
    /// file has none.
    pub handles: Option<Handles>,
    /// The format; `None` to tell it by the content.
    pub format: Option<Format>,
    /// The only level (floor) or layout to read, by name; `None` for all.
    pub level: Option<String>,
    /// The vehicle type whose speeds and headings are read, by id; `None` for the first of the
    /// file.
    pub vehicle_type: Option<String>,
    /// The layers of a drawing whose lines are edges; empty for all. The others are background.
    pub layers: Vec<String>,
    /// The unit of a drawing, such as `mm`; `None` for what the drawing says, else metres.
    pub units: Option<LengthUnit>,
    /// The width in metres for which a roadmap is made of a map without a graph; `None` for no
    /// roadmap.
    pub skeleton: Option<Millimetres>,
    /// The length of the side of a grid map's cells; `None` for 1 m.
    pub cell_size: Option<Millimetres>,
    /// A map of the ROS map server whose outlines are drawn behind the layout.
    pub background: Option<PathBuf>,
}

/// A unit of length.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LengthUnit {
    /// Millimetres.
    Millimetre,
    /// Centimetres.
    Centimetre,
    /// Metres.
    Metre,
    /// Inches of 25.4 mm.
    Inch,
    /// Feet of 304.8 mm.
    Foot,
}

impl LengthUnit {
    /// All units.
    pub const ALL: [Self; 5] =
        [Self::Millimetre, Self::Centimetre, Self::Metre, Self::Inch, Self::Foot];

    /// Returns the symbol used on the command line and in scenarios.
    pub fn name(self) -> &'static str {
        match self {
            Self::Millimetre => "mm",
            Self::Centimetre => "cm",
            Self::Metre => "m",
            Self::Inch => "in",
            Self::Foot => "ft",
        }
    }

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

/// The error of parsing a [`LengthUnit`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{}` is not a unit: use mm, cm, m, in or ft", .0.escape_debug())]
pub struct ParseUnitError(String);

impl std::str::FromStr for LengthUnit {
    type Err = ParseUnitError;

    /// Parses a symbol, ignoring case.
    fn from_str(text: &str) -> Result<Self, ParseUnitError> {
        let is = |unit: &Self| unit.name().eq_ignore_ascii_case(text.trim());
        Self::ALL.into_iter().find(is).ok_or_else(|| ParseUnitError(text.trim().to_owned()))
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

impl std::str::FromStr for Millimetres {
    type Err = ParseLengthError;

    /// Parses metres.
    fn from_str(text: &str) -> Result<Self, ParseLengthError> {
        let metres =
            text.trim().parse::<f64>().ok().filter(|metres| (0.001..=1000.0).contains(metres));
        metres
            .map(|metres| Self((metres * 1000.0).round() as u32))
            .ok_or_else(|| ParseLengthError(text.trim().to_owned()))
    }
}

impl std::fmt::Display for Millimetres {
    /// Writes metres.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}", self.metres())
    }
}
