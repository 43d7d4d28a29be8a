//! The state of shared memory on this machine: for `regatta doctor`, and for tests that nothing is
//! left behind.

mod remnants;
mod segments;

use std::collections::BTreeMap;
use std::fs;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::time::Duration;

use iceoryx2::node::NodeView;
use iceoryx2::prelude::*;

pub use super::domain::SHARED_MEMORY;
use super::domain::{self, DomainError, config};
use super::management;
use crate::ports::services;
use crate::records::name::FleetName;
use crate::transport::shared::{self, Ipc};
use segments::{Segment, mapped_files, port_ids, segments};

/// The error of inspecting shared memory.
#[derive(Debug, thiserror::Error)]
pub enum HealthError {
    /// A folder or file can't be read.
    #[error("can't read {path} ({source})")]
    Io {
        /// The folder or file.
        path: PathBuf,
        /// The reason.
        source: io::Error,
    },
    /// This user has no directory for the files of shared memory.
    #[error(transparent)]
    Domain(#[from] DomainError),
    /// iceoryx2 can't list its nodes or services.
    #[error("iceoryx2 can't list {what} ({reason})")]
    List {
        /// The resource that was to be listed.
        what: &'static str,
        /// iceoryx2's reason.
        reason: String,
    },
}

/// The amount of shared memory, in bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Space {
    /// The size of shared memory.
    pub total: u64,
    /// The part that this user can still allocate.
    pub available: u64,
}

/// A process that uses shared memory: a node of iceoryx2.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Occupant {
    /// `regatta/F/NAME` for one of ours.
    pub name: String,
    /// The program.
    pub executable: String,
    /// The process id; 0 if unknown.
    pub pid: u32,
    /// Whether it still runs.
    pub alive: bool,
    /// The size of its segments, in bytes.
    pub bytes: u64,
}

/// A segment that no process owns, which happens when files of a dead process were removed by hand.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Orphan {
    /// The file.
    pub path: PathBuf,
    /// Its size, in bytes.
    pub bytes: u64,
}

/// The result of [`clean`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cleaned {
    /// The number of dead processes whose resources were removed.
    pub occupants: usize,
    /// The number of dead processes whose resources can't be removed, because they are another
    /// user's, for example.
    pub failed: usize,
    /// The number of orphaned files that were removed.
    pub orphans: usize,
    /// The freed memory, in bytes.
    pub bytes: u64,
    /// Whether iceoryx2's management segment was damaged, and is removed now.
    pub repaired: bool,
}

/// Makes this process leave the resources of dead processes alone, except in [`clean`]. By default,
/// each process that joins a fleet removes them. To be called before anything else of this crate.
pub fn look_only() {
    domain::look_only();
}

/// Returns the directory of iceoryx2's files, and the beginning of the names of its segments.
///
/// # Errors
/// [`HealthError::Domain`] if this user has none.
pub fn location() -> Result<(String, String), HealthError> {
    let global = &config()?.global;
    Ok((global.root_path().to_string(), global.prefix.to_string()))
}

/// Returns the damage of iceoryx2's management segment, if there is any: no process can join a
/// fleet then.
pub fn damage() -> Option<String> {
    management::damage()
}

/// Returns the size, in bytes, of this user's segments that belong to another directory than the
/// current one: one of a container, for example, or one that was deleted.
///
/// # Errors
/// [`HealthError`] if segments can't be listed.
pub fn bytes_elsewhere() -> Result<u64, HealthError> {
    segments::bytes_elsewhere()
}

/// Returns the amount of shared memory.
///
/// # Errors
/// [`HealthError::Io`] if there is none.
#[cfg(unix)]
pub fn space() -> Result<Space, HealthError> {
    let stat = rustix::fs::statvfs(SHARED_MEMORY)
        .map_err(|e| io_error(Path::new(SHARED_MEMORY))(e.into()))?;
    Ok(Space { total: stat.f_blocks * stat.f_frsize, available: stat.f_bavail * stat.f_frsize })
}

/// Returns the amount of shared memory.
///
/// # Errors
/// [`HealthError::Io`]: this system doesn't say.
#[cfg(not(unix))]
pub fn space() -> Result<Space, HealthError> {
    Err(io_error(Path::new(SHARED_MEMORY))(io::ErrorKind::Unsupported.into()))
}

/// The size of the segment by which rights are checked.
const SAMPLE_BYTES: usize = 4096;

/// Checks that this user may create segments: creates one of 4 KiB and removes it.
///
/// # Errors
/// [`HealthError::Io`] if not.
pub fn check_rights() -> Result<(), HealthError> {
    // It has no name, or a random one that is removed at once: nothing that lies there is written to.
    let folder = Path::new(SHARED_MEMORY);
    let written =
        tempfile::tempfile_in(folder).and_then(|mut file| file.write_all(&[1; SAMPLE_BYTES]));
    written.map_err(io_error(folder))
}

/// Returns all processes that use shared memory, dead ones included, sorted by name.
///
/// ```
/// # fn main() -> regatta_plugin::Result {
/// for occupant in regatta_plugin::health::occupants()? {
///     println!("{} (process {}): {} bytes", occupant.name, occupant.pid, occupant.bytes);
/// }
/// # Ok(())
/// # }
/// ```
///
/// # Errors
/// [`HealthError`] if they can't be listed.
pub fn occupants() -> Result<Vec<Occupant>, HealthError> {
    let segments = segments()?;
    let mut occupants = Vec::new();
    each_node(|node| {
        let ids = port_ids(node.node_id().value());
        let bytes = segments
            .iter()
            .filter(|s| s.ids.iter().any(|id| ids.contains(id)))
            .map(|s| s.bytes)
            .sum();
        occupants.push(occupant(&node, bytes));
    })?;
    occupants.sort_by(|a, b| (&a.name, a.pid).cmp(&(&b.name, b.pid)));
    Ok(occupants)
}

/// Returns the segments that belong to no process, alive or dead, and that no process of this user
/// has mapped.
///
/// # Errors
/// [`HealthError`] if segments can't be listed.
pub fn orphans() -> Result<Vec<Orphan>, HealthError> {
    let mut owned = service_ids()?;
    each_node(|node| owned.extend(port_ids(node.node_id().value())))?;
    let mapped = mapped_files();
    let mut orphans = Vec::new();
    for Segment { path, ids, bytes, settled } in segments()? {
        let is_owned = ids.is_empty() || ids.iter().any(|id| owned.contains(id));
        if settled && !is_owned && !mapped.contains(&path) {
            orphans.push(Orphan { path, bytes });
        }
    }
    Ok(orphans)
}

/// Removes unfinished segments and files of services, for which a process would wait for ever.
pub(crate) fn remove_unfinished() {
    remnants::remove_unfinished();
}

/// Removes the file of a service that no process has open, and that none can open.
pub(crate) fn remove_abandoned(service: &str) {
    remnants::remove_abandoned(service);
}

/// Removes the resources of dead processes, and orphaned segments.
///
/// # Errors
/// [`HealthError`] if they can't be listed. Those that can't be removed are counted.
pub fn clean() -> Result<Cleaned, HealthError> {
    let before: u64 = segments()?.iter().map(|s| s.bytes).sum();
    let mut cleaned = Cleaned { repaired: management::repair(), ..Cleaned::default() };
    remnants::remove_unfinished();
    let dead = remnants::dead_nodes()?;
    each_node(|node| {
        if let NodeState::Dead(dead) = node
            && let Err(error) = dead.blocking_remove_stale_resources(Duration::from_secs(1))
        {
            tracing::debug!(%error, "cleaning up after a dead process");
        }
    })?;
    remnants::remove(&remnants::dead_nodes()?);
    cleaned.failed = remnants::dead_nodes()?.len();
    cleaned.occupants = dead.len().saturating_sub(cleaned.failed);
    for orphan in orphans()? {
        cleaned.orphans += usize::from(fs::remove_file(&orphan.path).is_ok());
    }
    cleaned.bytes = before.saturating_sub(segments()?.iter().map(|s| s.bytes).sum());
    Ok(cleaned)
}

/// Returns the names of a fleet's services that a process, alive or dead, has open.
///
/// # Errors
/// [`HealthError::List`] if services can't be listed.
pub fn services_of(fleet: &FleetName) -> Result<Vec<String>, HealthError> {
    let prefix = services::service_name(fleet, "");
    let mut names = Vec::new();
    each_service(|service| {
        let name = service.static_details.name().as_str();
        if name.starts_with(&prefix) {
            names.push(name.to_owned());
        }
    })?;
    names.sort();
    Ok(names)
}

/// Returns the number of open services by contract version, which is `unknown` for a service of
/// Regatta's without one.
///
/// # Errors
/// [`HealthError::List`] if services can't be listed.
pub fn versions() -> Result<BTreeMap<String, usize>, HealthError> {
    let mut versions = BTreeMap::new();
    each_service(|service| {
        if service.static_details.name().as_str().starts_with("regatta/") {
            *versions.entry(shared::version_of(&service.static_details)).or_insert(0) += 1;
        }
    })?;
    Ok(versions)
}

fn service_ids() -> Result<Vec<u128>, HealthError> {
    let mut owned = Vec::new();
    each_service(|service| owned.push(service.static_details.unique_service_id().value()))?;
    Ok(owned)
}

fn occupant(node: &NodeState<Ipc>, bytes: u64) -> Occupant {
    let (details, alive) = match node {
        NodeState::Alive(view) => (view.details().as_ref(), true),
        NodeState::Dead(view) => (view.details().as_ref(), false),
        // Another user's node, whose state is unknown.
        NodeState::Inaccessible(_) | NodeState::Undefined(_) => (None, true),
    };
    Occupant {
        name: details.map_or_else(String::new, |d| d.name().as_str().to_owned()),
        executable: details.map_or_else(String::new, |d| d.executable().to_string()),
        pid: details.map_or(0, |d| d.process_id().value() as u32),
        alive,
        bytes,
    }
}

fn each_node(mut each: impl FnMut(NodeState<Ipc>)) -> Result<(), HealthError> {
    Node::<Ipc>::list(config()?, |node| {
        each(node);
        CallbackProgression::Continue
    })
    .map_err(|e| HealthError::List { what: "processes", reason: e.to_string() })
}

fn each_service(mut each: impl FnMut(ServiceDetails<Ipc>)) -> Result<(), HealthError> {
    Ipc::list(config()?, |service| {
        each(service);
        CallbackProgression::Continue
    })
    .map_err(|e| HealthError::List { what: "services", reason: e.to_string() })
}

fn io_error(path: &Path) -> impl Fn(io::Error) -> HealthError {
    let path = path.to_owned();
    move |source| HealthError::Io { path: path.clone(), source }
}
