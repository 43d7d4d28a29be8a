//! The place of this user's shared memory: a directory and a file prefix of its own, so that users
//! of one machine, and containers that share `/dev/shm`, don't meet.

use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};

use iceoryx2::prelude::Config;
#[cfg(unix)]
use iceoryx2::prelude::{FileName, FilePath, SemanticString};

use super::log::quiet;
#[cfg(unix)]
use super::neighbours;

/// The environment variable with the directory of iceoryx2's files. All processes of a fleet must
/// have the same.
///
/// Without it, the directory is `/tmp/regatta-UID`, which only this user can use.
pub const RUNTIME_DIR_VARIABLE: &str = "REGATTA_RUNTIME_DIR";

/// The error of a directory of iceoryx2's files that can't be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "can't keep the files of shared memory in {path} ({reason}); set {RUNTIME_DIR_VARIABLE} to a \
     directory of your own"
)]
pub struct DomainError {
    path: String,
    reason: String,
}

impl DomainError {
    pub(super) fn new(directory: &Path, reason: impl ToString) -> Self {
        Self { path: directory.display().to_string(), reason: reason.to_string() }
    }
}

/// Returns the configuration of iceoryx2, for programs that open Regatta's services by iceoryx2
/// itself.
///
/// It has iceoryx2's defaults, with the directory of this user. The names of segments in `/dev/shm`
/// begin with the identity of this directory (device and inode): processes that don't see the same
/// directory never see the same segments. It is also this process's global configuration of
/// iceoryx2, unless that was in use before.
///
/// # Errors
/// [`DomainError`] if the directory can't be created, or belongs to another user.
pub fn config() -> Result<&'static Config, DomainError> {
    static CONFIG: OnceLock<Result<Config, DomainError>> = OnceLock::new();
    quiet();
    CONFIG.get_or_init(configure).as_ref().map_err(Clone::clone)
}

static LOOK_ONLY: AtomicBool = AtomicBool::new(false);

/// Makes this process leave the resources of dead processes alone when it joins a fleet, opens a
/// service or ends. To be called before anything else of this crate; `regatta doctor` does so.
pub(super) fn look_only() {
    LOOK_ONLY.store(true, Ordering::Relaxed);
}

#[cfg(unix)]
fn configure() -> Result<Config, DomainError> {
    use std::os::unix::fs::MetadataExt;

    let directory = directory()?;
    neighbours::check(&directory)?;
    let metadata = directory.metadata().map_err(|e| DomainError::new(&directory, e))?;
    let prefix = format!("{SEGMENT_PREFIX}{:x}-{:x}_", metadata.dev(), metadata.ino());
    let mut config = Config::default();
    config.global.prefix = FileName::new(prefix.as_bytes())
        .map_err(|e| DomainError::new(&directory, format_args!("{e:?}")))?;
    let path = iceoryx2::prelude::Path::new(directory.as_os_str().as_encoded_bytes())
        .map_err(|e| DomainError::new(&directory, format_args!("{e:?}")))?;
    config.global.set_root_path(&path);
    make_global(&directory, &prefix).map_err(|e| DomainError::new(&directory, e))?;
    if LOOK_ONLY.load(Ordering::Relaxed) {
        config.global.node.cleanup_dead_nodes_on_creation = false;
        config.global.node.cleanup_dead_nodes_on_destruction = false;
        config.global.service.cleanup_dead_nodes_on_open = false;
    }
    Ok(config)
}

/// Makes this the global configuration of iceoryx2 in this process. iceoryx2 takes it from a file
/// only, and uses it when it cleans up after a process whose own configuration it can't read.
#[cfg(unix)]
fn make_global(directory: &Path, prefix: &str) -> std::io::Result<()> {
    use std::io::Write;

    let path = directory.join("iceoryx2.toml");
    let text = format!(
        "[global]\nroot-path = {:?}\nprefix = {prefix:?}\n",
        directory.display().to_string()
    );
    if !std::fs::read_to_string(&path).is_ok_and(|before| before == text) {
        // A new file with a random name: a link that lies there is not followed.
        let mut new = tempfile::NamedTempFile::new_in(directory)?;
        new.write_all(text.as_bytes())?;
        new.persist(&path)?;
    }
    if let Ok(path) = FilePath::new(path.as_os_str().as_encoded_bytes())
        && let Err(error) = Config::setup_global_config_from_file(&path)
    {
        tracing::debug!(%error, "reading the configuration of iceoryx2");
    }
    Ok(())
}

#[cfg(not(unix))]
fn configure() -> Result<Config, DomainError> {
    Ok(Config::default())
}

/// The folder of POSIX shared memory.
pub const SHARED_MEMORY: &str = "/dev/shm";

/// The beginning of the names of all segments of Regatta's, of any user.
pub(crate) const SEGMENT_PREFIX: &str = "regatta_";

/// Returns the directory of iceoryx2's files, which exists from then on.
#[cfg(unix)]
fn directory() -> Result<PathBuf, DomainError> {
    let given = std::env::var_os(RUNTIME_DIR_VARIABLE).filter(|path| !path.is_empty());
    let uid = rustix::process::getuid().as_raw();
    match given {
        Some(given) => owned(Path::new(&given), uid),
        None => {
            let own = PathBuf::from(format!("/tmp/regatta-{uid}"));
            private(&own, uid, OTHERS_MAY_WRITE).map(|()| own)
        }
    }
}

/// Returns a directory with a name, beside this user's files of shared memory: no other user can
/// look into it. It exists from then on.
///
/// # Errors
/// [`DomainError`] if it can't be created, or others can use it.
#[cfg(unix)]
pub fn private_directory(name: &str) -> Result<PathBuf, DomainError> {
    let path = directory()?.join(name);
    private(&path, rustix::process::getuid().as_raw(), OTHERS_MAY_ANYTHING)?;
    Ok(path)
}

/// Returns a directory with a name in this user's folder of temporary files. It exists from then
/// on.
///
/// # Errors
/// [`DomainError`] if it can't be created.
#[cfg(not(unix))]
pub fn private_directory(name: &str) -> Result<PathBuf, DomainError> {
    let path = std::env::temp_dir().join("regatta").join(name);
    std::fs::create_dir_all(&path).map_err(|error| DomainError::new(&path, error))?;
    Ok(path)
}

/// The rights of others to a directory to write to it.
#[cfg(unix)]
const OTHERS_MAY_WRITE: u32 = 0o022;
/// All rights of others to a directory.
#[cfg(unix)]
const OTHERS_MAY_ANYTHING: u32 = 0o077;

/// Creates a directory, or checks that it is this user's: segments belong to one user, so the
/// processes of others, even of root, could join its fleets only halfway, and would hold them up.
#[cfg(unix)]
fn owned(directory: &Path, uid: u32) -> Result<PathBuf, DomainError> {
    let resolved = std::fs::create_dir_all(directory)
        .and_then(|()| directory.canonicalize())
        .and_then(|resolved| Ok((resolved.metadata()?, resolved)));
    let (metadata, resolved) = resolved.map_err(|e| DomainError::new(directory, e))?;
    match std::os::unix::fs::MetadataExt::uid(&metadata) {
        owner if owner == uid => Ok(resolved),
        owner => Err(DomainError::new(&resolved, format_args!("it belongs to user {owner}"))),
    }
}

/// Creates a directory that only this user may use, or checks that others don't have these rights to
/// it: in `/tmp`, another user may have created it.
#[cfg(unix)]
fn private(directory: &Path, uid: u32, rights: u32) -> Result<(), DomainError> {
    use std::os::unix::fs::{DirBuilderExt, MetadataExt};

    match std::fs::DirBuilder::new().mode(0o700).create(directory) {
        Err(error) if error.kind() != std::io::ErrorKind::AlreadyExists => {
            return Err(DomainError::new(directory, error));
        }
        _ => {}
    }
    // Not followed if it is a link.
    let metadata = directory.symlink_metadata().map_err(|e| DomainError::new(directory, e))?;
    if !metadata.is_dir() {
        return Err(DomainError::new(directory, "it is not a directory"));
    }
    if metadata.uid() != uid {
        let owner = metadata.uid();
        return Err(DomainError::new(directory, format_args!("it belongs to user {owner}")));
    }
    if metadata.mode() & rights != 0 {
        return Err(DomainError::new(directory, "other users may use it; `chmod 700` closes it"));
    }
    Ok(())
}

#[cfg(all(test, unix))]
mod tests {
    use std::os::unix::fs::PermissionsExt;

    use super::*;

    #[test]
    fn a_directory_that_others_control_is_refused() {
        let uid = rustix::process::getuid().as_raw();
        let root = std::env::temp_dir().join(format!("regatta-domain-{}", std::process::id()));
        std::fs::create_dir(&root).expect("created");
        let own = root.join("own");
        assert_eq!(private(&own, uid, OTHERS_MAY_WRITE), Ok(()));
        assert_eq!(own.metadata().expect("created").permissions().mode() & 0o777, 0o700);
        assert_eq!(private(&own, uid, OTHERS_MAY_WRITE), Ok(()), "the second time too");
        let error = private(&own, uid + 1, OTHERS_MAY_WRITE).expect_err("another user's");
        assert!(error.to_string().contains(&format!("it belongs to user {uid}")), "{error}");

        std::os::unix::fs::symlink(&own, root.join("link")).expect("linked");
        assert!(private(&root.join("link"), uid, OTHERS_MAY_WRITE).is_err(), "a link");
        std::fs::set_permissions(&own, PermissionsExt::from_mode(0o777)).expect("changed");
        assert!(private(&own, uid, OTHERS_MAY_WRITE).is_err(), "others may write");
        std::fs::remove_dir_all(&root).expect("removed");
    }

    #[test]
    fn a_given_directory_of_another_user_is_refused() {
        let uid = rustix::process::getuid().as_raw();
        let root =
            std::env::temp_dir().join(format!("regatta-domain-given-{}", std::process::id()));
        assert_eq!(owned(&root, uid), Ok(root.canonicalize().expect("created")));
        let error = owned(&root, uid + 1).expect_err("another user's");
        assert!(error.to_string().contains(&format!("it belongs to user {uid}")), "{error}");
        std::fs::remove_dir_all(&root).expect("removed");
    }
}
