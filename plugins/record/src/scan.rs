//! Scans a recording from its start, for files that were never closed or are damaged.

mod chunk;

use std::collections::BTreeSet;
use std::io::{self, Read, Seek, SeekFrom};
use std::ops::Range;
use std::sync::Arc;

use mcap::records::{self, ChunkIndex, MessageIndex, MetadataIndex, Record, op};
use mcap::{Channel, MAGIC, McapError, McapResult, Summary, parse_record};

use crate::mcap_record::{MAX_RECORD, RECORD_HEADER, RecordSpan};
pub(crate) use chunk::ChunkContent;

/// The undamaged contents of a recording.
#[derive(Default)]
pub(crate) struct Scan {
    /// The summary of the undamaged contents.
    pub summary: Summary,
    /// The offset after the undamaged contents. Repairs write from here on.
    pub end: u64,
    /// The message indexes of the last chunk, if a repair has to write them again.
    pub last_indexes: Vec<MessageIndex>,
    /// The damaged bytes before `end`.
    pub damage: Vec<Range<u64>>,
}

/// Scans a recording. After damage it continues at the next of the offsets in `record_starts`;
/// without one, the damage ends the scan. Calls `report` with the part that is done, from 0 to 1.
///
/// # Errors
/// Returns an error of `report`, or an error if the file can't be read, doesn't start like an MCAP
/// file (`InvalidData`), or ends within its header (`UnexpectedEof`).
pub(crate) fn scan(
    file: &mut (impl Read + Seek),
    record_starts: &BTreeSet<u64>,
    report: &mut dyn FnMut(f64) -> io::Result<()>,
) -> io::Result<Scan> {
    let length = file.seek(SeekFrom::End(0))?;
    file.rewind()?;
    let mut magic = [0; MAGIC.len()];
    file.read_exact(&mut magic)?;
    if magic != *MAGIC {
        return Err(io::Error::new(
            io::ErrorKind::InvalidData,
            "it doesn't start like an MCAP file",
        ));
    }
    let mut scan = Scan::default();
    let mut end = MAGIC.len() as u64;
    loop {
        report(end as f64 / length.max(1) as f64)?;
        let next = record_starts.range(end + 1..).next().copied();
        let record = RecordSpan::read(file, end, next.unwrap_or(length).min(length))?;
        let record =
            record.filter(|record| is_data(record.opcode) && scan.add(file, record).is_ok());
        match (record, next) {
            (Some(record), _) => end = record.end(),
            (None, Some(next)) => {
                scan.skip(end..next);
                end = next;
            }
            (None, None) => break,
        }
    }
    match end == MAGIC.len() as u64 {
        true => Err(io::Error::new(io::ErrorKind::UnexpectedEof, "it ends within its header")),
        false => Ok(scan.finish(end)),
    }
}

/// Whether a record belongs to the data section of a file.
fn is_data(opcode: u8) -> bool {
    matches!(
        opcode,
        op::HEADER
            | op::SCHEMA
            | op::CHANNEL
            | op::MESSAGE
            | op::CHUNK
            | op::MESSAGE_INDEX
            | op::ATTACHMENT
            | op::METADATA
    ) || opcode >= 0x80
}

impl Scan {
    fn add(&mut self, file: &mut (impl Read + Seek), record: &RecordSpan) -> McapResult<()> {
        if record.opcode != op::MESSAGE_INDEX {
            self.last_indexes.clear();
        }
        match record.opcode {
            op::CHUNK => self.add_chunk(file, record),
            op::MESSAGE_INDEX => self.add_index(file, record),
            op::METADATA => {
                let content = record.read_content(file)?;
                let Record::Metadata(metadata) = parse_record(op::METADATA, &content)? else {
                    return Ok(());
                };
                let (offset, length) = (record.start, RECORD_HEADER + record.length);
                self.summary.metadata_indexes.push(MetadataIndex {
                    offset,
                    length,
                    name: metadata.name,
                });
                Ok(())
            }
            // After a damaged length, anything may look like a record.
            op::HEADER | op::SCHEMA | op::CHANNEL | op::MESSAGE => {
                let content = record.read_content(file)?;
                parse_record(record.opcode, &content).map(drop)
            }
            // Regatta writes no other records outside of chunks. Those of other programs are left
            // unchanged.
            _ => Ok(()),
        }
    }

    fn add_chunk(&mut self, file: &mut (impl Read + Seek), span: &RecordSpan) -> McapResult<()> {
        let length = usize::try_from(span.length).ok().filter(|length| *length <= MAX_RECORD);
        let length = length.ok_or(McapError::ChunkTooLarge(span.length))?;
        file.seek(SeekFrom::Start(span.start))?;
        let mut record = vec![0; RECORD_HEADER as usize + length];
        file.read_exact(&mut record)?;
        let Record::Chunk { header, .. } =
            parse_record(op::CHUNK, &record[RECORD_HEADER as usize..])?
        else {
            return Err(McapError::BadIndex);
        };
        let index = ChunkIndex {
            message_start_time: header.message_start_time,
            message_end_time: header.message_end_time,
            chunk_start_offset: span.start,
            chunk_length: RECORD_HEADER + span.length,
            message_index_offsets: Default::default(),
            message_index_length: 0,
            compression: header.compression.clone(),
            compressed_size: header.compressed_size,
            uncompressed_size: header.uncompressed_size,
        };
        // The whole chunk is checked before any of it is added.
        let chunk = ChunkContent::read(&record)?;
        chunk::validate(&index, &record)?;
        self.last_indexes = chunk.indexes;
        chunk
            .schemas
            .into_iter()
            .for_each(|schema| drop(self.summary.schemas.insert(schema.id, Arc::new(schema))));
        for channel in chunk.channels {
            let schema = self.summary.schemas.get(&channel.schema_id).cloned();
            let records::Channel { id, topic, message_encoding, metadata, .. } = channel;
            self.summary
                .channels
                .insert(id, Arc::new(Channel { id, topic, schema, message_encoding, metadata }));
        }
        self.count(&header);
        self.summary.chunk_indexes.push(index);
        Ok(())
    }

    /// Adds the chunk of `last_indexes` to the statistics.
    fn count(&mut self, header: &records::ChunkHeader) {
        let messages: u64 = self.last_indexes.iter().map(|index| index.records.len() as u64).sum();
        let stats = self.summary.stats.get_or_insert_default();
        if messages > 0 {
            let start = if stats.message_count == 0 { u64::MAX } else { stats.message_start_time };
            stats.message_start_time = start.min(header.message_start_time);
            stats.message_end_time = stats.message_end_time.max(header.message_end_time);
        }
        stats.message_count += messages;
        for index in &self.last_indexes {
            *stats.channel_message_counts.entry(index.channel_id).or_default() +=
                index.records.len() as u64;
        }
    }

    fn add_index(&mut self, file: &mut (impl Read + Seek), record: &RecordSpan) -> McapResult<()> {
        let content = record.read_content(file)?;
        let Record::MessageIndex(index) = parse_record(op::MESSAGE_INDEX, &content)? else {
            return Ok(());
        };
        // An index that doesn't match the chunk before it belongs to a damaged chunk.
        let matches_chunk =
            self.last_indexes.iter().any(|of_chunk| of_chunk.channel_id == index.channel_id);
        if let Some(chunk) = self.summary.chunk_indexes.last_mut().filter(|_| matches_chunk) {
            chunk.message_index_offsets.insert(index.channel_id, record.start);
            chunk.message_index_length += RECORD_HEADER + record.length;
        }
        Ok(())
    }

    /// Skips damaged bytes.
    fn skip(&mut self, damage: Range<u64>) {
        let indexes = std::mem::take(&mut self.last_indexes).len();
        let chunk = self.summary.chunk_indexes.last_mut();
        if let Some(chunk) = chunk.filter(|chunk| chunk.message_index_offsets.len() < indexes) {
            // If some indexes were listed and others not, readers would miss the messages of the
            // others. If none is listed, readers read the chunk itself.
            chunk.message_index_offsets.clear();
            chunk.message_index_length = 0;
        }
        self.damage.push(damage);
    }

    /// Adds schemas and channels of another summary of the same file.
    pub fn add_definitions(&mut self, other: &Summary) {
        let summary = &mut self.summary;
        for (id, schema) in &other.schemas {
            summary.schemas.entry(*id).or_insert_with(|| Arc::clone(schema));
        }
        for (id, channel) in &other.channels {
            summary.channels.entry(*id).or_insert_with(|| Arc::clone(channel));
        }
        let stats = summary.stats.get_or_insert_default();
        (stats.schema_count, stats.channel_count) =
            (summary.schemas.len() as u16, summary.channels.len() as u32);
    }

    /// Completes the statistics. If a chunk is the last record, or only its indexes follow, the
    /// indexes may be incomplete and are left to be written again.
    fn finish(mut self, end: u64) -> Self {
        self.end = end;
        if let Some(chunk) =
            self.summary.chunk_indexes.last_mut().filter(|_| !self.last_indexes.is_empty())
        {
            chunk.message_index_offsets.clear();
            chunk.message_index_length = 0;
            self.end = chunk.chunk_start_offset + chunk.chunk_length;
        }
        let summary = &mut self.summary;
        let stats = summary.stats.get_or_insert_default();
        stats.schema_count = summary.schemas.len() as u16;
        stats.channel_count = summary.channels.len() as u32;
        stats.chunk_count = summary.chunk_indexes.len() as u32;
        stats.metadata_count = summary.metadata_indexes.len() as u32;
        self
    }
}
