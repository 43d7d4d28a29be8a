//! The files that commands write: each appears only when it is complete, and none replaces another
//! without `--force`.

use std::ffi::OsString;
use std::fmt::Display;
use std::fs::{self, File, Metadata};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use clap::Args;
use regatta_base::thousands;
use regatta_plugin::{Termination, visible};

use crate::failure::{Failure, plugin_failure};

/// The name of standard input or standard output in place of a file.
pub const STANDARD_STREAM: &str = "-";

/// The destination of a text that a command writes.
#[derive(Clone, Debug)]
pub enum Destination {
    /// Standard output, written as `-`.
    StandardOutput,
    /// A file.
    File(PathBuf),
}

impl From<OsString> for Destination {
    fn from(text: OsString) -> Self {
        if text == STANDARD_STREAM { Self::StandardOutput } else { Self::File(text.into()) }
    }
}

/// Whether a command may replace files.
#[derive(Args, Clone, Copy, Debug)]
pub struct Force {
    /// Replace files that exist
    #[arg(long)]
    pub force: bool,
}

impl Destination {
    /// Returns an error if [`write`](Self::write) would refuse to write here. Commands call it
    /// before long work.
    pub fn check(&self, force: Force) -> Result<(), Failure> {
        match self {
            Self::StandardOutput => Ok(()),
            Self::File(path) => check_file(path, force).map(|_| ()),
        }
    }

    /// Writes a text.
    pub fn write(&self, text: &str, force: Force) -> Result<(), Failure> {
        match self {
            Self::StandardOutput => {
                print!("{text}");
                Ok(())
            }
            Self::File(path) => write_file(path, text.as_bytes(), force),
        }
    }
}

/// Returns the metadata of a file that may be written to; `None` if there is none yet.
pub fn check_file(path: &Path, force: Force) -> Result<Option<Metadata>, Failure> {
    // An error means that there is no such file, or that creating one will fail and say why.
    let Ok(metadata) = fs::metadata(path) else { return Ok(None) };
    if metadata.is_dir() {
        return Err(format!("{}: this is a folder; give a file", path.display()).into());
    }
    if metadata.is_file() && !force.force {
        return Err(format!("{}: this file exists; --force replaces it", path.display()).into());
    }
    Ok(Some(metadata))
}

/// Writes a file that appears under its name only when it is complete. Pipes and devices are
/// written to directly.
pub fn write_file(path: &Path, bytes: &[u8], force: Force) -> Result<(), Failure> {
    // An interrupt from now on doesn't leave half a file: this command ends when the file is
    // complete.
    Termination::watch().map_err(plugin_failure)?;
    let written = match check_file(path, force)? {
        Some(metadata) if !metadata.is_file() => {
            File::options().write(true).open(path).and_then(|mut file| file.write_all(bytes))
        }
        replaced => write_beside(path, bytes, replaced),
    };
    written.map_err(|error| unwritable(path, &error))
}

/// Writes a file in a folder that may hold anything: what has its name is replaced, and links
/// aren't followed.
pub fn write_inside(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    Termination::watch().map_err(plugin_failure)?;
    regatta_kit::whole_file::write(path, bytes).map_err(|error| unwritable(path, &error))
}

/// Returns the error of writing a file or a folder. The system's own text may name a temporary
/// file, which users don't know.
pub fn unwritable(path: &Path, error: &io::Error) -> Failure {
    let advice = match error.kind() {
        io::ErrorKind::NotFound => "the folder doesn't exist: create it, or give another",
        io::ErrorKind::PermissionDenied => "you may not write there: give another folder",
        io::ErrorKind::StorageFull => "the disk is full: make room, or give another folder",
        io::ErrorKind::NotADirectory => "a part of the path is a file: give a folder",
        kind => {
            return format!("{}: can't write: {kind}; give another path", path.display()).into();
        }
    };
    format!("{}: can't write: {advice}", path.display()).into()
}

/// Prints a text that may hold names of strangers.
pub fn show(text: impl Display) {
    print!("{}", visible(&text.to_string()));
}

/// Returns a number of things in words.
pub fn with_plural(count: usize, noun: &str) -> String {
    format!("{} {noun}{}", thousands(count as u64), if count == 1 { "" } else { "s" })
}

/// Writes a temporary file in the same folder and renames it. It keeps the permissions of the file
/// that it replaces.
fn write_beside(path: &Path, bytes: &[u8], replaced: Option<Metadata>) -> io::Result<()> {
    // A symbolic link stays; the file that it leads to is replaced.
    let target = if replaced.is_some() { fs::canonicalize(path)? } else { path.to_owned() };
    let folder =
        target.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut builder = tempfile::Builder::new();
    builder.prefix(".regatta-");
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let mut file = builder.tempfile_in(folder)?;
    file.write_all(bytes)?;
    // Without it, a crash of the system could leave the new name with nothing in it.
    file.as_file().sync_all()?;
    match replaced {
        Some(metadata) => {
            file.as_file().set_permissions(metadata.permissions())?;
            file.persist(&target)?;
        }
        None => drop(file.persist_noclobber(&target)?),
    }
    Ok(())
}

/// Returns a word for a shell.
pub fn quoted(word: &str) -> String {
    if word.chars().all(|letter| letter.is_alphanumeric() || "-_=./:,+".contains(letter)) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', r"'\''"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FORCE: Force = Force { force: true };
    const KEEP: Force = Force { force: false };

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).expect("a folder");
        entries
            .map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned())
            .collect()
    }

    #[test]
    fn a_file_is_replaced_only_by_force_and_nothing_else_is_left() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.txt");
        write_file(&path, b"one", KEEP).expect("a new file");
        let error = write_file(&path, b"two", KEEP).expect_err("it exists").to_string();
        assert!(error.contains("a.txt: this file exists; --force"), "{error}");
        assert_eq!(fs::read(&path).expect("readable"), b"one");
        write_file(&path, b"two", FORCE).expect("replaced");
        assert_eq!(fs::read(&path).expect("readable"), b"two");
        assert!(
            write_file(folder.path(), b"", FORCE)
                .expect_err("a folder")
                .to_string()
                .contains("a folder")
        );
        let error = write_file(&folder.path().join("no/a.txt"), b"", FORCE)
            .expect_err("no folder")
            .to_string();
        assert!(
            error.ends_with(
                "no/a.txt: can't write: the folder doesn't exist: create it, or give another"
            ),
            "{error}"
        );
        assert_eq!(names(folder.path()), ["a.txt"]);
    }

    #[cfg(unix)]
    #[test]
    fn a_link_stays_and_so_do_permissions() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        let folder = tempfile::tempdir().expect("a folder");
        let (path, link) = (folder.path().join("a.txt"), folder.path().join("link"));
        write_file(&path, b"one", KEEP).expect("a new file");
        fs::set_permissions(&path, PermissionsExt::from_mode(0o640)).expect("its owner may");
        symlink(&path, &link).expect("a link");
        write_file(&link, b"two", FORCE).expect("replaced");
        assert!(fs::symlink_metadata(&link).expect("a link").is_symlink());
        assert_eq!(fs::read(&path).expect("readable"), b"two");
        assert_eq!(fs::metadata(&path).expect("metadata").permissions().mode() & 0o777, 0o640);
        write_file(Path::new("/dev/null"), b"gone", KEEP)
            .expect("a device is no file that could be lost");
    }
}
