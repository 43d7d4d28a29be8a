//! Readers of the layouts of other systems, and the format of a file by its content.
//!
//! A reader turns the text of a file into a [`Layout`]: everything that it understands, with the
//! file's own ids. It reports what it doesn't understand, once per kind. From there on, layouts
//! take the same way as our own files.

mod csv;
mod detect;
mod dxf;
mod ignored;
pub mod lif;
pub mod moving_ai;
mod nav2;
mod open_rmf;
pub mod open_tcs;
pub mod regatta_yaml;
pub mod ros_map;

use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;

pub(super) use ignored::Ignored;

use super::finding::Report;
use super::layout::Layout;
use super::read::ReadOptions;
use super::route_graph::RouteGraph;

/// The largest number of bytes of a name that many nodes and edges share, or that is part of their
/// ids: of a level, a block, a column. A small file with a longer one could take all memory.
const MAX_NAME: usize = 100;

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
}

impl Format {
    /// Whether files of the format are YAML.
    pub(super) fn is_yaml(self) -> bool {
        matches!(self, Self::Regatta | Self::OpenRmf | Self::OpenRmfBuilding | Self::RosMap)
    }

    /// Returns the format of a text by its content; [`Format::Regatta`] if it looks like no other.
    pub fn detect(text: &str) -> Self {
        detect::detect(text)
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

/// The text of a file, with what a reader needs to find others that it names.
#[derive(Clone, Copy, Debug)]
pub(super) struct Source<'text> {
    pub text: &'text str,
    /// The folder that paths in the file are relative to.
    pub folder: &'text Path,
    /// The name of the file without folder and ending.
    pub stem: &'text str,
}

/// The error of reading a text that isn't of its format at all.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct SyntaxError {
    /// The line, from 1.
    pub line: usize,
    pub message: String,
}

/// A graph as the text of another format.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Written {
    /// The content of the file.
    pub text: String,
    /// What the format can't say of this graph, one line each.
    pub losses: Vec<String>,
}

/// Reads a layout of another format. [`Format::Regatta`] has none of these readers.
///
/// # Errors
/// If the text isn't of that format. Errors in its content are reported to `report` instead.
pub(super) fn read<'text>(
    format: Format,
    source: Source<'text>,
    options: &ReadOptions,
    report: &mut Report<'text>,
) -> Result<Layout, SyntaxError> {
    match format {
        Format::Lif => lif::read(source, options, report),
        Format::OpenRmf => open_rmf::read(source, options, report),
        Format::OpenRmfBuilding => open_rmf::building::read(source, options, report),
        Format::Nav2 => nav2::read(source, options, report),
        Format::OpenTcs => open_tcs::read(source, options, report),
        Format::MovingAi => moving_ai::read(source, options, report),
        Format::Dxf => dxf::read(source, options, report),
        Format::Csv => csv::read(source, options, report),
        Format::RosMap => ros_map::read(source, options, report),
        Format::Regatta => Err(SyntaxError {
            line: 1,
            message: "our own format has a reader of its own".to_owned(),
        }),
    }
}

/// Writes a graph in a format; `None` if there is no writer for it.
pub fn write(graph: &RouteGraph, format: Format) -> Option<Written> {
    match format {
        Format::Regatta => Some(regatta_yaml::write(graph)),
        Format::Lif => Some(lif::write(graph)),
        Format::Nav2 => Some(nav2::write(graph)),
        Format::OpenTcs => Some(open_tcs::write(graph)),
        Format::OpenRmf
        | Format::OpenRmfBuilding
        | Format::MovingAi
        | Format::Dxf
        | Format::Csv
        | Format::RosMap => None,
    }
}

/// Returns the other files that a layout needs beside it: the picture of a ROS map, the second of
/// two tables.
pub fn companions(path: &Path) -> Vec<PathBuf> {
    csv::sibling(path).into_iter().chain(ros_map::picture(path)).collect()
}
