//! Writes the files of exports, plots and repairs. A file appears under its name only once it is
//! complete.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use mcap::MAGIC;
use regatta_kit::WholeFile;

/// A file that is being written. It is removed unless it is committed.
#[derive(Debug)]
pub(crate) struct Draft {
    path: PathBuf,
    /// The content so far; `None` if `path` isn't a regular file but, for example, a pipe.
    draft: Option<WholeFile>,
}

impl Draft {
    /// Starts to write a file. An existing file is replaced only with `force`. A recording is never
    /// replaced: it may be the one that is read.
    pub fn create(path: &Path, force: bool) -> io::Result<(Self, File)> {
        if let Ok(existing) = path.metadata() {
            if !existing.is_file() && !existing.is_dir() {
                let file = OpenOptions::new().write(true).open(path)?;
                return Ok((Self { path: path.to_owned(), draft: None }, file));
            }
            if let Some(reason) = refusal(path, existing.is_dir(), force) {
                return Err(io::Error::new(io::ErrorKind::AlreadyExists, reason));
            }
        }
        let (draft, file) = WholeFile::create(path)?;
        Ok((Self { path: path.to_owned(), draft: Some(draft) }, file))
    }

    /// Opens the file again, to append to it.
    pub fn append(&self) -> io::Result<File> {
        let path = self.draft.as_ref().map_or(&*self.path, WholeFile::temporary_path);
        OpenOptions::new().append(true).open(path)
    }

    /// Gives the complete file its name.
    pub fn commit(self) -> io::Result<()> {
        self.draft.map_or(Ok(()), WholeFile::commit)
    }
}

/// Returns the reason if an existing file or folder can't be replaced.
fn refusal(path: &Path, is_folder: bool, force: bool) -> Option<&'static str> {
    if is_folder {
        Some("it is a folder")
    } else if is_recording(path) {
        Some("it is a recording; choose another file, or remove it")
    } else if !force {
        Some("it exists already; choose another file, or --force to overwrite it")
    } else {
        None
    }
}

fn is_recording(path: &Path) -> bool {
    let mut magic = [0; MAGIC.len()];
    let file = regatta_base::file::open(path, u64::MAX);
    file.and_then(|mut file| file.read_exact(&mut magic)).is_ok() && magic == *MAGIC
}

/// A folder that is removed again if nothing is written to it.
#[derive(Debug)]
pub(crate) struct Folder {
    /// The folders that didn't exist before, the deepest one first.
    created: Vec<PathBuf>,
}

impl Folder {
    pub fn create(path: &Path) -> io::Result<Self> {
        let mut created = Vec::new();
        for folder in path.ancestors() {
            if folder.as_os_str().is_empty() || folder.exists() {
                break;
            }
            created.push(folder.to_owned());
        }
        fs::create_dir_all(path)?;
        Ok(Self { created })
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        // A folder that has files can't be removed, as intended.
        for folder in &self.created {
            let _ = fs::remove_dir(folder);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write as _;

    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name());
        entries.map(|name| name.to_string_lossy().into_owned()).collect()
    }

    #[test]
    fn a_file_appears_when_it_is_complete_and_nothing_is_left_of_an_incomplete_one() {
        let folder = tempfile::TempDir::new().unwrap();
        let path = folder.path().join("new/deep/a.csv");
        let created = Folder::create(path.parent().unwrap()).unwrap();
        drop(Draft::create(&path, false).unwrap());
        drop(created);
        assert_eq!(names(folder.path()), [""; 0]);

        let _created = Folder::create(path.parent().unwrap()).unwrap();
        let (draft, mut file) = Draft::create(&path, false).unwrap();
        file.write_all(b"one").unwrap();
        draft.append().unwrap().write_all(b",two").unwrap();
        assert!(!path.exists());
        draft.commit().unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"one,two");
        assert_eq!(names(path.parent().unwrap()), ["a.csv"]);
    }

    #[test]
    fn an_existing_file_stays_until_its_successor_is_complete() {
        let folder = tempfile::TempDir::new().unwrap();
        let path = folder.path().join("a.csv");
        fs::write(&path, "precious").unwrap();
        assert!(Draft::create(&path, false).unwrap_err().to_string().contains("--force"));
        assert!(Draft::create(folder.path(), true).unwrap_err().to_string().contains("folder"));
        let (draft, mut file) = Draft::create(&path, true).unwrap();
        file.write_all(b"new").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"precious");
        draft.commit().unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
    }
}
