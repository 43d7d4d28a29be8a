//! A CSV file to which a process appends rows for as long as it runs.

use std::fmt;
use std::fs::{File, Metadata, OpenOptions};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use regatta_plugin::reopen_on_hangup;

/// An upper bound of the bytes in a row.
const MAX_ROW_BYTES: u64 = 1 << 16;

/// The error of opening or writing a CSV file.
#[derive(Debug, thiserror::Error)]
pub enum CsvError {
    /// The file can't be opened, read or written.
    #[error("can't write {path} ({reason})")]
    Io {
        /// Path of the file.
        path: PathBuf,
        /// Error of the operating system.
        reason: io::Error,
    },
    /// The file has another header.
    #[error(
        "{path} is another kind of file: its first line is not the header; move it away, or choose \
         another file"
    )]
    OtherHeader {
        /// Path of the file.
        path: PathBuf,
    },
}

/// A change of the file's state that the user should know.
#[derive(Debug)]
pub enum CsvChange {
    /// Rows are lost from now on.
    Failed(CsvError),
    /// The file can be written again.
    Recovered {
        /// Path of the file.
        path: PathBuf,
        /// Number of rows lost so far.
        lost: u64,
    },
}

impl fmt::Display for CsvChange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Failed(error) => write!(f, "{error}; rows are lost until it can be written"),
            Self::Recovered { path, lost } => {
                write!(f, "{} can be written again; {lost} rows were lost", path.display())
            }
        }
    }
}

/// The numbers of rows written and lost.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RowCounts {
    /// Number of rows written.
    pub written: u64,
    /// Number of rows that could not be written.
    pub lost: u64,
}

/// A CSV file to which rows are appended. Existing rows are kept; rows that are appended together
/// are written completely or not at all.
///
/// The file may be rotated while it is open. If it was moved or removed, and after `SIGHUP` in a
/// process without a terminal, the next rows go to a new file at its path. If it was truncated, the
/// next rows start the file again. In both cases, the header comes first.
#[derive(Debug)]
pub struct CsvFile {
    path: PathBuf,
    /// The first line, with its end.
    header: String,
    file: Option<OpenFile>,
    rows: RowCounts,
    is_failing: bool,
    /// Set by `SIGHUP`.
    hangup: Option<Arc<AtomicBool>>,
}

impl CsvFile {
    /// Opens a file, or creates it, with the header unless it has it. A row at its end that a crash
    /// has cut is removed. To be called before
    /// [`Termination::watch`](regatta_plugin::Termination::watch), or else `SIGHUP` still ends the
    /// process.
    ///
    /// # Errors
    /// [`CsvError`] if the file can't be opened, or begins with another line. One that can be
    /// opened but not written, because the disk is full, is no error yet.
    pub fn open(path: &Path, header: &str) -> Result<Self, CsvError> {
        let mut csv_file = Self {
            path: path.to_owned(),
            header: format!("{header}\n"),
            file: None,
            rows: RowCounts::default(),
            is_failing: false,
            hangup: reopen_on_hangup()
                .map_err(|reason| CsvError::Io { path: path.to_owned(), reason })?,
        };
        // A header that can't be written now is written with the first row.
        match csv_file.write("") {
            Err(error) if csv_file.file.is_none() => Err(error),
            _ => Ok(csv_file),
        }
    }

    /// Path of the file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the numbers of rows written and lost.
    pub fn rows(&self) -> RowCounts {
        self.rows
    }

    /// Appends rows, each of which ends with a line feed. Returns a change when writing begins to
    /// fail, and when it works again.
    pub fn append(&mut self, rows: &str) -> Option<CsvChange> {
        let count = rows.lines().count() as u64;
        match self.write(rows) {
            Ok(()) => {
                self.rows.written += count;
                let recovered =
                    CsvChange::Recovered { path: self.path.clone(), lost: self.rows.lost };
                std::mem::take(&mut self.is_failing).then_some(recovered)
            }
            Err(error) => {
                self.rows.lost += count;
                self.file = None;
                (!std::mem::replace(&mut self.is_failing, true)).then_some(CsvChange::Failed(error))
            }
        }
    }

    fn write(&mut self, rows: &str) -> Result<(), CsvError> {
        let Self { path, header, file, .. } = self;
        let hung_up =
            self.hangup.as_ref().is_some_and(|hangup| hangup.swap(false, Ordering::Relaxed));
        if hung_up || file.as_ref().is_some_and(|file| file.was_moved(path)) {
            *file = None;
        }
        let open = match file {
            Some(open) => open,
            none => none.insert(OpenFile::open(path, header)?),
        };
        open.append(header, rows).map_err(|reason| CsvError::Io { path: path.clone(), reason })
    }
}

/// A file that is open for appending.
#[derive(Debug)]
struct OpenFile {
    file: File,
    /// Whether it has contents, unlike a pipe or a device.
    is_regular: bool,
    /// Whether the header was written to a pipe or a device.
    is_begun: bool,
}

impl OpenFile {
    fn open(path: &Path, header: &str) -> Result<Self, CsvError> {
        match Self::try_open(path, header) {
            Ok(Some(file)) => Ok(file),
            Ok(None) => Err(CsvError::OtherHeader { path: path.to_owned() }),
            Err(reason) => Err(CsvError::Io { path: path.to_owned(), reason }),
        }
    }

    /// Opens a file; `None` if it has another header.
    fn try_open(path: &Path, header: &str) -> io::Result<Option<Self>> {
        let file = OpenOptions::new().append(true).create(true).open(path)?;
        let metadata = file.metadata()?;
        if metadata.is_file() && metadata.len() > 0 {
            let Some(whole) = whole_rows(path, header, metadata.len())? else { return Ok(None) };
            if whole < metadata.len() {
                file.set_len(whole)?;
            }
        }
        Ok(Some(Self { file, is_regular: metadata.is_file(), is_begun: false }))
    }

    /// Appends rows, after the header at the beginning of the file. Rows that are written only in
    /// part, for example on a full disk, are removed, so that the file stays readable.
    fn append(&mut self, header: &str, rows: &str) -> io::Result<()> {
        // A rotation may have truncated the file.
        let length =
            if self.is_regular { self.file.metadata()?.len() } else { u64::from(self.is_begun) };
        let text = [if length == 0 { header } else { "" }, rows].concat();
        let written = self.file.write_all(text.as_bytes());
        match written {
            Ok(()) => self.is_begun = true,
            // A pipe or a device can't be truncated.
            Err(_) => drop(self.file.set_len(length)),
        }
        written
    }

    /// Whether the path leads to another file by now, or to none.
    fn was_moved(&self, path: &Path) -> bool {
        match (path.metadata(), self.file.metadata()) {
            (Ok(there), Ok(here)) => self.is_regular && identity(&there) != identity(&here),
            (Err(error), _) => self.is_regular && error.kind() == io::ErrorKind::NotFound,
            (_, Err(_)) => false,
        }
    }
}

/// Device and inode of a file. Other systems don't let an open file be moved.
#[cfg(unix)]
fn identity(metadata: &Metadata) -> (u64, u64) {
    use std::os::unix::fs::MetadataExt;
    (metadata.dev(), metadata.ino())
}

#[cfg(not(unix))]
fn identity(_: &Metadata) {}

/// Returns the length of the whole rows in a file of `length` bytes; `None` if it has another
/// header. A crash may have cut the last row, or the header.
fn whole_rows(path: &Path, header: &str, length: u64) -> io::Result<Option<u64>> {
    let mut file = File::open(path)?;
    let (mut start, mut end) = (Vec::new(), Vec::new());
    (&mut file).take(header.len() as u64).read_to_end(&mut start)?;
    if start != header.as_bytes() {
        return Ok(header.as_bytes().starts_with(&start).then_some(0));
    }
    file.seek(SeekFrom::Start(length.saturating_sub(MAX_ROW_BYTES)))?;
    file.read_to_end(&mut end)?;
    let cut = end.iter().rev().take_while(|byte| **byte != b'\n').count();
    Ok(Some(length - cut as u64))
}

#[cfg(test)]
mod tests;
