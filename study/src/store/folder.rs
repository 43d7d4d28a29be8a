//! Checks that the folder of a study is the user's own, and that what is written into it stays
//! there.

use std::fs::{self, Metadata};
use std::path::{Path, PathBuf};

/// The reason why a folder isn't used.
#[derive(Debug, thiserror::Error)]
pub enum Unsafe {
    /// Somebody else may change it at any time.
    #[error("{}: it belongs to another user: give a folder of your own", path.display())]
    OfAnotherUser {
        /// The file or folder.
        path: PathBuf,
    },
    /// It leads out of the folder.
    #[error(
        "{}: a link, and not a folder of the study: remove it, or give another folder",
        path.display()
    )]
    Link {
        /// The link.
        path: PathBuf,
    },
}

/// Checks that a folder of a study belongs to this user, and that its parts are in it.
///
/// # Errors
/// [`Unsafe`].
pub fn check_folder(folder: &Path) -> Result<(), Unsafe> {
    // A path that doesn't exist, or can't be looked at, can't be written either.
    if let Ok(metadata) = fs::metadata(folder) {
        check_owner(folder, &metadata)?;
    }
    for name in ["jobs", super::RESULTS, "files"] {
        let path = folder.join(name);
        let Ok(metadata) = fs::symlink_metadata(&path) else { continue };
        if metadata.is_symlink() {
            return Err(Unsafe::Link { path });
        }
        check_owner(&path, &metadata)?;
    }
    Ok(())
}

#[cfg(unix)]
fn check_owner(path: &Path, metadata: &Metadata) -> Result<(), Unsafe> {
    use std::os::unix::fs::MetadataExt;
    if metadata.uid() == rustix::process::geteuid().as_raw() {
        Ok(())
    } else {
        Err(Unsafe::OfAnotherUser { path: path.to_owned() })
    }
}

/// Other systems have no owners that could be compared.
#[cfg(not(unix))]
fn check_owner(_path: &Path, _metadata: &Metadata) -> Result<(), Unsafe> {
    Ok(())
}
