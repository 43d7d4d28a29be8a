//! The formats of layouts.

use std::fmt;
use std::str::FromStr;

/// A format of route graphs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Format {
    /// Our own YAML, that of the institute.
    Regatta,
    /// VDMA Layout Interchange Format 1.0: JSON.
    Lif,
    /// A navigation graph of Open-RMF: YAML.
    OpenRmf,
    /// A building map of Open-RMF's traffic editor: YAML.
    OpenRmfBuilding,
    /// A graph of Nav2's Route Server: GeoJSON.
    Nav2,
    /// A plant model of openTCS: XML.
    OpenTcs,
    /// A grid map of the MovingAI benchmarks.
    MovingAi,
    /// A drawing: DXF in ASCII.
    Dxf,
    /// Tables of nodes and edges.
    Csv,
    /// A map of the ROS map server: YAML and a picture.
    RosMap,
}

impl Format {
    /// All formats.
    pub const ALL: [Self; 10] = [
        Self::Regatta,
        Self::Lif,
        Self::OpenRmf,
        Self::OpenRmfBuilding,
        Self::Nav2,
        Self::OpenTcs,
        Self::MovingAi,
        Self::Dxf,
        Self::Csv,
        Self::RosMap,
    ];

    /// Returns the name used on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Regatta => "regatta",
            Self::Lif => "lif",
            Self::OpenRmf => "open-rmf",
            Self::OpenRmfBuilding => "open-rmf-building",
            Self::Nav2 => "nav2",
            Self::OpenTcs => "opentcs",
            Self::MovingAi => "movingai",
            Self::Dxf => "dxf",
            Self::Csv => "csv",
            Self::RosMap => "ros-map",
        }
    }

    /// Whether files of the format are YAML.
    pub(crate) fn is_yaml(self) -> bool {
        matches!(self, Self::Regatta | Self::OpenRmf | Self::OpenRmfBuilding | Self::RosMap)
    }
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// The error of parsing a [`Format`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{}` is not a format: use regatta, lif, open-rmf, open-rmf-building, nav2, opentcs, movingai, dxf, csv or ros-map", .0.escape_debug())]
pub struct ParseFormatError(String);

impl FromStr for Format {
    type Err = ParseFormatError;

    /// Parses a name, ignoring case.
    fn from_str(text: &str) -> Result<Self, ParseFormatError> {
        let is = |format: &Self| format.name().eq_ignore_ascii_case(text.trim());
        Self::ALL.into_iter().find(is).ok_or_else(|| ParseFormatError(text.trim().to_owned()))
    }
}

/// A graph as the text of another format.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Written {
    /// The content of the file.
    pub text: String,
    /// What the format can't say of this graph, one line each.
    pub losses: Vec<String>,
}
