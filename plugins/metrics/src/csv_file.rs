//! The CSV file, to which a row is appended every second.

use std::fs::{File, OpenOptions};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use crate::row::header;

/// An upper bound of the bytes in a row.
const MAX_ROW_BYTES: u64 = 1 << 16;

/// The numbers of rows written and lost.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RowCounts {
    /// Number of rows written.
    pub written: u64,
    /// Number of rows that could not be written.
    pub lost: u64,
}

/// A CSV file to which rows are appended. Existing contents are kept; a row is written as a whole or not at all.
#[derive(Debug)]
pub struct CsvFile {
    path: PathBuf,
    file: Option<OpenFile>,
    rows: RowCounts,
    failing: bool,
}

/// An open file, with its length up to the last whole row.
#[derive(Debug)]
struct OpenFile {
    file: File,
    length: u64,
}

/// The error of writing a row.
#[derive(Debug, thiserror::Error)]
pub enum CsvError {
    /// The file can't be opened, read or written.
    #[error("can't write {path} ({reason}); rows are lost until it can be written")]
    Io {
        /// Path of the file.
        path: PathBuf,
        /// Error of the operating system.
        reason: io::Error,
    },
    /// The file has another header.
    #[error("{path} has other columns; move it away, or choose another file with --csv: rows are lost until then")]
    OtherColumns {
        /// Path of the file.
        path: PathBuf,
    },
}

/// A change of the file's state that is reported to the user.
#[derive(Debug)]
pub enum Transition {
    /// Rows are lost from now on.
    Failed(CsvError),
    /// The file can be written again, after this number of lost rows.
    Recovered(u64),
}

impl CsvFile {
    /// Creates a CSV file at a path that need not exist yet. It is opened with the first row, and again after an error.
    pub fn new(path: &Path) -> Self {
        Self { path: path.to_owned(), file: None, rows: RowCounts::default(), failing: false }
    }

    /// Returns the numbers of rows written and lost.
    pub fn rows(&self) -> RowCounts {
        self.rows
    }

    /// Appends a row. Returns a transition when writing begins to fail, and when it works again.
    pub fn add(&mut self, row: &str) -> Option<Transition> {
        match self.write(row) {
            Ok(()) => {
                self.rows.written += 1;
                std::mem::take(&mut self.failing).then_some(Transition::Recovered(self.rows.lost))
            }
            Err(error) => {
                self.rows.lost += 1;
                self.file = None;
                (!std::mem::replace(&mut self.failing, true)).then_some(Transition::Failed(error))
            }
        }
    }

    fn write(&mut self, row: &str) -> Result<(), CsvError> {
        let Self { path, file, .. } = self;
        let failed = |reason| CsvError::Io { path: path.clone(), reason };
        let open = match file {
            Some(open) => open,
            None => file.insert(open(path)?),
        };
        open.append(row).map_err(failed)
    }
}

/// Opens a file to append rows. Writes the header into an empty one.
fn open(path: &Path) -> Result<OpenFile, CsvError> {
    let failed = |reason| CsvError::Io { path: path.to_owned(), reason };
    let file = OpenOptions::new().append(true).create(true).open(path).map_err(failed)?;
    let metadata = file.metadata().map_err(failed)?;
    let mut open = OpenFile { file, length: metadata.len() };
    let header = header();
    // A pipe or a device has no contents to continue.
    if !metadata.is_file() || metadata.len() == 0 {
        open.append(&header).map_err(failed)?;
    } else if start_of(path, header.len() + 1).map_err(failed)? != format!("{header}\n").as_bytes() {
        return Err(CsvError::OtherColumns { path: path.to_owned() });
    } else {
        open.length = whole_rows(path, open.length).map_err(failed)?;
        open.file.set_len(open.length).map_err(failed)?;
    }
    Ok(open)
}

/// Returns the length of the whole rows in a file of `length` bytes: a crash may have cut the last one.
fn whole_rows(path: &Path, length: u64) -> io::Result<u64> {
    let (mut file, mut end) = (File::open(path)?, Vec::new());
    file.seek(SeekFrom::Start(length.saturating_sub(MAX_ROW_BYTES)))?;
    file.read_to_end(&mut end)?;
    let cut = end.iter().rev().take_while(|byte| **byte != b'\n').count();
    Ok(length - cut as u64)
}

fn start_of(path: &Path, bytes: usize) -> io::Result<Vec<u8>> {
    let mut start = Vec::new();
    File::open(path)?.take(bytes as u64).read_to_end(&mut start)?;
    Ok(start)
}

impl OpenFile {
    /// Appends a line. A partial line, for example on a full disk, is removed, so that the file stays readable.
    fn append(&mut self, line: &str) -> io::Result<()> {
        let line = format!("{line}\n");
        let written = self.file.write_all(line.as_bytes());
        match written {
            Ok(()) => self.length += line.len() as u64,
            // A pipe or a device can't be truncated.
            Err(_) => drop(self.file.set_len(self.length)),
        }
        written
    }
}

#[cfg(test)]
mod tests;
