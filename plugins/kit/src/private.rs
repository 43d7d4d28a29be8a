//! Files that only this user can read: the directory of sockets, and the token with which this
//! user's commands reach servers over TCP.

use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

use regatta_base::file;

/// The name of the directory, in that of shared memory.
const DIRECTORY: &str = "private";
/// The name of the file with the token.
const TOKEN: &str = "token";
/// The shortest token, in characters.
const MIN_TOKEN: usize = 8;
/// The longest token, in bytes, with its end of line.
const MAX_TOKEN_BYTES: u64 = 4096;

/// The error of a file with a token that can't be used.
#[derive(Debug, thiserror::Error)]
#[error("can't use the token of {} ({reason})", path.display())]
pub struct TokenError {
    path: PathBuf,
    reason: String,
}

impl TokenError {
    fn new(path: &Path, reason: impl ToString) -> Self {
        Self { path: path.to_owned(), reason: reason.to_string() }
    }
}

/// Returns a directory that only this user can use, which exists from then on.
///
/// # Errors
/// If it can't be made, or others can write to it.
pub fn directory() -> io::Result<PathBuf> {
    regatta_plugin::private_directory(DIRECTORY).map_err(io::Error::other)
}

/// Returns the file with this user's token, which may not exist yet.
///
/// # Errors
/// As [`directory`].
pub fn token_file() -> io::Result<PathBuf> {
    Ok(directory()?.join(TOKEN))
}

/// Returns this user's token. It is made at the first call.
///
/// # Errors
/// [`TokenError`] if it can't be made or read.
pub fn token() -> Result<String, TokenError> {
    let path = token_file().map_err(|error| TokenError::new(Path::new(DIRECTORY), error))?;
    match make_token(&path) {
        Err(error) if error.kind() != io::ErrorKind::AlreadyExists => {
            Err(TokenError::new(&path, error))
        }
        _ => read_token(&path),
    }
}

/// Makes a random token, unless there is one.
fn make_token(path: &Path) -> io::Result<()> {
    if path.symlink_metadata().is_ok() {
        return Ok(());
    }
    let mut random = [0; 24];
    getrandom::fill(&mut random).map_err(io::Error::other)?;
    let token: String = random.iter().map(|byte| format!("{byte:02x}")).collect();
    // Readable by this user alone, and never seen in part.
    let mut file = tempfile::NamedTempFile::new_in(path.parent().unwrap_or(Path::new(".")))?;
    writeln!(file, "{token}")?;
    file.persist_noclobber(path)?;
    Ok(())
}

/// Reads a token from a file.
///
/// # Errors
/// [`TokenError`] if it isn't a regular file, or has no token.
pub fn read_token(path: &Path) -> Result<String, TokenError> {
    let text =
        file::read_text(path, MAX_TOKEN_BYTES).map_err(|error| TokenError::new(path, error))?;
    let token = text.trim();
    match token.len() >= MIN_TOKEN && token.bytes().all(|byte| byte.is_ascii_graphic()) {
        true => Ok(token.to_owned()),
        false => {
            let reason = format!("it must have at least {MIN_TOKEN} visible ASCII characters");
            Err(TokenError::new(path, reason))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_token_is_made_once_and_for_its_user_alone() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join(TOKEN);
        make_token(&path).expect("made");
        let first = read_token(&path).expect("a token");
        make_token(&path).expect("kept");
        assert_eq!((read_token(&path).expect("a token"), first.len()), (first, 48));
        #[cfg(unix)]
        {
            let mode = std::os::unix::fs::PermissionsExt::mode(
                &path.metadata().expect("a file").permissions(),
            );
            assert_eq!(mode & 0o777, 0o600);
        }
    }

    #[test]
    fn files_without_a_token_are_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("mine");
        for (content, reason) in [
            ("short\n".to_owned(), "at least 8"),
            ("with a space".to_owned(), "visible"),
            ("x".repeat(5000), "at most 4 KiB"),
        ] {
            std::fs::write(&path, content).expect("written");
            let error = read_token(&path).expect_err(reason).to_string();
            assert!(error.contains(reason), "{error}");
        }
        let error = read_token(folder.path()).expect_err("a folder").to_string();
        assert!(error.contains("this is a folder"), "{error}");
        #[cfg(unix)]
        read_token(Path::new("/dev/zero")).expect_err("a device");
        read_token(&folder.path().join("none")).expect_err("no file");
    }
}
