//! The files of iceoryx2's shared memory, and their owners.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use super::{HealthError, SHARED_MEMORY, io_error};
use crate::process::domain::{SEGMENT_PREFIX, config};

/// The age above which a file can't belong to a process that is just starting.
const SETTLED: Duration = Duration::from_secs(10);

/// A shared-memory file.
pub(super) struct Segment {
    pub(super) path: PathBuf,
    /// The decimal numbers in its name: ids of the ports or of the service that it belongs to.
    pub(super) ids: Vec<u128>,
    pub(super) bytes: u64,
    /// Whether it is older than a process takes to start.
    pub(super) settled: bool,
}

pub(super) fn segments() -> Result<Vec<Segment>, HealthError> {
    let folder = Path::new(SHARED_MEMORY);
    let prefix = config()?.global.prefix.to_string();
    let mut segments = Vec::new();
    for entry in fs::read_dir(folder).map_err(io_error(folder))? {
        let entry = entry.map_err(io_error(folder))?;
        let name = entry.file_name().to_string_lossy().into_owned();
        // A file that has vanished since it was listed is skipped.
        let (true, Ok(metadata)) = (name.starts_with(&prefix), entry.metadata()) else { continue };
        segments.push(Segment {
            path: entry.path(),
            ids: ids(&name),
            bytes: allocated_bytes(&metadata),
            settled: is_settled(&metadata),
        });
    }
    Ok(segments)
}

/// Returns the size of this user's segments of other directories.
pub(super) fn bytes_elsewhere() -> Result<u64, HealthError> {
    let folder = Path::new(SHARED_MEMORY);
    let ours = config()?.global.prefix.to_string();
    let mut bytes = 0;
    for entry in fs::read_dir(folder).map_err(io_error(folder))?.flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        let (true, Ok(metadata)) = (name.starts_with(SEGMENT_PREFIX), entry.metadata()) else {
            continue;
        };
        if !name.starts_with(&ours) && is_own(&metadata) {
            bytes += allocated_bytes(&metadata);
        }
    }
    Ok(bytes)
}

/// Returns the memory that a file takes; its length may be more.
#[cfg(unix)]
fn allocated_bytes(metadata: &fs::Metadata) -> u64 {
    std::os::unix::fs::MetadataExt::blocks(metadata) * 512
}

#[cfg(not(unix))]
fn allocated_bytes(metadata: &fs::Metadata) -> u64 {
    metadata.len()
}

/// Whether a file belongs to this user.
#[cfg(unix)]
fn is_own(metadata: &fs::Metadata) -> bool {
    std::os::unix::fs::MetadataExt::uid(metadata) == rustix::process::getuid().as_raw()
}

#[cfg(not(unix))]
fn is_own(_metadata: &fs::Metadata) -> bool {
    true
}

/// Whether a file is older than a process takes to start.
pub(super) fn is_settled(metadata: &fs::Metadata) -> bool {
    age(metadata) > SETTLED
}

/// Returns the time since a file was changed last; zero if unknown.
pub(super) fn age(metadata: &fs::Metadata) -> Duration {
    let changed = metadata.modified().ok();
    changed.and_then(|time| SystemTime::now().duration_since(time).ok()).unwrap_or_default()
}

/// Returns the ids in a file's name. Ids have more than twenty digits; shorter numbers are versions
/// and counts.
pub(super) fn ids(name: &str) -> Vec<u128> {
    let parts = name.split(['_', '.']).filter(|part| part.len() > 20);
    parts.filter_map(|part| part.parse().ok()).collect()
}

/// Returns the ids of a node's ports. iceoryx2 keeps each as an empty file in the node's folder.
pub(super) fn port_ids(node: u128) -> Vec<u128> {
    let Ok(config) = config() else { return Vec::new() };
    let folder = PathBuf::from(config.global.node_dir().to_string()).join(node.to_string());
    let Ok(entries) = fs::read_dir(folder) else { return Vec::new() };
    entries.flatten().flat_map(|entry| ids(&entry.file_name().to_string_lossy())).collect()
}

/// Returns the segments that some process has mapped, as far as this user may see.
pub(super) fn mapped_files() -> Vec<PathBuf> {
    let Ok(processes) = fs::read_dir("/proc") else { return Vec::new() };
    let maps = processes
        .flatten()
        .filter_map(|process| fs::read_to_string(process.path().join("maps")).ok());
    let mut files = Vec::new();
    for map in maps {
        files.extend(
            map.lines().filter_map(|line| Some(PathBuf::from(&line[line.find(SHARED_MEMORY)?..]))),
        );
    }
    files
}
