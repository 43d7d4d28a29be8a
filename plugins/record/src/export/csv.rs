//! CSV tables: one file, or one file per robot.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs::File;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

use super::rows::{Column, Value};
use super::{ExportError, failed};
use crate::output::Draft;

/// The amount of text buffered in memory before it is written, so that each of many files is opened
/// only a few times.
const BUFFER_BYTES: usize = 64 << 20;

/// The writer of a CSV file.
pub(super) struct Table {
    path: PathBuf,
    draft: Draft,
    file: File,
    text: String,
}

impl Table {
    pub fn create(path: &Path, force: bool, columns: &[Column]) -> Result<Self, ExportError> {
        let (draft, file) = Draft::create(path, force).map_err(|error| failed(path, error))?;
        Ok(Self { path: path.to_owned(), draft, file, text: header(columns) })
    }

    pub fn add(&mut self, row: &[Value]) -> Result<(), ExportError> {
        write_line(row, &mut self.text);
        if self.text.len() > BUFFER_BYTES / 16 { self.write() } else { Ok(()) }
    }

    fn write(&mut self) -> Result<(), ExportError> {
        self.file.write_all(self.text.as_bytes()).map_err(|error| failed(&self.path, error))?;
        self.text.clear();
        Ok(())
    }

    /// Writes the buffered rest and returns the file's name.
    pub fn finish(mut self) -> Result<String, ExportError> {
        self.write()?;
        self.draft.commit().map_err(|error| failed(&self.path, error))?;
        Ok(self.path.display().to_string())
    }
}

/// The writer of a CSV file per robot.
pub(super) struct Tables {
    folder: PathBuf,
    force: bool,
    header: String,
    /// The tables by robot.
    tables: BTreeMap<usize, RobotTable>,
    buffered: usize,
}

/// The text of one file that isn't written yet.
#[derive(Default)]
struct RobotTable {
    text: String,
    draft: Option<Draft>,
}

impl Tables {
    pub fn create(folder: &Path, force: bool, columns: &[Column]) -> Self {
        let (folder, header) = (folder.to_owned(), header(columns));
        Self { folder, force, header, tables: BTreeMap::new(), buffered: 0 }
    }

    pub fn add(&mut self, robot: usize, row: &[Value]) -> Result<(), ExportError> {
        let table = self.tables.entry(robot).or_default();
        let before = table.text.len();
        write_line(row, &mut table.text);
        self.buffered += table.text.len() - before;
        if self.buffered > BUFFER_BYTES { self.write() } else { Ok(()) }
    }

    fn write(&mut self) -> Result<(), ExportError> {
        self.buffered = 0;
        for (robot, table) in &mut self.tables {
            let path = self.folder.join(format!("robot-{robot}.csv"));
            table.write(&path, self.force, &self.header).map_err(|error| failed(&path, error))?;
        }
        Ok(())
    }

    /// Writes the buffered rest and returns a description of the files.
    pub fn finish(mut self) -> Result<String, ExportError> {
        self.write()?;
        let files = self.tables.len();
        for draft in self.tables.into_values().filter_map(|table| table.draft) {
            draft.commit().map_err(|error| failed(&self.folder, error))?;
        }
        let noun = if files == 1 { "file" } else { "files" };
        Ok(format!("{files} {noun} in {}", self.folder.display()))
    }
}

impl RobotTable {
    fn write(&mut self, path: &Path, force: bool, header: &str) -> io::Result<()> {
        let mut file = match &self.draft {
            Some(draft) => draft.append()?,
            None => {
                let (draft, mut file) = Draft::create(path, force)?;
                self.draft = Some(draft);
                file.write_all(header.as_bytes())?;
                file
            }
        };
        file.write_all(self.text.as_bytes())?;
        self.text.clear();
        Ok(())
    }
}

fn header(columns: &[Column]) -> String {
    let titles: Vec<_> = columns.iter().map(|column| column.title.as_str()).collect();
    titles.join(",") + "\n"
}

/// Appends a row's line. Numbers have enough digits to be read back bit for bit.
fn write_line(row: &[Value], out: &mut String) {
    for (i, value) in row.iter().enumerate() {
        if i > 0 {
            out.push(',');
        }
        let written = match value {
            Value::Missing => Ok(()),
            Value::U32(value) => write!(out, "{value}"),
            Value::U64(value) => write!(out, "{value}"),
            Value::F32(value) => write!(out, "{value}"),
            Value::F64(value) => write!(out, "{value}"),
            Value::Text(value) => out.write_str(value),
        };
        written.expect("writing to a String never fails");
    }
    out.push('\n');
}
