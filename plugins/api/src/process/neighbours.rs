//! The processes that share this user's directory of iceoryx2's files: all of them must see the same
//! shared memory.
//!
//! In a container that shares the directory alone, a live fleet looks like one whose segments are
//! gone: a process that joins would clean up after it, and make it unreachable for its owner. So
//! each process holds a lock on a file that names its `/dev/shm`, as long as it lives.

use std::fs::{File, TryLockError};
use std::io::{self, Read as _, Seek as _, Write as _};
use std::os::unix::fs::{MetadataExt as _, OpenOptionsExt as _};
use std::path::Path;
use std::sync::OnceLock;
use std::time::Duration;

use super::domain::{DomainError, SHARED_MEMORY};

/// The name of the file.
const FILE: &str = "shared_memory";
/// The longest content of the file, in bytes.
const MAX_BYTES: u64 = 64;
/// The reason of a directory that can't be used.
const ELSEWHERE: &str = "processes that see another /dev/shm use it: share /dev/shm too, by \
                         `docker run --ipc=host` or a volume";
/// The largest number of attempts while other processes hold the lock.
const ATTEMPTS: usize = 20;
/// The time between two attempts.
const PAUSE: Duration = Duration::from_millis(5);

/// The lock that this process holds.
static HELD: OnceLock<File> = OnceLock::new();

/// Checks that the processes that use a directory see this process's shared memory, and counts this
/// process as one of them.
///
/// # Errors
/// [`DomainError`] if they don't.
pub(super) fn check(directory: &Path) -> Result<(), DomainError> {
    // Systems without it have nothing to compare.
    let Ok(metadata) = Path::new(SHARED_MEMORY).metadata() else { return Ok(()) };
    let own = format!("{:x}-{:x}", metadata.dev(), metadata.ino());
    match join(&directory.join(FILE), &own) {
        Ok(Some(file)) => {
            HELD.get_or_init(|| file);
            Ok(())
        }
        Ok(None) => Err(DomainError::new(directory, ELSEWHERE)),
        Err(error) => Err(DomainError::new(directory, error)),
    }
}

/// Returns the locked file, which has this content; `None` if others hold it with another one.
fn join(path: &Path, own: &str) -> io::Result<Option<File>> {
    let mut file = File::options()
        .read(true)
        .write(true)
        .create(true)
        .truncate(false)
        .mode(0o600)
        .custom_flags(libc::O_NOFOLLOW | libc::O_NONBLOCK)
        .open(path)?;
    for _ in 0..ATTEMPTS {
        file.lock_shared()?;
        if content(&mut file)? == own {
            return Ok(Some(file));
        }
        file.unlock()?;
        match file.try_lock() {
            Ok(()) => replace(&mut file, own)?,
            // Another process may be doing the same.
            Err(TryLockError::WouldBlock) => std::thread::sleep(PAUSE),
            Err(TryLockError::Error(error)) => return Err(error),
        }
        file.unlock()?;
    }
    Ok(None)
}

fn content(file: &mut File) -> io::Result<String> {
    let mut content = String::new();
    file.rewind()?;
    file.take(MAX_BYTES).read_to_string(&mut content)?;
    Ok(content)
}

fn replace(file: &mut File, content: &str) -> io::Result<()> {
    file.set_len(0)?;
    file.rewind()?;
    file.write_all(content.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whoever_sees_other_shared_memory_waits_until_all_others_have_gone() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join(FILE);
        let first = join(&path, "here").expect("usable").expect("it is the first");
        let second = join(&path, "here").expect("usable").expect("it sees the same");
        assert!(join(&path, "container").expect("usable").is_none());
        drop(first);
        assert!(join(&path, "container").expect("usable").is_none(), "one is left");
        drop(second);
        let _other = join(&path, "container").expect("usable").expect("nobody else is there");
        assert!(join(&path, "here").expect("usable").is_none());
    }

    #[test]
    fn a_link_in_place_of_the_file_is_not_followed() {
        let folder = tempfile::tempdir().expect("a folder");
        let (path, target) = (folder.path().join(FILE), folder.path().join("target"));
        std::fs::write(&target, "precious").expect("written");
        std::os::unix::fs::symlink(&target, &path).expect("linked");
        join(&path, "here").expect_err("a link");
        assert_eq!(std::fs::read_to_string(&target).expect("there"), "precious");
    }
}
