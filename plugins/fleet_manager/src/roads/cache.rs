//! A cache of computed roads, in files.
//!
//! To compute the roads of 122,000 edges takes seconds, and the result depends only on the shapes
//! of edges and robots. It is kept in a file named by a hash of them. A file is used only if it is
//! complete and has these shapes: it ends with a checksum of all before it.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use regatta_base::file;
use regatta_plugin::World;
use xxhash_rust::xxh3::{Xxh3, xxh3_128};

use super::Roads;

/// The version of the computation and of the file format.
const VERSION: u32 = 4;
const MAGIC: &[u8; 8] = b"rgtroads";
const CHECKSUM_BYTES: usize = 16;
/// The number of edges from which on roads are kept: those of fewer are computed fast enough.
const FEWEST_EDGES: usize = 10_000;
/// The largest number of files; the least recently used ones are removed.
const MOST_FILES: usize = 16;
const PREFIX: &str = "roads-";
/// The size of the largest file: roads of a million edges take a tenth of it.
const MAX_BYTES: u64 = 4 << 30;

/// The error of keeping roads in a file. The roads can be used all the same.
#[derive(Debug, thiserror::Error)]
#[error(
    "can't keep the roads in {} ({reason}); choose another folder with --cache, or use --no-cache",
    path.display()
)]
pub struct CacheError {
    path: PathBuf,
    reason: std::io::Error,
}

/// Returns the user's cache folder; `None` for a user without a home folder.
pub fn default_folder() -> Option<PathBuf> {
    use etcetera::BaseStrategy;
    Some(etcetera::choose_base_strategy().ok()?.cache_dir().join("regatta"))
}

impl Roads {
    /// As [`new`](Self::new), but takes the roads from the cache in a folder, or adds them to it,
    /// unless there are only few edges.
    ///
    /// # Errors
    /// Beside the roads, [`CacheError`] if they can't be kept.
    pub fn cached(world: &World<'_>, folder: &Path) -> (Self, Result<(), CacheError>) {
        if world.edges().len() < FEWEST_EDGES {
            return (Self::new(world), Ok(()));
        }
        Self::kept(world, folder)
    }

    fn kept(world: &World<'_>, folder: &Path) -> (Self, Result<(), CacheError>) {
        let key = key(world);
        let path = folder.join(format!("{PREFIX}{key:032x}.bin"));
        let bytes = file::read(&path, MAX_BYTES).ok();
        if let Some(roads) = bytes.and_then(|bytes| unpack(world, key, &bytes)) {
            // The time of the last use decides which files go; where it can't be set, that of the
            // first one does.
            let _ = File::options()
                .append(true)
                .open(&path)
                .and_then(|file| file.set_modified(SystemTime::now()));
            return (roads, Ok(()));
        }
        let roads = Self::new(world);
        let kept =
            keep(folder, &path, &pack(&roads, key)).map_err(|reason| CacheError { path, reason });
        (roads, kept)
    }
}

/// Keeps a file, and removes old ones.
fn keep(folder: &Path, path: &Path, bytes: &[u8]) -> std::io::Result<()> {
    fs::create_dir_all(folder)?;
    regatta_kit::whole_file::write(path, bytes)?;
    // Files that stay too long do no harm but for their size.
    let _ = forget_old(folder);
    Ok(())
}

fn forget_old(folder: &Path) -> std::io::Result<()> {
    let mut files: Vec<(SystemTime, PathBuf)> = Vec::new();
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        if entry.file_name().to_string_lossy().starts_with(PREFIX) {
            files.push((entry.metadata()?.modified()?, entry.path()));
        }
    }
    files.sort_unstable();
    let old = files.len().saturating_sub(MOST_FILES);
    for (_, path) in &files[..old] {
        fs::remove_file(path)?;
    }
    Ok(())
}

/// Returns a hash of everything that the roads depend on.
fn key(world: &World<'_>) -> u128 {
    let mut hash = Xxh3::new();
    let lengths =
        [world.nodes().len(), world.edges().len(), world.robot_types().len(), world.zones().len()];
    add(&mut hash, &[VERSION]);
    add(&mut hash, &lengths.map(|length| length as u32));
    for node in world.nodes() {
        add(&mut hash, &[node.x.to_bits(), node.y.to_bits(), node.level]);
    }
    for edge in world.edges() {
        add(&mut hash, &[edge.origin, edge.destination, edge.level]);
        add(&mut hash, &[edge.speed.to_bits(), edge.reverse_speed.to_bits()]);
        add(&mut hash, &[edge.orientation, edge.orientation_angle.to_bits(), edge.curves]);
        for point in world.curves(edge).iter().flat_map(|curve| curve.control_points) {
            add(&mut hash, &point.map(f32::to_bits));
        }
    }
    for zone in world.zones() {
        add(&mut hash, &[zone.rule, zone.capacity, zone.nodes, zone.edges]);
        add(&mut hash, world.zone_nodes(zone));
        add(&mut hash, world.zone_edges(zone));
    }
    for class in world.robot_types() {
        let sizes = [class.length, class.width, class.max_rotation_speed];
        add(&mut hash, &[class.shape]);
        add(&mut hash, &sizes.map(f32::to_bits));
    }
    hash.digest128()
}

fn add(hash: &mut Xxh3, words: &[u32]) {
    for word in words {
        hash.update(&word.to_le_bytes());
    }
}

fn pack(roads: &Roads, key: u128) -> Vec<u8> {
    let mut writer = Writer::default();
    roads.write(&mut writer);
    let mut bytes = MAGIC.to_vec();
    bytes.extend(key.to_le_bytes());
    bytes.extend(writer.into_bytes());
    bytes.extend(xxh3_128(&bytes).to_le_bytes());
    bytes
}

/// Returns the roads of a world from the bytes of a file; `None` if they are damaged, or of
/// something else.
fn unpack(world: &World<'_>, key: u128, bytes: &[u8]) -> Option<Roads> {
    let (content, checksum) = bytes.split_last_chunk::<CHECKSUM_BYTES>()?;
    if xxh3_128(content) != u128::from_le_bytes(*checksum) {
        return None;
    }
    let content = content.strip_prefix(MAGIC)?.strip_prefix(&key.to_le_bytes())?;
    let mut reader = Reader::new(content);
    Roads::read(world, &mut reader).filter(|_| reader.is_at_end())
}

/// Writes numbers.
#[derive(Debug, Default)]
pub struct Writer(Vec<u8>);

impl Writer {
    /// Writes a list of numbers, with its length.
    pub fn list(&mut self, words: impl ExactSizeIterator<Item = u32>) {
        self.0.extend((words.len() as u32).to_le_bytes());
        for word in words {
            self.0.extend(word.to_le_bytes());
        }
    }

    /// Writes a list of numbers, with its length.
    pub fn floats(&mut self, floats: impl ExactSizeIterator<Item = f32>) {
        self.list(floats.map(f32::to_bits));
    }

    pub fn into_bytes(self) -> Vec<u8> {
        self.0
    }
}

/// Reads what a [`Writer`] has written.
#[derive(Clone, Debug)]
pub struct Reader<'a>(&'a [u8]);

impl<'a> Reader<'a> {
    pub fn new(bytes: &'a [u8]) -> Self {
        Self(bytes)
    }

    /// Reads a list; `None` if there are fewer numbers than it says.
    pub fn list(&mut self) -> Option<Vec<u32>> {
        let (length, rest) = self.0.split_first_chunk::<4>()?;
        let (list, rest) = rest.split_at_checked(4 * u32::from_le_bytes(*length) as usize)?;
        self.0 = rest;
        Some(
            list.chunks_exact(4)
                .map(|word| u32::from_le_bytes([word[0], word[1], word[2], word[3]]))
                .collect(),
        )
    }

    /// Reads a list of so many numbers.
    pub fn list_of(&mut self, length: usize) -> Option<Vec<u32>> {
        self.list().filter(|list| list.len() == length)
    }

    /// Reads a list of so many numbers.
    pub fn floats(&mut self, length: usize) -> Option<Vec<f32>> {
        Some(self.list_of(length)?.into_iter().map(f32::from_bits).collect())
    }

    /// Reads the start of each of so many parts of a list, and the end of the last one.
    pub fn starts(&mut self, parts: usize) -> Option<Vec<u32>> {
        self.list_of(parts + 1).filter(|starts| starts[0] == 0 && starts.is_sorted())
    }

    pub fn is_at_end(&self) -> bool {
        self.0.is_empty()
    }
}

#[cfg(test)]
mod tests;
