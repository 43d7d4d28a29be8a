//! Closes a recording that was cut off by a kill, a crash or a full disk, and removes damaged
//! chunks.

mod tail;

use std::collections::{BTreeSet, HashSet};
use std::fmt;
use std::fs::{File, OpenOptions};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::Duration;

use mcap::Summary;
use mcap::records::{ChunkIndex, op};

use crate::mcap_file::{RECORD_HEADER, RecordSpan};
use crate::output::Draft;
use crate::progress::Progress;
use crate::reading;
use crate::scan::scan;
use crate::schema::Topic;
pub(crate) use tail::index;
use tail::tail;

/// The error of repairing a recording.
#[derive(Debug, thiserror::Error)]
pub enum RepairError {
    /// The file can't be opened, read or written.
    #[error("can't repair {path} ({reason})")]
    Io {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        reason: io::Error,
    },
    /// The file has nothing to keep.
    #[error("{path} is not a recording, not even the start of one ({reason})")]
    NoRecording {
        /// The file.
        path: PathBuf,
        /// The reason why it isn't a recording.
        reason: io::Error,
    },
}

/// The result of a repair.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Repair {
    /// The number of messages in the repaired recording.
    pub messages: u64,
    /// The number of chunks in the repaired recording.
    pub chunks: u32,
    /// The number of bytes removed after the last complete chunk.
    pub removed_bytes: u64,
    /// The number of chunks removed because the disk is full.
    pub removed_chunks: u32,
    /// The time ranges of removed damaged chunks, from their first to their last message.
    pub lost: Vec<(Duration, Duration)>,
    /// Whether the recording has a world, which contains the graph and the robot types.
    pub has_world: bool,
    /// Whether the recording was already closed and undamaged, so that it wasn't changed.
    pub was_closed: bool,
}

impl fmt::Display for Repair {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} messages in {} chunks", self.messages, self.chunks)?;
        if self.was_closed {
            return f.write_str("; the recording is closed and undamaged, nothing to repair");
        }
        write!(f, " kept, {} bytes after them removed", self.removed_bytes)?;
        if self.removed_bytes == 0 && self.lost.is_empty() {
            f.write_str(", the index written anew")?;
        }
        for (i, (from, to)) in self.lost.iter().enumerate() {
            let separator = if i == 0 { "; damaged and lost: " } else { ", " };
            write!(f, "{separator}{:.2} s to {:.2} s", from.as_secs_f64(), to.as_secs_f64())?;
        }
        if self.removed_chunks > 0 {
            let chunks = self.removed_chunks;
            write!(f, " ({chunks} chunks among them, because the disk is full)")?;
        }
        if !self.has_world {
            f.write_str("; the graph and the robot types are not in it")?;
        }
        Ok(())
    }
}

/// Closes a recording in place, after its last complete chunk. From a recording that is already
/// closed, removes damaged chunks.
///
/// # Errors
/// Returns a [`RepairError`] if the file can't be read or written, or isn't a recording. The file
/// may then be shorter than before, but keeps its complete chunks.
pub fn repair(path: &Path) -> Result<Repair, RepairError> {
    // Opening a pipe to read and write it would succeed.
    open(path)?;
    let mut options = OpenOptions::new();
    let mut file =
        options.read(true).write(true).open(path).map_err(|error| failed(path, error))?;
    repair_file(&mut file, path)
}

fn open(path: &Path) -> Result<File, RepairError> {
    regatta_base::file::open(path, u64::MAX).map_err(|error| failed(path, error))
}

fn failed(path: &Path, reason: io::Error) -> RepairError {
    RepairError::Io { path: path.to_owned(), reason }
}

/// Writes a repaired copy of a recording, and leaves the recording as it is.
///
/// # Errors
/// Returns a [`RepairError`] as [`repair`], and also if the copy exists already and `force` is
/// false. Nothing is left of the copy then.
pub fn repair_copy(path: &Path, copy: &Path, force: bool) -> Result<Repair, RepairError> {
    let mut file = open(path)?;
    let (draft, mut repaired) = Draft::create(copy, force).map_err(|error| failed(copy, error))?;
    copy_all(&mut file, &mut repaired).map_err(|error| failed(copy, error))?;
    let repair = repair_file(&mut repaired, path)?;
    draft.commit().map_err(|error| failed(copy, error))?;
    Ok(repair)
}

/// The number of bytes copied between two reports of progress.
const COPY_BYTES: u64 = 64 << 20;

fn copy_all(from: &mut File, to: &mut File) -> io::Result<()> {
    let mut progress = Progress::start("copy");
    let (length, mut copied) = (from.metadata()?.len(), 0);
    while copied < length {
        let part = io::copy(&mut from.take(COPY_BYTES), to)?;
        if part == 0 {
            break;
        }
        copied += part;
        progress.report(copied as f64 / length as f64)?;
    }
    Ok(())
}

fn repair_file(file: &mut File, path: &Path) -> Result<Repair, RepairError> {
    let mut progress = Progress::start("repair");
    if let Ok(Some(summary)) = reading::summary(file) {
        return remove_damage(file, &summary, &mut progress).map_err(|error| failed(path, error));
    }
    close(file, &mut progress).map_err(|reason| match reason.kind() {
        io::ErrorKind::InvalidData | io::ErrorKind::UnexpectedEof => {
            RepairError::NoRecording { path: path.to_owned(), reason }
        }
        _ => failed(path, reason),
    })
}

/// Returns the result of a repair that kept the contents of `summary` and removed nothing.
fn repair_of(summary: &Summary) -> Repair {
    let stats = summary.stats.clone().unwrap_or_default();
    let world = Topic::World.name();
    let mut has_world = false;
    for (channel, count) in &stats.channel_message_counts {
        let topic = summary.channels.get(channel).map(|channel| &channel.topic);
        has_world |= *count > 0 && topic == Some(&world);
    }
    Repair {
        messages: stats.message_count,
        chunks: summary.chunk_indexes.len() as u32,
        removed_bytes: 0,
        removed_chunks: 0,
        lost: Vec::new(),
        has_world,
        was_closed: false,
    }
}

/// Scans a closed recording and removes its damaged chunks.
fn remove_damage(
    file: &mut File,
    summary: &Summary,
    progress: &mut Progress,
) -> io::Result<Repair> {
    let record_starts = record_starts(file, summary);
    let mut scan = scan(file, &record_starts, progress)?;
    let undamaged: HashSet<_> =
        scan.summary.chunk_indexes.iter().map(|chunk| chunk.chunk_start_offset).collect();
    let lost = lost(summary, &undamaged);
    if lost.is_empty() && scan.damage.is_empty() && describes(summary, &scan.summary) {
        return Ok(Repair { was_closed: true, ..repair_of(summary) });
    }
    for damage in &scan.damage {
        hide(file, damage)?;
    }
    scan.add_definitions(summary);
    file.set_len(scan.end)?;
    file.seek(SeekFrom::Start(scan.end))?;
    file.write_all(&tail(&scan))?;
    Ok(Repair { lost, ..repair_of(&scan.summary) })
}

/// The offsets of the chunks and metadata of a summary at which such a record starts.
fn record_starts(file: &mut File, summary: &Summary) -> BTreeSet<u64> {
    let chunks = summary.chunk_indexes.iter().map(|chunk| (chunk.chunk_start_offset, op::CHUNK));
    let metadata = summary.metadata_indexes.iter().map(|index| (index.offset, op::METADATA));
    let mut starts = BTreeSet::new();
    for (start, opcode) in chunks.chain(metadata) {
        let record = RecordSpan::read(file, start, u64::MAX);
        if record.is_ok_and(|record| record.is_some_and(|record| record.opcode == opcode)) {
            starts.insert(start);
        }
    }
    starts
}

/// Whether the summary of a closed recording describes its undamaged contents, which were scanned.
/// The scan may leave out where the messages of a chunk are.
fn describes(summary: &Summary, scanned: &Summary) -> bool {
    let mut chunks: Vec<_> = summary.chunk_indexes.iter().collect();
    chunks.sort_by_key(|chunk| chunk.chunk_start_offset);
    chunks.len() == scanned.chunk_indexes.len()
        && chunks
            .into_iter()
            .zip(&scanned.chunk_indexes)
            .all(|pair| describes_chunk(pair.0, pair.1))
        && summary.metadata_indexes == scanned.metadata_indexes
        && scanned.channels.iter().all(|(id, channel)| summary.channels.get(id) == Some(channel))
}

fn describes_chunk(index: &ChunkIndex, scanned: &ChunkIndex) -> bool {
    let mut index = index.clone();
    if scanned.message_index_offsets.is_empty() {
        index.message_index_offsets.clear();
        index.message_index_length = scanned.message_index_length;
    }
    index == *scanned
}

/// Returns the time ranges of the damaged chunks. Adjacent chunks share a range.
fn lost(summary: &Summary, undamaged: &HashSet<u64>) -> Vec<(Duration, Duration)> {
    let mut chunks: Vec<_> = summary.chunk_indexes.iter().collect();
    chunks.sort_by_key(|chunk| chunk.chunk_start_offset);
    let mut lost: Vec<(Duration, Duration)> = Vec::new();
    let mut was_lost = false;
    for chunk in chunks {
        let is_lost = !undamaged.contains(&chunk.chunk_start_offset);
        let start = Duration::from_nanos(chunk.message_start_time);
        let end = Duration::from_nanos(chunk.message_end_time);
        match lost.last_mut() {
            Some((from, to)) if is_lost && was_lost => {
                (*from, *to) = (start.min(*from), end.max(*to));
            }
            _ if is_lost => lost.push((start, end)),
            _ => {}
        }
        was_lost = is_lost;
    }
    lost
}

/// Turns a range of bytes into one private record, which readers skip.
fn hide(file: &mut File, range: &Range<u64>) -> io::Result<()> {
    let Some(length) = (range.end - range.start).checked_sub(RECORD_HEADER) else { return Ok(()) };
    file.seek(SeekFrom::Start(range.start))?;
    file.write_all(&[&[PRIVATE][..], &length.to_le_bytes()].concat())
}

/// An opcode that the MCAP format reserves for applications.
const PRIVATE: u8 = 0xf0;

/// Truncates a file after its last complete chunk and closes the recording. On a full disk, chunks
/// at the end are removed until there is room for the tail.
pub(crate) fn close(file: &mut File, progress: &mut Progress) -> io::Result<Repair> {
    let length = file.seek(SeekFrom::End(0))?;
    let mut removed_chunks = 0;
    loop {
        let scan = scan(file, &BTreeSet::new(), progress)?;
        let tail = tail(&scan);
        file.set_len(scan.end)?;
        file.seek(SeekFrom::Start(scan.end))?;
        let Err(error) = file.write_all(&tail) else {
            let removed_bytes = length.saturating_sub(scan.end);
            return Ok(Repair { removed_bytes, removed_chunks, ..repair_of(&scan.summary) });
        };
        let last = scan.summary.chunk_indexes.last().ok_or(error)?;
        file.set_len(last.chunk_start_offset)?;
        removed_chunks += 1;
    }
}

#[cfg(test)]
mod tests;
