//! Files of nodes that iceoryx2 leaves behind: those of processes that were killed while they
//! joined or left.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

use iceoryx2::node::NodeState;

use super::segments::{age, ids, is_settled};
use super::{HealthError, each_node};
use crate::process::domain::{SHARED_MEMORY, config};

/// Much longer than a segment or the file of a service is unfinished while it is created.
const CREATION: Duration = Duration::from_secs(1);

/// Returns the files and folders of dead nodes, by the node's id: of those that iceoryx2 knows to
/// be dead, and of those that it doesn't know, if they are older than a process takes to join.
pub(super) fn dead_nodes() -> Result<BTreeMap<u128, Vec<PathBuf>>, HealthError> {
    let folder = PathBuf::from(config()?.global.node_dir().to_string());
    let (mut dead, mut living) = (BTreeMap::new(), BTreeSet::new());
    each_node(|node| match node {
        NodeState::Dead(_) => {
            dead.insert(node.node_id().value(), Vec::new());
        }
        NodeState::Alive(_) | NodeState::Inaccessible(_) => {
            living.insert(node.node_id().value());
        }
        NodeState::Undefined(_) => {}
    })?;
    // Before any process has joined, there is no folder.
    for entry in fs::read_dir(&folder).into_iter().flatten().flatten() {
        let Some(id) = ids(&entry.file_name().to_string_lossy()).last().copied() else { continue };
        if !dead.contains_key(&id) && !entry.metadata().is_ok_and(|metadata| is_settled(&metadata))
        {
            living.insert(id);
        }
        if !living.contains(&id) {
            dead.entry(id).or_default().push(entry.path());
        }
    }
    dead.retain(|id, _| !living.contains(id));
    Ok(dead)
}

/// Removes the files of dead nodes, except for nodes of which some process has a file open.
pub(super) fn remove(nodes: &BTreeMap<u128, Vec<PathBuf>>) {
    if nodes.is_empty() {
        return;
    }
    let open = open_files();
    for paths in nodes.values().filter(|paths| !paths.iter().any(|path| open.contains(path))) {
        let (folders, files): (Vec<_>, Vec<_>) = paths.iter().partition(|path| path.is_dir());
        // A file that can't be removed stays, and is counted.
        for folder in folders {
            let _ = fs::remove_dir_all(folder);
        }
        for file in files {
            let _ = fs::remove_file(file);
        }
    }
}

/// Removes the segments and the files of services whose creator was killed before it finished them.
/// A process that opens one waits for its creator, for ever or until it gives up (a fault of
/// iceoryx2 0.10), until it is removed.
pub(super) fn remove_unfinished() {
    let Ok(config) = config() else { return };
    let services = config.global.service_dir().to_string();
    if old_files(Path::new(SHARED_MEMORY), is_unfinished_segment).is_empty()
        && old_files(Path::new(&services), is_unfinished_service).is_empty()
    {
        return;
    }
    let _others_wait = lock();
    let mut unfinished = old_files(Path::new(SHARED_MEMORY), is_unfinished_segment);
    unfinished.extend(old_files(Path::new(&services), is_unfinished_service));
    remove_files(unfinished);
}

/// Removes the finished file of a service that can't be opened, if no process has it open: the last
/// one that used the service was killed before it removed the file (iceoryx2 0.10 forgets the
/// process first, so that no other one removes it), or the creator was before it created the rest.
pub(super) fn remove_abandoned(service: &str) {
    // Only there is it known which files are open.
    if !cfg!(target_os = "linux") {
        return;
    }
    let Ok(config) = config() else { return };
    let _others_wait = lock();
    let services = config.global.service_dir().to_string();
    let mut abandoned = old_files(Path::new(&services), is_finished_service);
    let line = format!("service_name = \"{service}\"");
    abandoned.retain(|path| {
        fs::read_to_string(path).is_ok_and(|text| text.lines().any(|named| named == line))
    });
    remove_files(abandoned);
}

/// Lets one process at a time remove files: another one could remove a file that a third process
/// has created anew under the same name. Without a lock, the file's age has to suffice.
fn lock() -> Option<fs::File> {
    let folder = fs::File::open(config().ok()?.global.root_path().to_string()).ok()?;
    folder.lock().ok().map(|()| folder)
}

/// Removes files, except those that some process has open.
fn remove_files(files: Vec<PathBuf>) {
    if files.is_empty() {
        return;
    }
    let open = open_files();
    for path in files.iter().filter(|path| !open.contains(*path)) {
        // One of another user stays.
        let _ = fs::remove_file(path);
    }
}

/// Returns this user's files in a folder that are in a state for so long that their creator isn't
/// about to change it.
fn old_files(folder: &Path, is_in_state: fn(&fs::Metadata) -> bool) -> Vec<PathBuf> {
    let Ok(config) = config() else { return Vec::new() };
    let prefix = config.global.prefix.to_string();
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let own = entries.filter(|entry| entry.file_name().to_string_lossy().starts_with(&prefix));
    own.filter(|entry| {
        let metadata = entry.metadata().ok().filter(fs::Metadata::is_file);
        metadata.is_some_and(|metadata| is_in_state(&metadata) && age(&metadata) > CREATION)
    })
    .map(|entry| entry.path())
    .collect()
}

/// The file of a service that can't be written to any more.
fn is_finished_service(metadata: &fs::Metadata) -> bool {
    !is_unfinished_service(metadata)
}

/// A segment gets a length first, and the right to be read last.
fn is_unfinished_segment(metadata: &fs::Metadata) -> bool {
    metadata.len() == 0 || mode(metadata) & 0o400 == 0
}

/// The file of a service can be written to until it is finished.
fn is_unfinished_service(metadata: &fs::Metadata) -> bool {
    mode(metadata) & 0o200 != 0
}

#[cfg(unix)]
fn mode(metadata: &fs::Metadata) -> u32 {
    std::os::unix::fs::MetadataExt::mode(metadata)
}

/// Elsewhere, files have no such rights: only their length tells.
#[cfg(not(unix))]
fn mode(_metadata: &fs::Metadata) -> u32 {
    0o400
}

/// Returns the files that some process has open, as far as this user may see.
fn open_files() -> BTreeSet<PathBuf> {
    let processes = fs::read_dir("/proc").into_iter().flatten().flatten();
    let folders =
        processes.filter_map(|process| fs::read_dir(Path::new(&process.path()).join("fd")).ok());
    folders
        .flatten()
        .flatten()
        .filter_map(|descriptor| fs::read_link(descriptor.path()).ok())
        .collect()
}
