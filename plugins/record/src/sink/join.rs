//! Joins the files of a ring to one recording, without decompressing them.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use mcap::Summary;

use crate::mcap_file::RECORD_HEADER;
use crate::progress::Progress;
use crate::scan::complete_counts;
use crate::{reading, repair};

/// The size of the blocks in which files are appended, in bytes.
const BLOCK: u64 = 4 << 20;

/// The error of joining files.
#[derive(Debug, thiserror::Error)]
#[error("can't join {path} ({reason})")]
pub(super) struct JoinError {
    path: PathBuf,
    reason: io::Error,
}

/// Appends all files to the first one and renames it to `path`. Each file is removed as soon as its
/// content is in the first one. The files have the same channels. `progress` counts their blocks.
pub(super) fn join<'p>(
    path: &Path,
    mut parts: impl Iterator<Item = &'p Path>,
    progress: &AtomicU64,
) -> Result<(), JoinError> {
    let Some(first) = parts.next() else { return Ok(()) };
    let mut whole = Joined::open(first).map_err(|reason| failed(first, reason))?;
    for part in parts {
        if let Err(reason) = whole.append(part, progress).and_then(|()| whole.close()) {
            // The parts appended so far can be read, too.
            let _ = repair::close(&mut whole.file, &mut Progress::hidden());
            return Err(failed(part, reason));
        }
        fs::remove_file(part).map_err(|reason| failed(part, reason))?;
    }
    fs::rename(first, path).map_err(|reason| failed(path, reason))
}

fn failed(path: &Path, reason: io::Error) -> JoinError {
    JoinError { path: path.to_owned(), reason }
}

/// The file that others are appended to.
struct Joined {
    file: File,
    summary: Summary,
    /// The end of the messages.
    end: u64,
}

impl Joined {
    fn open(path: &Path) -> io::Result<Self> {
        let mut file = OpenOptions::new().read(true).write(true).open(path)?;
        let summary = summary(&mut file)?;
        let end = data_end(&summary);
        Ok(Self { file, summary, end })
    }

    /// Appends the chunks of another file, without its metadata, and its part of the index.
    fn append(&mut self, path: &Path, progress: &AtomicU64) -> io::Result<()> {
        let mut part = File::open(path)?;
        let other = summary(&mut part)?;
        let (from, to) = (data_start(&other), data_end(&other));
        self.file.set_len(self.end)?;
        self.file.seek(SeekFrom::Start(self.end))?;
        part.seek(SeekFrom::Start(from))?;
        copy(&mut part, to - from, &mut self.file, progress)?;
        for mut chunk in other.chunk_indexes {
            chunk.chunk_start_offset = chunk.chunk_start_offset - from + self.end;
            for offset in chunk.message_index_offsets.values_mut() {
                *offset = *offset - from + self.end;
            }
            self.summary.chunk_indexes.push(chunk);
        }
        for mut metadata in other.metadata_indexes {
            if (from..to).contains(&metadata.offset) {
                metadata.offset = metadata.offset - from + self.end;
                self.summary.metadata_indexes.push(metadata);
            }
        }
        self.summary.schemas.extend(other.schemas);
        self.summary.channels.extend(other.channels);
        let stats = self.summary.stats.get_or_insert_default();
        if let Some(other) = other.stats {
            stats.message_count += other.message_count;
            stats.message_start_time = stats.message_start_time.min(other.message_start_time);
            stats.message_end_time = stats.message_end_time.max(other.message_end_time);
            for (channel, count) in other.channel_message_counts {
                *stats.channel_message_counts.entry(channel).or_default() += count;
            }
        }
        self.end += to - from;
        Ok(())
    }

    /// Writes the index.
    fn close(&mut self) -> io::Result<()> {
        complete_counts(&mut self.summary);
        self.file.set_len(self.end)?;
        self.file.seek(SeekFrom::Start(self.end))?;
        self.file.write_all(&repair::index(&self.summary, self.end))
    }
}

/// Copies so many bytes in blocks.
fn copy(from: &mut File, bytes: u64, to: &mut File, progress: &AtomicU64) -> io::Result<()> {
    let mut left = bytes;
    while left > 0 {
        let block = left.min(BLOCK);
        if io::copy(&mut from.take(block), to)? < block {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        left -= block;
        progress.fetch_add(1, Ordering::Relaxed);
    }
    Ok(())
}

fn summary(file: &mut File) -> io::Result<Summary> {
    let reason = match reading::summary(file) {
        Ok(Some(summary)) => return Ok(summary),
        Ok(None) => "it was never closed".to_owned(),
        Err(error) => error.to_string(),
    };
    Err(io::Error::new(io::ErrorKind::InvalidData, reason))
}

/// Returns the offset of the first chunk.
fn data_start(summary: &Summary) -> u64 {
    summary.chunk_indexes.iter().map(|chunk| chunk.chunk_start_offset).min().unwrap_or(0)
}

/// Returns the offset after the last chunk, its indexes and the last metadata.
fn data_end(summary: &Summary) -> u64 {
    let chunks = summary
        .chunk_indexes
        .iter()
        .map(|chunk| chunk.chunk_start_offset + chunk.chunk_length + chunk.message_index_length);
    let metadata = summary.metadata_indexes.iter().map(|index| index.offset + index.length);
    chunks.chain(metadata).max().unwrap_or(RECORD_HEADER)
}
