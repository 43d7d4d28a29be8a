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
use mcap::records::ChunkIndex;

use crate::mcap_record::RECORD_HEADER;
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
        let lost = self
            .lost
            .iter()
            .map(|(from, to)| format!("{:.2} s to {:.2} s", from.as_secs_f64(), to.as_secs_f64()));
        if !self.lost.is_empty() {
            write!(f, "; damaged and lost: {}", lost.collect::<Vec<_>>().join(", "))?;
        }
        match self.removed_chunks {
            0 => {}
            chunks => write!(f, " ({chunks} chunks among them, because the disk is full)")?,
        }
        if self.has_world {
            Ok(())
        } else {
            f.write_str("; the graph and the robot types are not in it")
        }
    }
}

/// Closes a recording in place, after its last complete chunk. From a recording that is already
/// closed, removes damaged chunks.
///
/// # Errors
/// Returns a [`RepairError`] if the file can't be read or written, or isn't a recording. The file
/// may then be shorter than before, but keeps its complete chunks.
pub fn repair(path: &Path) -> Result<Repair, RepairError> {
    let failed = |reason| RepairError::Io { path: path.to_owned(), reason };
    let mut file = OpenOptions::new().read(true).write(true).open(path).map_err(failed)?;
    repair_file(&mut file, path)
}

/// Writes a repaired copy of a recording, and leaves the recording as it is.
///
/// # Errors
/// Returns a [`RepairError`] as [`repair`], and also if the copy exists already and `force` is
/// false. Nothing is left of the copy then.
pub fn repair_copy(path: &Path, copy: &Path, force: bool) -> Result<Repair, RepairError> {
    let failed = |path: &Path| {
        let path = path.to_owned();
        move |reason| RepairError::Io { path, reason }
    };
    let mut file = File::open(path).map_err(failed(path))?;
    let (draft, mut repaired) = Draft::create(copy, force).map_err(failed(copy))?;
    copy_all(&mut file, &mut repaired).map_err(failed(copy))?;
    let repair = repair_file(&mut repaired, path)?;
    draft.commit().map_err(failed(copy))?;
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
    let failed = |reason| RepairError::Io { path: path.to_owned(), reason };
    let mut progress = Progress::start("repair");
    let mut report = |done| progress.report(done).map_err(Into::into);
    if let Ok(Some(summary)) = reading::summary(file) {
        return remove_damage(file, &summary, &mut report).map_err(failed);
    }
    close_reporting(file, &mut report).map_err(|reason| match reason.kind() {
        io::ErrorKind::InvalidData | io::ErrorKind::UnexpectedEof => {
            RepairError::NoRecording { path: path.to_owned(), reason }
        }
        _ => failed(reason),
    })
}

/// Returns the result of a repair that kept what `summary` describes and removed nothing.
fn repair_of(summary: &Summary) -> Repair {
    let (stats, world) = (summary.stats.as_ref(), Topic::World.name());
    Repair {
        messages: stats.map_or(0, |stats| stats.message_count),
        chunks: summary.chunk_indexes.len() as u32,
        removed_bytes: 0,
        removed_chunks: 0,
        lost: Vec::new(),
        has_world: stats.is_some_and(|stats| {
            let is_world =
                |id: &u16| summary.channels.get(id).is_some_and(|channel| channel.topic == world);
            stats.channel_message_counts.iter().any(|(id, count)| *count > 0 && is_world(id))
        }),
        was_closed: false,
    }
}

/// Scans a closed recording and removes its damaged chunks.
fn remove_damage(
    file: &mut File,
    summary: &Summary,
    report: &mut Report<'_>,
) -> io::Result<Repair> {
    let chunks = summary.chunk_indexes.iter().map(|chunk| chunk.chunk_start_offset);
    let record_starts =
        chunks.chain(summary.metadata_indexes.iter().map(|index| index.offset)).collect();
    let mut scan = scan(file, &record_starts, report)?;
    let undamaged: HashSet<_> =
        scan.summary.chunk_indexes.iter().map(|chunk| chunk.chunk_start_offset).collect();
    let lost = lost(summary, &undamaged);
    if lost.is_empty() && scan.damage.is_empty() {
        return Ok(Repair { was_closed: true, ..repair_of(summary) });
    }
    scan.damage.iter().try_for_each(|damage| hide(file, damage))?;
    scan.add_definitions(summary);
    file.set_len(scan.end)?;
    file.seek(SeekFrom::Start(scan.end))?;
    file.write_all(&tail(&scan))?;
    Ok(Repair { lost, ..repair_of(&scan.summary) })
}

/// Returns the time ranges of the damaged chunks. Adjacent chunks share a range.
fn lost(summary: &Summary, undamaged: &HashSet<u64>) -> Vec<(Duration, Duration)> {
    let is_lost = |chunk: &ChunkIndex| !undamaged.contains(&chunk.chunk_start_offset);
    let mut chunks = summary.chunk_indexes.clone();
    chunks.sort_by_key(|chunk| chunk.chunk_start_offset);
    let groups =
        chunks.chunk_by(|a, b| is_lost(a) == is_lost(b)).filter(|group| is_lost(&group[0]));
    let span = |group: &[ChunkIndex]| {
        let from = group.iter().map(|chunk| chunk.message_start_time).min().unwrap_or(0);
        let to = group.iter().map(|chunk| chunk.message_end_time).max().unwrap_or(0);
        (Duration::from_nanos(from), Duration::from_nanos(to))
    };
    groups.map(span).collect()
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
pub(crate) fn close(file: &mut File) -> io::Result<Repair> {
    close_reporting(file, &mut |_| Ok(()))
}

/// Takes the part of a task that is done, from 0 to 1. An error ends the task.
type Report<'r> = dyn FnMut(f64) -> io::Result<()> + 'r;

fn close_reporting(file: &mut File, report: &mut Report<'_>) -> io::Result<Repair> {
    let length = file.seek(SeekFrom::End(0))?;
    let mut removed_chunks = 0;
    loop {
        let scan = scan(file, &BTreeSet::new(), report)?;
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
