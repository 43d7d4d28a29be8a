//! Files that somebody names, or that lie in a folder of somebody else. Only regular files are
//! opened, and only up to a size: a pipe or a device would keep a program waiting for ever, and a
//! sparse file takes all memory.
//!
//! ```
//! use std::path::Path;
//! use regatta_base::file;
//!
//! let error = file::read_text(Path::new("."), 1 << 20).unwrap_err();
//! assert_eq!(error.to_string(), "this is a folder: give a file inside it");
//! ```

use std::fs::{File, Metadata, OpenOptions};
use std::io::{self, Read};
use std::path::Path;

/// The reason why a file isn't read, as the inner error of an [`io::Error`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RefusedFile {
    /// It is a folder.
    #[error("this is a folder: give a file inside it")]
    Folder,
    /// It is a pipe, a socket or a device.
    #[error("this is a pipe or a device, and no regular file: give a file")]
    Special,
    /// It has more bytes than any such file.
    #[error("too large: at most {} can be read", bytes_in_words(*limit))]
    TooLarge {
        /// The largest size, in bytes.
        limit: u64,
    },
}

impl From<RefusedFile> for io::Error {
    fn from(reason: RefusedFile) -> Self {
        let kind = match reason {
            RefusedFile::Folder => io::ErrorKind::IsADirectory,
            RefusedFile::Special => io::ErrorKind::InvalidInput,
            RefusedFile::TooLarge { .. } => io::ErrorKind::FileTooLarge,
        };
        Self::new(kind, reason)
    }
}

impl RefusedFile {
    /// Returns the reason in an error of this module; `None` if the system has refused the file.
    pub fn of(error: &io::Error) -> Option<Self> {
        error.get_ref()?.downcast_ref().copied()
    }
}

/// Opens a regular file of at most `limit` bytes for reading. It never waits.
///
/// # Errors
/// [`RefusedFile`] for other files, or the error of the system.
pub fn open(path: &Path, limit: u64) -> io::Result<File> {
    // Opening a device may already change it, so that its kind is looked up first.
    check(&path.metadata()?, limit)?;
    let file = without_waiting().read(true).open(path)?;
    // Another file may have taken its place in the meantime.
    check(&file.metadata()?, limit)?;
    Ok(file)
}

/// Reads a regular file of at most `limit` bytes.
///
/// # Errors
/// As [`open`], and those of reading.
pub fn read(path: &Path, limit: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    // The file may grow while it is read.
    open(path, limit)?.take(limit.saturating_add(1)).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > limit {
        return Err(RefusedFile::TooLarge { limit }.into());
    }
    Ok(bytes)
}

/// Reads a regular file of at most `limit` bytes as a text.
///
/// # Errors
/// As [`read`], and `InvalidData` if it isn't UTF-8.
pub fn read_text(path: &Path, limit: u64) -> io::Result<String> {
    String::from_utf8(read(path, limit)?)
        .map_err(|_| io::Error::new(io::ErrorKind::InvalidData, "it isn't a text in UTF-8"))
}

fn check(metadata: &Metadata, limit: u64) -> Result<(), RefusedFile> {
    if metadata.is_dir() {
        Err(RefusedFile::Folder)
    } else if !metadata.is_file() {
        Err(RefusedFile::Special)
    } else if metadata.len() > limit {
        Err(RefusedFile::TooLarge { limit })
    } else {
        Ok(())
    }
}

/// Options with which a pipe without a writer is opened at once.
#[cfg(unix)]
fn without_waiting() -> OpenOptions {
    use std::os::unix::fs::OpenOptionsExt;
    let mut options = OpenOptions::new();
    options.custom_flags(rustix::fs::OFlags::NONBLOCK.bits() as i32);
    options
}

#[cfg(not(unix))]
fn without_waiting() -> OpenOptions {
    OpenOptions::new()
}

fn bytes_in_words(bytes: u64) -> String {
    match bytes {
        0..1024 => format!("{bytes} bytes"),
        1024..1_048_576 => format!("{} KiB", bytes >> 10),
        _ => format!("{} MiB", bytes >> 20),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(path: &Path, limit: u64) -> Option<RefusedFile> {
        RefusedFile::of(&read(path, limit).expect_err("it is refused"))
    }

    #[test]
    fn a_file_is_read_up_to_its_limit() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.txt");
        std::fs::write(&path, "12345").expect("written");
        assert_eq!(read_text(&path, 5).expect("a text"), "12345");
        assert_eq!(refused(&path, 4), Some(RefusedFile::TooLarge { limit: 4 }));
        assert_eq!(refused(folder.path(), 5), Some(RefusedFile::Folder));
        std::fs::write(&path, [0xff]).expect("written");
        assert_eq!(read_text(&path, 5).expect_err("no text").kind(), io::ErrorKind::InvalidData);
        let missing = read(&folder.path().join("b.txt"), 5).expect_err("missing");
        assert_eq!((RefusedFile::of(&missing), missing.kind()), (None, io::ErrorKind::NotFound));
    }

    #[test]
    fn a_sparse_file_is_refused_by_its_size() {
        let file = tempfile::NamedTempFile::new().expect("a file");
        file.as_file().set_len(1 << 40).expect("a sparse file");
        assert_eq!(refused(file.path(), 1 << 30), Some(RefusedFile::TooLarge { limit: 1 << 30 }));
    }

    #[cfg(unix)]
    #[test]
    fn pipes_and_devices_are_refused_at_once() {
        use rustix::fs::{CWD, FileType, Mode, mknodat};
        let folder = tempfile::tempdir().expect("a folder");
        let pipe = folder.path().join("pipe");
        mknodat(CWD, &pipe, FileType::Fifo, Mode::from_raw_mode(0o600), 0).expect("a pipe");
        for path in [pipe.as_path(), Path::new("/dev/zero"), Path::new("/dev/null")] {
            assert_eq!(refused(path, 1 << 20), Some(RefusedFile::Special), "{}", path.display());
        }
    }
}
