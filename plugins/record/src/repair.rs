//! Closes a recording that was cut off, by a kill, a crash, or a full disk; leaves out what is damaged.

use std::collections::{BTreeSet, HashSet};
use std::fmt;
use std::fs::{File, OpenOptions};
use std::io::{self, Cursor, Seek, SeekFrom, Write};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::Duration;

use binrw::{BinWrite, BinWriterExt};
use mcap::records::{self, DataEnd, Footer, SummaryOffset, op};
use mcap::{MAGIC, Summary};

use crate::reading;
use crate::scan::{RECORD_HEADER, Scan, scan};
use crate::schema::Topic;

/// Why a recording can't be repaired.
#[derive(Debug, thiserror::Error)]
pub enum RepairError {
    /// It can't be opened, read or written.
    #[error("can't repair {path} ({reason})")]
    Io {
        /// The file.
        path: PathBuf,
        /// Why.
        reason: io::Error,
    },
    /// There is nothing in it to keep.
    #[error("{path} is no recording, not even the start of one ({reason})")]
    NoRecording {
        /// The file.
        path: PathBuf,
        /// Why.
        reason: io::Error,
    },
}

/// What a repair came to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Repair {
    /// Messages that the recording holds.
    pub messages: u64,
    /// In so many chunks.
    pub chunks: u32,
    /// Bytes after the last whole chunk that had to go.
    pub removed_bytes: u64,
    /// Chunks that had to go because the disk is full.
    pub removed_chunks: u32,
    /// Times of damaged chunks that had to go: from their first message to their last.
    pub lost: Vec<(Duration, Duration)>,
    /// Whether it has a world: readers know graph and robot types by it.
    pub has_world: bool,
    /// It was closed already, all of it is whole, and it has not been touched.
    pub was_closed: bool,
}

impl fmt::Display for Repair {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} messages in {} chunks", self.messages, self.chunks)?;
        if self.was_closed {
            return f.write_str("; it is closed and whole, nothing to repair");
        }
        write!(f, " kept, {} bytes after them removed", self.removed_bytes)?;
        let lost =
            self.lost.iter().map(|(from, to)| format!("{:.2} s to {:.2} s", from.as_secs_f64(), to.as_secs_f64()));
        if !self.lost.is_empty() {
            write!(f, "; damaged and lost: {}", lost.collect::<Vec<_>>().join(", "))?;
        }
        match self.removed_chunks {
            0 => {}
            chunks => write!(f, " ({chunks} chunks among them, because the disk is full)")?,
        }
        if self.has_world { Ok(()) } else { f.write_str("; the graph and the robot types are not in it") }
    }
}

/// Closes a recording in place, so that it ends after its last whole chunk. One that is closed is read through: if some
/// of it is damaged, all that is whole is kept.
///
/// # Errors
/// [`RepairError`]; then the file may be shorter, but what is whole in it is there.
pub fn repair(path: &Path) -> Result<Repair, RepairError> {
    let failed = |reason| RepairError::Io { path: path.to_owned(), reason };
    let mut file = OpenOptions::new().read(true).write(true).open(path).map_err(failed)?;
    if let Ok(Some(summary)) = reading::summary(&mut file) {
        return leave_out_damage(&mut file, &summary).map_err(failed);
    }
    close(&mut file).map_err(|reason| match reason.kind() {
        io::ErrorKind::InvalidData | io::ErrorKind::UnexpectedEof => {
            RepairError::NoRecording { path: path.to_owned(), reason }
        }
        _ => failed(reason),
    })
}

fn described(summary: &Summary) -> Repair {
    let (stats, world) = (summary.stats.as_ref(), Topic::World.name());
    Repair {
        messages: stats.map_or(0, |stats| stats.message_count),
        chunks: summary.chunk_indexes.len() as u32,
        removed_bytes: 0,
        removed_chunks: 0,
        lost: Vec::new(),
        has_world: stats.is_some_and(|stats| {
            let is_world = |id: &u16| summary.channels.get(id).is_some_and(|channel| channel.topic == world);
            stats.channel_message_counts.iter().any(|(id, count)| *count > 0 && is_world(id))
        }),
        was_closed: false,
    }
}

/// Reads a closed recording through, and takes what is damaged out of it.
fn leave_out_damage(file: &mut File, summary: &Summary) -> io::Result<Repair> {
    let chunks = summary.chunk_indexes.iter().map(|chunk| chunk.chunk_start_offset);
    let known = chunks.chain(summary.metadata_indexes.iter().map(|index| index.offset)).collect();
    let mut scan = scan(file, &known)?;
    let whole: HashSet<_> = scan.summary.chunk_indexes.iter().map(|chunk| chunk.chunk_start_offset).collect();
    let lost = lost(summary, &whole);
    if lost.is_empty() && scan.holes.is_empty() {
        return Ok(Repair { was_closed: true, ..described(summary) });
    }
    scan.holes.iter().try_for_each(|hole| hide(file, hole))?;
    scan.define(summary);
    file.set_len(scan.end)?;
    file.seek(SeekFrom::Start(scan.end))?;
    file.write_all(&tail(&scan))?;
    Ok(Repair { lost, ..described(&scan.summary) })
}

/// Times of the chunks that are not whole, neighbours together.
fn lost(summary: &Summary, whole: &HashSet<u64>) -> Vec<(Duration, Duration)> {
    let is_lost = |chunk: &records::ChunkIndex| !whole.contains(&chunk.chunk_start_offset);
    let mut chunks = summary.chunk_indexes.clone();
    chunks.sort_by_key(|chunk| chunk.chunk_start_offset);
    let groups = chunks.chunk_by(|a, b| is_lost(a) == is_lost(b)).filter(|group| is_lost(&group[0]));
    let span = |group: &[records::ChunkIndex]| {
        let from = group.iter().map(|chunk| chunk.message_start_time).min().unwrap_or(0);
        let to = group.iter().map(|chunk| chunk.message_end_time).max().unwrap_or(0);
        (Duration::from_nanos(from), Duration::from_nanos(to))
    };
    groups.map(span).collect()
}

/// Turns bytes into one record of a kind that every reader passes over.
fn hide(file: &mut File, hole: &Range<u64>) -> io::Result<()> {
    let Some(length) = (hole.end - hole.start).checked_sub(RECORD_HEADER) else { return Ok(()) };
    file.seek(SeekFrom::Start(hole.start))?;
    file.write_all(&[&[PRIVATE][..], &length.to_le_bytes()].concat())
}

/// An opcode that the format leaves to applications.
const PRIVATE: u8 = 0xf0;

/// Cuts a file after its last whole chunk and writes what closes a recording. On a full disk, chunks at the end make
/// room for it.
pub(crate) fn close(file: &mut File) -> io::Result<Repair> {
    let length = file.seek(SeekFrom::End(0))?;
    let mut removed_chunks = 0;
    loop {
        let scan = scan(file, &BTreeSet::new())?;
        let tail = tail(&scan);
        file.set_len(scan.end)?;
        file.seek(SeekFrom::Start(scan.end))?;
        let Err(error) = file.write_all(&tail) else {
            let removed_bytes = length.saturating_sub(scan.end);
            return Ok(Repair { removed_bytes, removed_chunks, ..described(&scan.summary) });
        };
        let last = scan.summary.chunk_indexes.last().ok_or(error)?;
        file.set_len(last.chunk_start_offset)?;
        removed_chunks += 1;
    }
}

/// All that comes after the last whole chunk: its indexes, the end of the data, the summary and the footer.
fn tail(scan: &Scan) -> Vec<u8> {
    let mut out = Tail { bytes: Vec::new(), start: scan.end };
    let mut chunks = scan.summary.chunk_indexes.clone();
    if let Some(chunk) = chunks.last_mut() {
        let start = out.position();
        for index in &scan.last_indexes {
            chunk.message_index_offsets.insert(index.channel_id, out.position());
            out.record(op::MESSAGE_INDEX, index, &[]);
        }
        chunk.message_index_length += out.position() - start;
    }
    out.record(op::DATA_END, &DataEnd::default(), &[]);
    let summary_start = out.position();
    let mut groups = Vec::new();
    let mut group = |out: &mut Tail, opcode: u8, write: &mut dyn FnMut(&mut Tail)| {
        let start = out.position();
        write(out);
        let length = out.position() - start;
        if length > 0 {
            groups.push(SummaryOffset { group_opcode: opcode, group_start: start, group_length: length });
        }
    };
    let summary = &scan.summary;
    group(&mut out, op::SCHEMA, &mut |out| out.schemas(summary));
    group(&mut out, op::CHANNEL, &mut |out| out.channels(summary));
    let stats = summary.stats.clone().unwrap_or_default();
    group(&mut out, op::STATISTICS, &mut |out| out.record(op::STATISTICS, &stats, &[]));
    group(&mut out, op::CHUNK_INDEX, &mut |out| {
        chunks.iter().for_each(|chunk| out.record(op::CHUNK_INDEX, chunk, &[]));
    });
    group(&mut out, op::METADATA_INDEX, &mut |out| {
        summary.metadata_indexes.iter().for_each(|index| out.record(op::METADATA_INDEX, index, &[]));
    });
    let summary_offset_start = out.position();
    groups.iter().for_each(|offset| out.record(op::SUMMARY_OFFSET, offset, &[]));
    // Sums of 0 mean that there are none.
    out.record(op::FOOTER, &Footer { summary_start, summary_offset_start, summary_crc: 0 }, &[]);
    out.bytes.extend_from_slice(MAGIC);
    out.bytes
}

/// The end of a file under construction.
struct Tail {
    bytes: Vec<u8>,
    /// Where in the file it starts.
    start: u64,
}

impl Tail {
    fn position(&self) -> u64 {
        self.start + self.bytes.len() as u64
    }

    fn record(&mut self, opcode: u8, body: &impl for<'a> BinWrite<Args<'a> = ()>, more: &[u8]) {
        let start = self.bytes.len();
        self.bytes.push(opcode);
        self.bytes.extend_from_slice(&[0; 8]);
        let mut cursor = Cursor::new(&mut self.bytes);
        cursor.set_position(start as u64 + RECORD_HEADER);
        cursor.write_le(body).expect("memory takes all");
        self.bytes.extend_from_slice(more);
        let length = (self.bytes.len() - start) as u64 - RECORD_HEADER;
        self.bytes[start + 1..start + RECORD_HEADER as usize].copy_from_slice(&length.to_le_bytes());
    }

    fn schemas(&mut self, summary: &Summary) {
        let mut schemas: Vec<_> = summary.schemas.values().collect();
        schemas.sort_by_key(|schema| schema.id);
        for schema in schemas {
            let header =
                records::SchemaHeader { id: schema.id, name: schema.name.clone(), encoding: schema.encoding.clone() };
            let data = [&(schema.data.len() as u32).to_le_bytes()[..], &schema.data].concat();
            self.record(op::SCHEMA, &header, &data);
        }
    }

    fn channels(&mut self, summary: &Summary) {
        let mut channels: Vec<_> = summary.channels.values().collect();
        channels.sort_by_key(|channel| channel.id);
        for channel in channels {
            let record = records::Channel {
                id: channel.id,
                schema_id: channel.schema.as_ref().map_or(0, |schema| schema.id),
                topic: channel.topic.clone(),
                message_encoding: channel.message_encoding.clone(),
                metadata: channel.metadata.clone(),
            };
            self.record(op::CHANNEL, &record, &[]);
        }
    }
}
