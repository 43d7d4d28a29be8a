//! The CSV file: a row a second.

use std::fs::{File, OpenOptions};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use crate::row::header;

/// More bytes than a row has.
const LONGEST_ROW: u64 = 1 << 16;

/// How the file has fared.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Rows {
    /// Rows that stand in the file.
    pub written: u64,
    /// Rows that could not be written.
    pub lost: u64,
}

/// A CSV file that rows are added to. What stands in it already is kept; a row is written whole or not at all.
#[derive(Debug)]
pub struct Sheet {
    path: PathBuf,
    file: Option<Open>,
    rows: Rows,
    failing: bool,
}

/// The file, and its length up to the last whole row.
#[derive(Debug)]
struct Open {
    file: File,
    length: u64,
}

/// Why a row can't be written.
#[derive(Debug, thiserror::Error)]
pub enum SheetError {
    /// The file can't be opened, read or written.
    #[error("can't write {path} ({reason}); rows are lost until it can be written")]
    Io {
        /// The file.
        path: PathBuf,
        /// Why.
        reason: io::Error,
    },
    /// The file is something else.
    #[error("{path} has other columns; move it away, or name another file with --csv: rows are lost until then")]
    OtherColumns {
        /// The file.
        path: PathBuf,
    },
}

/// What is worth telling a person.
#[derive(Debug)]
pub enum Change {
    /// Rows are lost from now on.
    Failed(SheetError),
    /// The file can be written again, after so many lost rows.
    Recovered(u64),
}

impl Sheet {
    /// A sheet on a file that need not exist yet. It is opened with the first row, and again after it has failed.
    pub fn new(path: &Path) -> Self {
        Self { path: path.to_owned(), file: None, rows: Rows::default(), failing: false }
    }

    /// How it has fared.
    pub fn rows(&self) -> Rows {
        self.rows
    }

    /// Adds a row. Tells when it begins to fail, and when it ends to.
    pub fn add(&mut self, row: &str) -> Option<Change> {
        match self.write(row) {
            Ok(()) => {
                self.rows.written += 1;
                std::mem::take(&mut self.failing).then_some(Change::Recovered(self.rows.lost))
            }
            Err(error) => {
                self.rows.lost += 1;
                self.file = None;
                (!std::mem::replace(&mut self.failing, true)).then_some(Change::Failed(error))
            }
        }
    }

    fn write(&mut self, row: &str) -> Result<(), SheetError> {
        let Self { path, file, .. } = self;
        let failed = |reason| SheetError::Io { path: path.clone(), reason };
        let open = match file {
            Some(open) => open,
            None => file.insert(open(path)?),
        };
        open.append(row).map_err(failed)
    }
}

/// Opens a file for more rows. Writes the header into an empty one.
fn open(path: &Path) -> Result<Open, SheetError> {
    let failed = |reason| SheetError::Io { path: path.to_owned(), reason };
    let file = OpenOptions::new().append(true).create(true).open(path).map_err(failed)?;
    let metadata = file.metadata().map_err(failed)?;
    let mut open = Open { file, length: metadata.len() };
    let header = header();
    // What is no file (a pipe, say) has nothing in it to go on from.
    if !metadata.is_file() || metadata.len() == 0 {
        open.append(&header).map_err(failed)?;
    } else if start_of(path, header.len() + 1).map_err(failed)? != format!("{header}\n").as_bytes() {
        return Err(SheetError::OtherColumns { path: path.to_owned() });
    } else {
        open.length = whole_rows(path, open.length).map_err(failed)?;
        open.file.set_len(open.length).map_err(failed)?;
    }
    Ok(open)
}

/// Bytes of a file of so many bytes that are whole rows: a crash may have cut the last one.
fn whole_rows(path: &Path, length: u64) -> io::Result<u64> {
    let (mut file, mut end) = (File::open(path)?, Vec::new());
    file.seek(SeekFrom::Start(length.saturating_sub(LONGEST_ROW)))?;
    file.read_to_end(&mut end)?;
    let cut = end.iter().rev().take_while(|byte| **byte != b'\n').count();
    Ok(length - cut as u64)
}

fn start_of(path: &Path, bytes: usize) -> io::Result<Vec<u8>> {
    let mut start = Vec::new();
    File::open(path)?.take(bytes as u64).read_to_end(&mut start)?;
    Ok(start)
}

impl Open {
    /// Adds a line. A part of one (the disk is full) is taken back, so that the file stays readable.
    fn append(&mut self, line: &str) -> io::Result<()> {
        let line = format!("{line}\n");
        let written = self.file.write_all(line.as_bytes());
        match written {
            Ok(()) => self.length += line.len() as u64,
            // A pipe or a device has no length to go back to.
            Err(_) => drop(self.file.set_len(self.length)),
        }
        written
    }
}

#[cfg(test)]
#[path = "sheet_tests.rs"]
mod tests;
