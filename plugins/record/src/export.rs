//! Exports recordings to CSV and Parquet tables.

mod csv;
mod parquet;

use std::io;
use std::path::PathBuf;

use clap::{ArgGroup, Args};
use regatta_plugin::ColumnName;
use regatta_plugin::frame::RobotState;

use crate::reading::{ReadingError, Recording};
use crate::recorded::Row;
use crate::robot_ids::RobotIds;
use crate::table::{Snapshot, for_each_snapshot};

/// Options of `regatta export`.
#[derive(Args, Clone, Debug)]
#[group(skip)]
#[command(group(ArgGroup::new("target").required(true).multiple(true).args(["csv", "parquet"])))]
pub struct ExportArgs {
    /// The recording
    file: PathBuf,
    /// Write CSV files to this folder, one per robot: robot-7.csv
    #[arg(long, value_name = "FOLDER")]
    csv: Option<PathBuf>,
    /// Write one CSV file of all robots, robots.csv, instead of one per robot
    #[arg(long, requires = "csv")]
    long: bool,
    /// Write one Parquet file
    #[arg(long, value_name = "FILE")]
    parquet: Option<PathBuf>,
    /// Export only these robots: 1,5,7..9 selects 1, 5, 7, 8 and 9
    #[arg(long, value_name = "IDS")]
    robots: Option<RobotIds>,
    /// Export only these columns of plugins [default: all recorded columns]
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    columns: Option<Vec<ColumnName>>,
}

/// The error of exporting a recording.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// The recording can't be read.
    #[error(transparent)]
    Reading(#[from] ReadingError),
    /// A table can't be written.
    #[error("can't write {path} ({reason})")]
    Write {
        /// The file or folder.
        path: PathBuf,
        /// The system's reason.
        reason: io::Error,
    },
    /// A requested column wasn't recorded.
    #[error("the recording has no column '{column}'; its columns are: {recorded}")]
    NoColumn {
        /// The requested column.
        column: ColumnName,
        /// The recorded columns, separated by commas.
        recorded: String,
    },
    /// None of the requested robots was recorded.
    #[error("no frame of the recording has any of these robots; its robots have ids from 0 to {last}")]
    NoRobots {
        /// The highest recorded id.
        last: usize,
    },
}

/// Titles of the columns that every table starts with. They name their units.
const COMMON_TITLES: [&str; 12] = [
    "time_s",
    "run",
    "tick",
    "sim_time_s",
    "robot",
    "x_m",
    "y_m",
    "theta_rad",
    "speed_m_per_s",
    "s_m",
    "edge",
    "state",
];

/// One record of a table: a robot in one frame.
struct Record<'snapshot> {
    snapshot: &'snapshot Snapshot<'snapshot>,
    robot: usize,
    row: Row,
    /// The edge's id in the route graph.
    edge: Option<u32>,
}

impl Record<'_> {
    fn sim_time(&self) -> f64 {
        self.snapshot.header().sim_time_nanos as f64 * 1e-9
    }

    fn state(&self) -> &'static str {
        match RobotState::from_number(self.row.state) {
            RobotState::Idle => "idle",
            RobotState::Driving => "driving",
            RobotState::Waiting => "waiting",
            RobotState::Held => "held",
            RobotState::Faulted => "faulted",
            RobotState::Absent => "absent",
        }
    }
}

/// Exports a recording. Returns one line that describes the written files.
///
/// # Errors
/// Returns an [`ExportError`] if the recording can't be read, a table can't be written, or the requested columns or
/// robots weren't recorded.
pub fn export(args: &ExportArgs) -> Result<String, ExportError> {
    let recording = Recording::open(&args.file)?;
    let columns = columns(&recording, args.columns.as_deref())?;
    let robots = args.robots.clone().unwrap_or_else(RobotIds::all);
    let (titles, plugins) = (titles(&columns), columns.len());
    let csv = args.csv.as_deref().map(|folder| csv::Tables::create(folder, args.long, &titles, plugins));
    let parquet = args.parquet.as_deref().map(|file| parquet::Table::create(file, &titles, plugins));
    let (mut csv, mut parquet) = (csv.transpose()?, parquet.transpose()?);
    let (mut rows, mut most_robots) = (0_u64, 0);
    for_each_snapshot(&recording, &columns, |snapshot| -> Result<(), ExportError> {
        most_robots = most_robots.max(snapshot.len());
        for robot in robots.below(snapshot.len()) {
            let Some(row) = snapshot.row(robot) else { continue };
            let record = Record { snapshot, robot, row, edge: snapshot.edge(&row).map(|edge| edge.id) };
            csv.as_mut().map_or(Ok(()), |csv| csv.add(&record))?;
            parquet.as_mut().map_or(Ok(()), |parquet| parquet.add(&record))?;
            rows += 1;
        }
        Ok(())
    })?;
    if rows == 0 && robots.first().is_some_and(|first| first as usize >= most_robots) {
        return Err(ExportError::NoRobots { last: most_robots.saturating_sub(1) });
    }
    let mut written = Vec::new();
    written.extend(csv.map(csv::Tables::finish).transpose()?);
    written.extend(parquet.map(parquet::Table::finish).transpose()?);
    Ok(format!("{rows} rows in {}", written.join(" and in ")))
}

/// Returns the titles of all columns. A plugin's column keeps its name, or gets the prefix `column_` if the name is one
/// of [`COMMON_TITLES`].
fn titles(columns: &[ColumnName]) -> Vec<String> {
    let title = |name: &ColumnName| match COMMON_TITLES.contains(&name.as_str()) {
        true => format!("column_{name}"),
        false => name.to_string(),
    };
    COMMON_TITLES.iter().map(|name| (*name).to_owned()).chain(columns.iter().map(title)).collect()
}

/// Returns the columns to export: the requested ones, or all recorded ones.
fn columns(recording: &Recording, requested: Option<&[ColumnName]>) -> Result<Vec<ColumnName>, ExportError> {
    let recorded: Vec<_> = recording.topics().into_iter().filter_map(|topic| topic.column().cloned()).collect();
    let Some(requested) = requested else { return Ok(recorded) };
    match requested.iter().find(|column| !recorded.contains(column)) {
        None => Ok(requested.to_vec()),
        Some(column) => {
            let recorded: Vec<_> = recorded.iter().map(ColumnName::as_str).collect();
            Err(ExportError::NoColumn { column: column.clone(), recorded: recorded.join(", ") })
        }
    }
}

#[cfg(test)]
mod tests;
