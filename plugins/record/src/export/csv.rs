//! CSV: one file a robot, or one long table.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs::{self, OpenOptions};
use std::io::Write as _;
use std::path::{Path, PathBuf};

use super::{ExportError, Record};
use crate::output;

/// Text that is kept in memory before it goes to the files, so that each is opened a few times only.
const BUFFER_BYTES: usize = 64 << 20;
/// The one table of a long export.
const LONG: &str = "robots.csv";

/// The tables under construction.
pub(super) struct Tables {
    folder: PathBuf,
    long: bool,
    head: String,
    columns: usize,
    /// By robot; all under 0 in one long table.
    tables: BTreeMap<usize, Table>,
    buffered: usize,
}

/// One file's text that isn't written yet.
#[derive(Default)]
struct Table {
    text: String,
    is_created: bool,
}

impl Tables {
    /// `titles` of all columns, the last ones of which are the plugins'.
    pub fn create(folder: &Path, long: bool, titles: &[String], plugins: usize) -> Result<Self, ExportError> {
        fs::create_dir_all(folder).map_err(|reason| ExportError::Write { path: folder.to_owned(), reason })?;
        Ok(Self {
            folder: folder.to_owned(),
            long,
            head: titles.join(",") + "\n",
            columns: plugins,
            tables: BTreeMap::new(),
            buffered: 0,
        })
    }

    pub fn add(&mut self, record: &Record<'_>) -> Result<(), ExportError> {
        let table = self.tables.entry(if self.long { 0 } else { record.robot }).or_default();
        let before = table.text.len();
        line(record, self.columns, &mut table.text).expect("a String takes all");
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
            table.write(&path, &self.head).map_err(|reason| ExportError::Write { path, reason })?;
        }
        Ok(())
    }

    /// Writes what is left, and says what there is.
    pub fn finish(mut self) -> Result<String, ExportError> {
        self.write()?;
        let folder = self.folder.display();
        Ok(if self.long { format!("{folder}/{LONG}") } else { format!("{} files in {folder}", self.tables.len()) })
    }
}

impl Table {
    fn write(&mut self, path: &Path, head: &str) -> std::io::Result<()> {
        let mut file = match self.is_created {
            true => OpenOptions::new().append(true).open(path)?,
            false => {
                let mut file = output::create(path)?;
                file.write_all(head.as_bytes())?;
                file
            }
        };
        file.write_all(self.text.as_bytes())?;
        self.text.clear();
        self.is_created = true;
        Ok(())
    }
}

/// Numbers are written so that they read back as they were, to the last bit.
fn line(record: &Record<'_>, columns: usize, out: &mut String) -> std::fmt::Result {
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
