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

/// Much longer than a segment has no length while it is created.
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

/// Removes segments whose creator was killed before it gave them a length. A process of root that
/// opens one waits for its creator for ever (a fault of iceoryx2 0.10), until it is removed.
pub(super) fn remove_unfinished() {
    let Ok(config) = config() else { return };
    let prefix = config.global.prefix.to_string();
    let mut unfinished = Vec::new();
    for entry in fs::read_dir(SHARED_MEMORY).into_iter().flatten().flatten() {
        if entry.file_name().to_string_lossy().starts_with(&prefix)
            && let Ok(metadata) = entry.metadata()
            && metadata.len() == 0
            && age(&metadata) > CREATION
        {
            unfinished.push(entry.path());
        }
    }
    if unfinished.is_empty() {
        return;
    }
    let open = open_files();
    for segment in unfinished.iter().filter(|segment| !open.contains(*segment)) {
        // One of another user stays.
        let _ = fs::remove_file(segment);
    }
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
