//! Files that appear under their name only once they are complete.

use std::fs::File;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

use tempfile::{Builder, TempPath};

/// A file that is being written beside its path. [`commit`](Self::commit) moves it there, in place
/// of a file that is there already. It is removed if it is dropped before.
///
/// It holds no open file, so that there can be thousands of them.
///
/// ```
/// # let folder = tempfile::tempdir()?;
/// # let path = folder.path().join("report.txt");
/// use std::io::Write;
///
/// let (report, mut file) = regatta_kit::WholeFile::create(&path)?;
/// file.write_all(b"complete")?;
/// assert!(!path.exists());
/// report.commit()?;
/// assert_eq!(std::fs::read(&path)?, b"complete");
/// # std::io::Result::Ok(())
/// ```
#[derive(Debug)]
pub struct WholeFile {
    temporary: TempPath,
    path: PathBuf,
}

impl WholeFile {
    /// Creates an empty temporary file in the folder of a path. Returns it with the open file, to
    /// be read and written.
    ///
    /// # Errors
    /// If the folder doesn't exist, or can't be written.
    pub fn create(path: &Path) -> io::Result<(Self, File)> {
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let prefix = format!(".{name}.");
        let temporary = Builder::new()
            .prefix(&prefix)
            .suffix(".part")
            // Opened here, it has the permissions of any new file.
            .make_in(folder.unwrap_or(Path::new(".")), |path| {
                File::options().read(true).write(true).create_new(true).open(path)
            })?;
        let (file, temporary) = temporary.into_parts();
        Ok((Self { temporary, path: path.to_owned() }, file))
    }

    /// The path of the temporary file.
    pub fn temporary_path(&self) -> &Path {
        &self.temporary
    }

    /// Writes the file to the disk, and moves it to its path.
    ///
    /// # Errors
    /// If it can't be written or moved. It is removed then.
    pub fn commit(self) -> io::Result<()> {
        File::options().write(true).open(&self.temporary)?.sync_all()?;
        Ok(self.temporary.persist(self.path)?)
    }
}

/// Writes a whole file. Readers see either all of it or the previous content.
///
/// # Errors
/// If it can't be written or moved to its path.
pub fn write(path: &Path, content: &[u8]) -> io::Result<()> {
    let (whole, mut file) = WholeFile::create(path)?;
    file.write_all(content)?;
    whole.commit()
}
