//! Exports recordings to CSV and Parquet tables.

mod csv;
mod options;
mod parquet;
mod rows;
mod value;

use std::io;
use std::path::{Path, PathBuf};

use regatta_plugin::ColumnName;

use crate::output::Folder;
use crate::progress::{Interrupted, Progress};
use crate::reading::{ReadingError, Recording};
pub use options::ExportArgs;
use options::{Format, Place, Table, Target};
use value::{Column, Value};

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
    #[error("the export was interrupted; what it had written is removed")]
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
    let mut written = Vec::new();
    let mut finished = Vec::new();
    // The files appear once all tables are complete.
    for (done, table) in args.tables().iter().enumerate() {
        let columns = rows::columns(&recording, *table, args.columns.as_deref())?;
        let mut sheets = Sheets::create(&targets, *table, args.force, &columns)?;
        let part = |time: f64| (done as f64 + time) / args.tables().len() as f64;
        let rows = rows::for_each(&recording, *table, args, &mut |time, robot, row| {
            progress.report(part(time))?;
            sheets.add(robot, row)
        })?;
        finished.push((rows, sheets));
    }
    for (rows, sheets) in finished {
        written.push(format!("{rows} rows in {}", sheets.finish()?));
    }
    Ok(written.join("; "))
}

/// Creates the folders of the targets.
fn folders(targets: &[Target]) -> Result<Vec<Folder>, ExportError> {
    let folder = |target: &Target| match &target.place {
        Place::Folder(folder) => Some(folder.clone()),
        Place::File(_) => None,
    };
    let create =
        |path: PathBuf| Folder::create(&path).map_err(|reason| ExportError::Write { path, reason });
    targets.iter().filter_map(folder).map(create).collect()
}

/// The files of one table.
struct Sheets {
    sheets: Vec<Sheet>,
}

/// One file, or one per robot.
enum Sheet {
    Csv(csv::Table),
    CsvPerRobot(csv::Tables),
    Parquet(parquet::Table),
}

impl Sheets {
    fn create(
        targets: &[Target],
        table: Table,
        force: bool,
        columns: &[Column],
    ) -> Result<Self, ExportError> {
        let sheet = |target: &Target| match &target.place {
            Place::Folder(folder) if target.is_per_robot(table) => {
                Ok(Sheet::CsvPerRobot(csv::Tables::create(folder, force, columns)))
            }
            Place::Folder(folder) => {
                let file = format!("{}.{}", table.file_stem(), target.format.extension());
                Sheet::create(&folder.join(file), target.format, table, force, columns)
            }
            Place::File(path) => Sheet::create(path, target.format, table, force, columns),
        };
        Ok(Self { sheets: targets.iter().map(sheet).collect::<Result<_, _>>()? })
    }

    fn add(&mut self, robot: usize, row: &[Value]) -> Result<(), ExportError> {
        self.sheets.iter_mut().try_for_each(|sheet| match sheet {
            Sheet::Csv(table) => table.add(row),
            Sheet::CsvPerRobot(tables) => tables.add(robot, row),
            Sheet::Parquet(table) => table.add(row),
        })
    }

    /// Completes the files, and returns their description.
    fn finish(self) -> Result<String, ExportError> {
        let finish = |sheet: Sheet| match sheet {
            Sheet::Csv(table) => table.finish(),
            Sheet::CsvPerRobot(tables) => tables.finish(),
            Sheet::Parquet(table) => table.finish(),
        };
        let written: Vec<_> = self.sheets.into_iter().map(finish).collect::<Result<_, _>>()?;
        Ok(written.join(" and in "))
    }
}

impl Sheet {
    fn create(
        path: &Path,
        format: Format,
        table: Table,
        force: bool,
        columns: &[Column],
    ) -> Result<Self, ExportError> {
        match format {
            Format::Csv => csv::Table::create(path, force, columns).map(Self::Csv),
            Format::Parquet => {
                parquet::Table::create(path, force, table.file_stem(), columns).map(Self::Parquet)
            }
        }
    }
}

#[cfg(test)]
mod tests;
