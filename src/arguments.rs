//! Types of arguments that several commands have.

use std::error::Error;
use std::path::PathBuf;
use std::str::FromStr;
use std::time::Duration;

use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use regatta_layout::{Format, Handles, LengthUnit, Millimetres, ReadOptions};

/// A duration: a number of seconds, or a number with a unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Time(pub Duration);

/// The error of parsing a [`Time`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ParseTimeError;

impl Error for ParseTimeError {}

impl std::fmt::Display for ParseTimeError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("give seconds, or a number with a unit: 4, 12.5s, 3min, 1h 30min")
    }
}

impl FromStr for Time {
    type Err = ParseTimeError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let seconds =
            text.trim().parse().ok().and_then(|seconds| Duration::try_from_secs_f64(seconds).ok());
        seconds.or_else(|| humantime::parse_duration(text).ok()).map(Self).ok_or(ParseTimeError)
    }
}

/// Returns the parser of an option with these values, which also names them for completions.
pub fn one_of<T>(names: impl IntoIterator<Item = &'static str>) -> impl TypedValueParser<Value = T>
where
    T: FromStr<Err: Into<Box<dyn Error + Send + Sync>>> + Clone + Send + Sync + 'static,
{
    PossibleValuesParser::new(names).try_map(|name| name.parse::<T>())
}

/// The options of reading a layout.
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = "Layout")]
pub struct LayoutArgs {
    /// Parameter with the length of a spline's handle at its origin, ParamB or ParamF, instead of
    /// the one that the file declares
    #[arg(long)]
    #[arg(value_parser = one_of::<Handles>(Handles::ALL.iter().map(|handles| handles.name())))]
    pub handles: Option<Handles>,
    /// Format of the layout; detected by its content if not given
    #[arg(long, value_parser = one_of::<Format>(Format::ALL.iter().map(|format| format.name())))]
    pub format: Option<Format>,
    /// Level (floor) or layout to read; all if not given
    #[arg(long, value_name = "NAME")]
    pub level: Option<String>,
    /// Vehicle type of a LIF layout whose speeds and headings are used; the first if not given
    #[arg(long, value_name = "NAME")]
    pub vehicle_type: Option<String>,
    /// Layer of a drawing whose lines are edges; other layers are background; may be repeated
    #[arg(long = "layer", value_name = "NAME")]
    pub layers: Vec<String>,
    /// Unit of lengths instead of the file's own
    #[arg(long)]
    #[arg(value_parser = one_of::<LengthUnit>(LengthUnit::ALL.iter().map(|unit| unit.name())))]
    pub units: Option<LengthUnit>,
    /// Side length of a grid map's cells in metres; 1 if not given
    #[arg(long, value_name = "METRES")]
    pub cell_size: Option<Millimetres>,
    /// ROS map (YAML) whose walls are drawn behind the layout
    #[arg(long, value_name = "MAP", value_hint = clap::ValueHint::FilePath)]
    pub background: Option<PathBuf>,
    /// Make a roadmap of a map that has no graph, for robots of this width in metres
    #[arg(long, value_name = "METRES")]
    pub skeleton: Option<Millimetres>,
}

impl LayoutArgs {
    /// Returns the options of the reader.
    pub fn options(&self) -> ReadOptions {
        ReadOptions {
            handles: self.handles,
            format: self.format,
            level: self.level.clone(),
            vehicle_type: self.vehicle_type.clone(),
            layers: self.layers.clone(),
            units: self.units,
            skeleton: self.skeleton,
            cell_size: self.cell_size,
            background: self.background.clone(),
        }
    }

    /// Converts the options to command-line arguments for a child process.
    pub fn to_args(&self) -> Vec<String> {
        let options = [
            self.handles.map(|handles| format!("--handles={}", handles.name())),
            self.format.map(|format| format!("--format={format}")),
            self.level.as_ref().map(|level| format!("--level={level}")),
            self.vehicle_type.as_ref().map(|name| format!("--vehicle-type={name}")),
            self.cell_size.map(|length| format!("--cell-size={length}")),
            self.background.as_ref().map(|map| format!("--background={}", map.display())),
            self.units.map(|unit| format!("--units={}", unit.name())),
            self.skeleton.map(|width| format!("--skeleton={width}")),
        ];
        let layers = self.layers.iter().map(|layer| format!("--layer={layer}"));
        options.into_iter().flatten().chain(layers).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bare_number_is_seconds() {
        for (text, millis) in
            [("4", 4_000), ("12.5", 12_500), ("12.5s", 12_500), ("250ms", 250), ("1min 2s", 62_000)]
        {
            assert_eq!(text.parse(), Ok(Time(Duration::from_millis(millis))), "{text}");
        }
        for text in ["", "-1", "nan", "inf", "4 parsecs", "1e300"] {
            assert_eq!(text.parse::<Time>(), Err(ParseTimeError), "{text}");
        }
    }
}
