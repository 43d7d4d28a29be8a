//! Recordings as tables for other programs: CSV and Parquet.

mod csv;
mod parquet;

use std::io;
use std::path::PathBuf;

use clap::{ArgGroup, Args};
use regatta_plugin::ColumnName;
use regatta_plugin::frame::RobotState;

use crate::reading::{ReadingError, Recording};
use crate::recorded::Row;
use crate::robots::Robots;
use crate::table::{Snapshot, walk};

/// What to export, and where to.
#[derive(Args, Clone, Debug)]
#[group(skip)]
#[command(group(ArgGroup::new("target").required(true).multiple(true).args(["csv", "parquet"])))]
pub struct ExportArgs {
    /// The recording
    file: PathBuf,
    /// Write CSV files into this folder, one a robot: robot-7.csv
    #[arg(long, value_name = "FOLDER")]
    csv: Option<PathBuf>,
    /// Write one long CSV file, robots.csv, instead
    #[arg(long, requires = "csv")]
    long: bool,
    /// Write one Parquet file
    #[arg(long, value_name = "FILE")]
    parquet: Option<PathBuf>,
    /// Only these robots: 1,5,7..9 are 1, 5, 7, 8 and 9
    #[arg(long, value_name = "IDS")]
    robots: Option<Robots>,
    /// Only these of the plugins' columns [default: all that were recorded]
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    columns: Option<Vec<ColumnName>>,
}

/// Why a recording can't be exported.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// The recording can't be read.
    #[error(transparent)]
    Reading(#[from] ReadingError),
    /// A table can't be written.
    #[error("can't write {path} ({reason})")]
    Write {
        /// The file.
        path: PathBuf,
        /// Why.
        reason: io::Error,
    },
    /// A column that wasn't recorded was asked for.
    #[error("the recording has no column '{column}'; it has: {known}")]
    NoColumn {
        /// The column.
        column: ColumnName,
        /// Those that were recorded.
        known: String,
    },
    /// None of the robots that were asked for was recorded.
    #[error("no frame of the recording has any of these robots; their ids go from 0 to {last}")]
    NoRobots {
        /// The highest id.
        last: usize,
    },
}

/// What all tables begin with. Names carry their units.
const HEAD: [&str; 12] = [
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

/// A robot at a time, as all tables have it.
struct Record<'snapshot> {
    snapshot: &'snapshot Snapshot<'snapshot>,
    robot: usize,
    row: Row,
    /// Id of the edge in the route graph.
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

/// Exports a recording. Returns a line that says what was written.
///
/// # Errors
/// [`ExportError`].
pub fn export(args: &ExportArgs) -> Result<String, ExportError> {
    let recording = Recording::open(&args.file)?;
    let columns = columns(&recording, args.columns.as_deref())?;
    let robots = args.robots.clone().unwrap_or_else(Robots::all);
    let (titles, plugins) = (titles(&columns), columns.len());
    let csv = args.csv.as_deref().map(|folder| csv::Tables::create(folder, args.long, &titles, plugins));
    let parquet = args.parquet.as_deref().map(|file| parquet::Table::create(file, &titles, plugins));
    let (mut csv, mut parquet) = (csv.transpose()?, parquet.transpose()?);
    let (mut rows, mut most_robots) = (0_u64, 0);
    walk(&recording, &columns, |snapshot| -> Result<(), ExportError> {
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

/// Titles of all columns. A plugin's column has its name, or with `column_` before it if a table has that one already.
fn titles(columns: &[ColumnName]) -> Vec<String> {
    let title = |name: &ColumnName| match HEAD.contains(&name.as_str()) {
        true => format!("column_{name}"),
        false => name.to_string(),
    };
    HEAD.iter().map(|name| (*name).to_owned()).chain(columns.iter().map(title)).collect()
}

/// The columns to export: those that are wanted, or all.
fn columns(recording: &Recording, wanted: Option<&[ColumnName]>) -> Result<Vec<ColumnName>, ExportError> {
    let recorded: Vec<_> = recording.topics().into_iter().filter_map(|topic| topic.column().cloned()).collect();
    let Some(wanted) = wanted else { return Ok(recorded) };
    match wanted.iter().find(|column| !recorded.contains(column)) {
        None => Ok(wanted.to_vec()),
        Some(column) => {
            let known: Vec<_> = recorded.iter().map(ColumnName::as_str).collect();
            Err(ExportError::NoColumn { column: column.clone(), known: known.join(", ") })
        }
    }
}
