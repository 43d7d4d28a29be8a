//! Exports recordings to CSV and Parquet tables.

mod csv;
mod options;
mod parquet;
mod rows;

use std::io;
use std::path::{Path, PathBuf};

use regatta_plugin::ColumnName;

use crate::output::Folder;
use crate::progress::{Interrupted, Progress};
use crate::reading::{ReadingError, Recording};
pub use options::ExportArgs;
use options::{Format, Place, Table, Target};
use rows::{Column, Value};

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
    /// Several tables can't be written to one file.
    #[error("{path} can have only one table; give a folder for several")]
    OneTable {
        /// The file.
        path: PathBuf,
    },
    /// A requested table wasn't recorded.
    #[error("the recording has no {table}; its topics are: {recorded}")]
    NoTopic {
        /// The requested table.
        table: &'static str,
        /// The recorded topics, separated by commas.
        recorded: String,
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
    #[error(
        "no frame of the recording has any of these robots; its robots have ids from 0 to {last}"
    )]
    NoRobots {
        /// The highest recorded id.
        last: usize,
    },
    /// The process was asked to end.
    #[error("the export was interrupted; its incomplete files are removed")]
    Interrupted,
}

impl From<Interrupted> for ExportError {
    fn from(_: Interrupted) -> Self {
        Self::Interrupted
    }
}

/// Exports a recording. Returns one line that describes the written files.
///
/// # Errors
/// Returns an [`ExportError`] if the recording can't be read, a table can't be written, or the
/// requested columns or robots weren't recorded. Nothing is left of the files then.
pub fn export(args: &ExportArgs) -> Result<String, ExportError> {
    let recording = Recording::open(&args.file)?;
    let targets = args.targets()?;
    let _folders = folders(&targets)?;
    let mut progress = Progress::start("export");
    let tables = args.tables();
    let mut finished = Vec::new();
    for (done, table) in tables.iter().enumerate() {
        let columns = rows::columns(&recording, *table, args.columns.as_deref())?;
        let mut sheets = Vec::new();
        for target in &targets {
            sheets.push(Sheet::create(target, *table, args.force, &columns)?);
        }
        let rows = rows::for_each(&recording, *table, args, &mut |time, robot, row| {
            progress.report((done as f64 + time) / tables.len() as f64)?;
            sheets.iter_mut().try_for_each(|sheet| sheet.add(robot, row))
        })?;
        finished.push((rows, sheets));
    }
    // The files appear once all tables are complete.
    let mut written = Vec::new();
    for (rows, sheets) in finished {
        let files: Vec<_> = sheets.into_iter().map(Sheet::finish).collect::<Result<_, _>>()?;
        written.push(format!("{rows} rows in {}", files.join(" and in ")));
    }
    Ok(written.join("; "))
}

/// Creates the folders of the targets.
fn folders(targets: &[Target]) -> Result<Vec<Folder>, ExportError> {
    let mut folders = Vec::new();
    for target in targets {
        if let Place::Folder(path) = &target.place {
            folders.push(Folder::create(path).map_err(|reason| failed(path, reason))?);
        }
    }
    Ok(folders)
}

/// Returns the error of writing a file or folder.
fn failed(path: &Path, reason: io::Error) -> ExportError {
    ExportError::Write { path: path.to_owned(), reason }
}

/// The file of a table, or one per robot.
enum Sheet {
    Csv(csv::Table),
    CsvPerRobot(csv::Tables),
    Parquet(parquet::Table),
}

impl Sheet {
    fn create(
        target: &Target,
        table: Table,
        force: bool,
        columns: &[Column],
    ) -> Result<Self, ExportError> {
        let (name, format) = (table.file_stem(), target.format);
        let path = match &target.place {
            Place::Folder(folder) if target.is_per_robot(table) => {
                return Ok(Self::CsvPerRobot(csv::Tables::create(folder, force, columns)));
            }
            Place::Folder(folder) => folder.join(format!("{name}.{}", format.extension())),
            Place::File(path) => path.clone(),
        };
        match format {
            Format::Csv => csv::Table::create(&path, force, columns).map(Self::Csv),
            Format::Parquet => {
                parquet::Table::create(&path, force, name, columns).map(Self::Parquet)
            }
        }
    }

    /// Adds a row, which belongs to a robot.
    fn add(&mut self, robot: usize, row: &[Value]) -> Result<(), ExportError> {
        match self {
            Self::Csv(table) => table.add(row),
            Self::CsvPerRobot(tables) => tables.add(robot, row),
            Self::Parquet(table) => table.add(row),
        }
    }

    /// Completes the files, and returns their description.
    fn finish(self) -> Result<String, ExportError> {
        match self {
            Self::Csv(table) => table.finish(),
            Self::CsvPerRobot(tables) => tables.finish(),
            Self::Parquet(table) => table.finish(),
        }
    }
}

#[cfg(test)]
mod tests;
