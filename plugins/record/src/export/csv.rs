//! CSV export: one file per robot, or one table of all robots.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs::{self, OpenOptions};
use std::io::Write as _;
use std::path::{Path, PathBuf};

use super::{ExportError, Record};
use crate::output;

/// The amount of text buffered in memory before it is written, so that each of the many files is opened only a few times.
const BUFFER_BYTES: usize = 64 << 20;
/// The file name of a table of all robots.
const LONG: &str = "robots.csv";

/// The writer of all CSV files of an export.
pub(super) struct Tables {
    folder: PathBuf,
    long: bool,
    header: String,
    columns: usize,
    /// The tables by robot. A table of all robots has the key 0.
    tables: BTreeMap<usize, Table>,
    buffered: usize,
}

/// The text of one file that isn't written yet.
#[derive(Default)]
struct Table {
    text: String,
    is_created: bool,
}

impl Tables {
    /// Creates the folder. `titles` are those of all columns; the last `plugins` of them belong to plugins' columns.
    pub fn create(folder: &Path, long: bool, titles: &[String], plugins: usize) -> Result<Self, ExportError> {
        fs::create_dir_all(folder).map_err(|reason| ExportError::Write { path: folder.to_owned(), reason })?;
        Ok(Self {
            folder: folder.to_owned(),
            long,
            header: titles.join(",") + "\n",
            columns: plugins,
            tables: BTreeMap::new(),
            buffered: 0,
        })
    }

    pub fn add(&mut self, record: &Record<'_>) -> Result<(), ExportError> {
        let table = self.tables.entry(if self.long { 0 } else { record.robot }).or_default();
        let before = table.text.len();
        write_line(record, self.columns, &mut table.text).expect("writing to a String never fails");
        self.buffered += table.text.len() - before;
        if self.buffered > BUFFER_BYTES { self.write() } else { Ok(()) }
    }

    fn write(&mut self) -> Result<(), ExportError> {
        self.buffered = 0;
        for (robot, table) in &mut self.tables {
            let path = match self.long {
                true => self.folder.join(LONG),
                false => self.folder.join(format!("robot-{robot}.csv")),
            };
            table.write(&path, &self.header).map_err(|reason| ExportError::Write { path, reason })?;
        }
        Ok(())
    }

    /// Writes the buffered rest and returns a description of the files.
    pub fn finish(mut self) -> Result<String, ExportError> {
        self.write()?;
        let folder = self.folder.display();
        Ok(if self.long { format!("{folder}/{LONG}") } else { format!("{} files in {folder}", self.tables.len()) })
    }
}

impl Table {
    fn write(&mut self, path: &Path, header: &str) -> std::io::Result<()> {
        let mut file = match self.is_created {
            true => OpenOptions::new().append(true).open(path)?,
            false => {
                let mut file = output::create(path)?;
                file.write_all(header.as_bytes())?;
                file
            }
        };
        file.write_all(self.text.as_bytes())?;
        self.text.clear();
        self.is_created = true;
        Ok(())
    }
}

/// Appends a record's line. Numbers have enough digits to be read back bit for bit.
fn write_line(record: &Record<'_>, columns: usize, out: &mut String) -> std::fmt::Result {
    let Record { snapshot, robot, row, .. } = record;
    let time = snapshot.time.as_secs_f64();
    write!(out, "{time},{},{},{},{robot},", snapshot.run, snapshot.header().tick, record.sim_time())?;
    write!(out, "{},{},{},{},{},", row.x, row.y, row.theta, row.speed, row.s)?;
    if let Some(edge) = record.edge {
        write!(out, "{edge}")?;
    }
    write!(out, ",{}", record.state())?;
    for column in 0..columns {
        match snapshot.column(column, *robot) {
            Some(value) => write!(out, ",{value}")?,
            None => out.push(','),
        }
    }
    out.push('\n');
    Ok(())
}
