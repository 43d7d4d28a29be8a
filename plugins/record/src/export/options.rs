//! The options of an export.

use std::path::{Path, PathBuf};

use clap::{ArgGroup, Args, ValueEnum};
use regatta_plugin::ColumnName;

use super::ExportError;
use crate::arguments::{RobotIds, path_parser};

/// Options of `regatta export`.
#[derive(Args, Clone, Debug)]
#[group(skip)]
#[command(group = ArgGroup::new("target").required(true).multiple(true)
    .args(["output", "csv", "parquet"]))]
pub struct ExportArgs {
    /// Recording
    pub(super) file: PathBuf,
    /// File to write, if its name ends in .csv or .parquet; otherwise, folder for the files
    #[arg(short, long, value_name = "PATH", value_parser = path_parser())]
    output: Option<PathBuf>,
    /// Format of files in a folder
    #[arg(long, value_enum, value_name = "FORMAT", default_value_t = Format::Csv)]
    format: Format,
    /// Tables to write
    #[arg(long, value_enum, value_name = "NAMES", value_delimiter = ',', default_value = "frames")]
    topics: Vec<Table>,
    /// Write one CSV file of all robots' frames, robots.csv, instead of one per robot
    #[arg(long)]
    long: bool,
    /// Same as --output FOLDER --format csv
    #[arg(long, value_name = "FOLDER")]
    csv: Option<PathBuf>,
    /// Write one Parquet file, whatever its name
    #[arg(long, value_name = "FILE")]
    parquet: Option<PathBuf>,
    /// Replace files that exist
    #[arg(long)]
    pub(super) force: bool,
    /// Export only these robots: 1,5,7..9 means 1, 5, 7, 8 and 9
    #[arg(long, value_name = "IDS")]
    pub(super) robots: Option<RobotIds>,
    /// Export only these columns of plugins [default: all recorded columns]
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub(super) columns: Option<Vec<ColumnName>>,
    /// Start at this time of the recording, for example 12.5s or 3min
    #[arg(long, value_name = "TIME")]
    pub(super) from: Option<humantime::Duration>,
    /// End at this time of the recording
    #[arg(long, value_name = "TIME")]
    pub(super) to: Option<humantime::Duration>,
}

/// A table of an export.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, ValueEnum)]
#[value(rename_all = "snake_case")]
pub(super) enum Table {
    /// Each robot in each frame.
    Frames,
    /// Events of robots.
    Events,
    /// Commands that took effect or were refused.
    Commands,
    /// The log of transport orders.
    Orders,
    /// Pairs of robots that touch or may touch, at each tick.
    Contacts,
    /// Contacts that began or ended.
    ContactEvents,
}

/// The format of a table's file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum Format {
    Csv,
    Parquet,
}

/// The destination of tables, and their format.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Target {
    pub place: Place,
    pub format: Format,
    /// Whether the frames of all robots are one table.
    long: bool,
}

/// A file for one table, or a folder for several.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Place {
    File(PathBuf),
    Folder(PathBuf),
}

impl Table {
    /// Returns the name of the table's file, without its extension.
    pub fn file_stem(self) -> &'static str {
        match self {
            Self::Frames => "robots",
            Self::Events => "events",
            Self::Commands => "commands",
            Self::Orders => "orders",
            Self::Contacts => "contacts",
            Self::ContactEvents => "contact_events",
        }
    }
}

impl Format {
    /// Returns the format of a file, by the extension of its name.
    fn of(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?;
        [Self::Csv, Self::Parquet].into_iter().find(|format| format.extension() == extension)
    }

    pub fn extension(self) -> &'static str {
        match self {
            Self::Csv => "csv",
            Self::Parquet => "parquet",
        }
    }
}

impl Target {
    /// Whether a table has a file per robot.
    pub fn is_per_robot(&self, table: Table) -> bool {
        table == Table::Frames && self.format == Format::Csv && !self.long
    }
}

impl ExportArgs {
    /// Returns the tables, each once.
    pub(super) fn tables(&self) -> Vec<Table> {
        let mut tables = self.topics.clone();
        tables.sort_unstable();
        tables.dedup();
        tables
    }

    /// Returns the files and folders to write, with their formats.
    pub(super) fn targets(&self) -> Result<Vec<Target>, ExportError> {
        let mut targets = Vec::new();
        if let Some(path) = self.output.clone() {
            let format = Format::of(&path).filter(|_| !path.is_dir());
            targets.push(match format {
                Some(format) => self.target(Place::File(path), format),
                None => self.target(Place::Folder(path), self.format),
            });
        }
        if let Some(folder) = self.csv.clone() {
            targets.push(self.target(Place::Folder(folder), Format::Csv));
        }
        if let Some(file) = self.parquet.clone() {
            targets.push(self.target(Place::File(file), Format::Parquet));
        }
        for target in &targets {
            if let Place::File(path) = &target.place
                && self.tables().len() > 1
            {
                return Err(ExportError::OneTable { path: path.clone() });
            }
        }
        Ok(targets)
    }

    fn target(&self, place: Place, format: Format) -> Target {
        Target { place, format, long: self.long }
    }
}
