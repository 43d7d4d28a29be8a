//! Files that appear under their name only once they are complete.

use std::fs::File;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

use tempfile::{Builder, NamedTempFile};

/// A file that is being written beside its path. [`commit`](Self::commit) moves it there, in place
/// of a file that is there already. It is removed if it is dropped before.
///
/// ```
/// # let folder = tempfile::tempdir()?;
/// # let path = folder.path().join("report.txt");
/// use std::io::Write;
///
/// let report = regatta_kit::WholeFile::create(&path)?;
/// report.file().write_all(b"complete")?;
/// assert!(!path.exists());
/// report.commit()?;
/// assert_eq!(std::fs::read(&path)?, b"complete");
/// # std::io::Result::Ok(())
/// ```
#[derive(Debug)]
pub struct WholeFile {
    file: NamedTempFile,
    path: PathBuf,
}

impl WholeFile {
    /// Creates an empty temporary file in the folder of a path.
    ///
    /// # Errors
    /// If the folder doesn't exist, or can't be written.
    pub fn create(path: &Path) -> io::Result<Self> {
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let prefix = format!(".{name}.");
        let file = Builder::new()
            .prefix(&prefix)
            .suffix(".part")
            // Opened here, it has the permissions of any new file.
            .make_in(folder.unwrap_or(Path::new(".")), |path| {
                File::options().read(true).write(true).create_new(true).open(path)
            })?;
        Ok(Self { file, path: path.to_owned() })
    }

    /// The temporary file, open for reading and writing.
    pub fn file(&self) -> &File {
        self.file.as_file()
    }

    /// Path of the temporary file.
    pub fn temporary_path(&self) -> &Path {
        self.file.path()
    }

    /// Writes the file to the disk, and moves it to its path.
    ///
    /// # Errors
    /// If it can't be written or moved. It is removed then.
    pub fn commit(self) -> io::Result<()> {
        self.file.as_file().sync_all()?;
        self.file.persist(self.path).map(drop).map_err(|error| error.error)
    }
}

/// Writes a whole file: others see all of it, or what was there before.
///
/// # Errors
/// If it can't be written or moved to its path.
pub fn write(path: &Path, content: &[u8]) -> io::Result<()> {
    let whole = WholeFile::create(path)?;
    whole.file().write_all(content)?;
    whole.commit()
}
