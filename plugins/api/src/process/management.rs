//! iceoryx2's management segment: one small file in `/dev/shm`, which every process of a user opens
//! when it joins.
//!
//! iceoryx2 creates it writable for everybody (0666): any local user could write rubbish into it,
//! and then no process could join any more. So the first process to join closes it to others, and
//! damage is recognised and repaired.

use std::fs;
use std::path::{Path, PathBuf};

use super::domain::{SHARED_MEMORY, config};

/// The length of the segment in bytes: iceoryx2's version, and a counter.
const LENGTH: usize = 16;

/// Returns this user's management segment, if there is one, and iceoryx2's version as its name has
/// it: `0_10_0`.
fn segment() -> Option<(PathBuf, [u16; 3])> {
    let global = &config().ok()?.global;
    let (prefix, suffix) = (global.prefix.to_string(), global.node.global_mgmt_suffix.to_string());
    fs::read_dir(SHARED_MEMORY).ok()?.flatten().find_map(|entry| {
        let name = entry.file_name().into_string().ok()?;
        let stem = name.strip_prefix(&prefix)?.strip_suffix(&suffix)?;
        let mut numbers =
            stem.rsplit('.').next()?.split('_').map_while(|number| number.parse().ok());
        let version = [numbers.next()?, numbers.next()?, numbers.next()?];
        Some((Path::new(SHARED_MEMORY).join(&name), version))
    })
}

/// Returns a message if a file of another user, or one that is no segment, has the name of one of
/// this user's segments: iceoryx2 can't use it, and this user can't remove it.
fn obstacle() -> Option<String> {
    let prefix = config().ok()?.global.prefix.to_string();
    fs::read_dir(SHARED_MEMORY).ok()?.flatten().find_map(|entry| {
        let name = entry.file_name().into_string().ok()?;
        let metadata = entry.metadata().ok().filter(|_| name.starts_with(&prefix))?;
        let reason = foreignness(&metadata)?;
        let path = Path::new(SHARED_MEMORY).join(name);
        Some(format!("{} {reason}, and is in the way; {REMEDY}", path.display()))
    })
}

/// The remedy for a file of another user.
const REMEDY: &str = "remove it (as root, if it is another user's), or set REGATTA_RUNTIME_DIR to \
                      another directory of your own";

/// Returns the reason why a file can't be one of this user's segments.
#[cfg(unix)]
fn foreignness(metadata: &fs::Metadata) -> Option<String> {
    let owner = std::os::unix::fs::MetadataExt::uid(metadata);
    if owner != rustix::process::getuid().as_raw() {
        return Some(format!("belongs to user {owner}"));
    }
    (!metadata.is_file()).then(|| "is not a regular file".to_owned())
}

#[cfg(not(unix))]
fn foreignness(_metadata: &fs::Metadata) -> Option<String> {
    None
}

/// Takes the rights that others have to the segment away.
#[cfg(unix)]
pub(super) fn close_to_others() {
    use std::os::unix::fs::{MetadataExt, PermissionsExt};
    use std::sync::Once;

    static CLOSED: Once = Once::new();
    CLOSED.call_once(|| {
        let Some((path, _)) = segment() else { return };
        let is_open = path
            .symlink_metadata()
            .is_ok_and(|metadata| metadata.is_file() && metadata.mode() & 0o077 != 0);
        // Another user's can't be changed. It is that user's to close, in a directory that was
        // shared on purpose.
        if is_open && let Err(error) = fs::set_permissions(&path, fs::Permissions::from_mode(0o600))
        {
            tracing::debug!(%error, "closing {} to others", path.display());
        }
    });
}

#[cfg(not(unix))]
pub(super) fn close_to_others() {}

/// Returns a message if the segment is damaged, or something is in the way of this user's segments,
/// so that no process can join.
pub(super) fn damage() -> Option<String> {
    if let Some(obstacle) = obstacle() {
        return Some(obstacle);
    }
    let path = damaged()?;
    Some(format!("{} is damaged; `regatta doctor --clean` repairs it", path.display()))
}

/// Returns the segment, if it exists and iceoryx2 can't use it.
fn damaged() -> Option<PathBuf> {
    let (path, version) = segment()?;
    // A pipe would have no end, and a link may lead anywhere.
    let metadata = path.symlink_metadata().ok().filter(fs::Metadata::is_file)?;
    let is_long = metadata.len() > LENGTH as u64;
    let is_damaged = is_long || !is_intact(&fs::read(&path).ok()?, version);
    (is_ready(&path) && is_damaged).then_some(path)
}

/// Whether its creator has finished it. Until then, iceoryx2 gives no process the right to read it.
#[cfg(unix)]
fn is_ready(path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    path.symlink_metadata().is_ok_and(|metadata| metadata.mode() & 0o400 != 0)
}

#[cfg(not(unix))]
fn is_ready(_path: &Path) -> bool {
    true
}

/// Whether these are the contents of a segment of iceoryx2 of a version.
fn is_intact(bytes: &[u8], [major, minor, patch]: [u16; 3]) -> bool {
    let version = u64::from(major) << 32 | u64::from(minor) << 16 | u64::from(patch);
    bytes.len() == LENGTH && bytes[..8] == version.to_ne_bytes()
}

/// Removes a damaged segment, and returns whether there was one. The next process to join creates
/// another.
///
/// The counter in it makes the ids of nodes differ that are created within the same clock tick of
/// one process; so it is harmless that it starts anew.
pub(super) fn repair() -> bool {
    damaged().is_some_and(|path| fs::remove_file(path).is_ok())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_right_length_and_version_are_intact() {
        let mut bytes = [0_u8; LENGTH];
        bytes[..8].copy_from_slice(&0x000a_0000_u64.to_ne_bytes());
        assert!(is_intact(&bytes, [0, 10, 0]));
        assert!(!is_intact(&bytes, [0, 9, 0]));
        assert!(!is_intact(&bytes[..15], [0, 10, 0]));
        assert!(!is_intact(&[0; LENGTH], [0, 10, 0]));
    }
}
