//! Scans a recording from its start, for files that were never closed or are damaged.

use std::collections::BTreeSet;
use std::io::{self, Read, Seek, SeekFrom};
use std::ops::Range;
use std::sync::Arc;

use mcap::records::{
    self, ChunkHeader, ChunkIndex, MessageHeader, MessageIndex, MessageIndexEntry, MetadataIndex,
    Record, op,
};
use mcap::sans_io::{
    IndexedReadEvent, IndexedReader, IndexedReaderOptions, LinearReadEvent, LinearReader,
    LinearReaderOptions,
};
use mcap::{Channel, MAGIC, McapError, McapResult, Schema, Summary};

use crate::mcap_file::{MAX_RECORD, RECORD_HEADER, RecordSpan, most_content};
use crate::parse::parse_record;
use crate::progress::Progress;

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
    /// The bytes of all chunks so far, decompressed, and the most that the file may hold.
    content: u64,
    most_content: u64,
}

/// Scans a recording. After damage it continues at the next of the offsets in `record_starts`;
/// without one, the damage ends the scan.
///
/// # Errors
/// Returns an error if the process was asked to end (`Interrupted`), or if the file can't be read,
/// doesn't start like an MCAP file (`InvalidData`), or ends within its header (`UnexpectedEof`).
pub(crate) fn scan(
    file: &mut (impl Read + Seek),
    record_starts: &BTreeSet<u64>,
    progress: &mut Progress,
) -> io::Result<Scan> {
    let length = file.seek(SeekFrom::End(0))?;
    file.rewind()?;
    let mut magic = [0; MAGIC.len()];
    file.read_exact(&mut magic)?;
    if magic != *MAGIC {
        let reason = "it doesn't start like an MCAP file";
        return Err(io::Error::new(io::ErrorKind::InvalidData, reason));
    }
    let mut scan = Scan { most_content: most_content(length), ..Scan::default() };
    let mut end = MAGIC.len() as u64;
    loop {
        progress.report(end as f64 / length.max(1) as f64)?;
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
    if end == MAGIC.len() as u64 {
        return Err(io::Error::new(io::ErrorKind::UnexpectedEof, "it ends within its header"));
    }
    Ok(scan.finish(end))
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
                self.summary.metadata_indexes.push(MetadataIndex {
                    offset: record.start,
                    length: RECORD_HEADER + record.length,
                    name: metadata.name,
                });
                Ok(())
            }
            // After a damaged length, anything may look like a record.
            op::HEADER | op::SCHEMA | op::CHANNEL | op::MESSAGE => {
                let content = record.read_content(file)?;
                if let Record::Message { header, .. } = parse_record(record.opcode, &content)? {
                    self.count_message(&header);
                }
                Ok(())
            }
            // Regatta writes no other records outside of chunks. Those of other programs are left
            // unchanged.
            _ => Ok(()),
        }
    }

    /// Counts a message outside of chunks: readers find it, too.
    fn count_message(&mut self, header: &MessageHeader) {
        let stats = self.summary.stats.get_or_insert_default();
        let start = if stats.message_count == 0 { u64::MAX } else { stats.message_start_time };
        stats.message_start_time = start.min(header.log_time);
        stats.message_end_time = stats.message_end_time.max(header.log_time);
        stats.message_count += 1;
        *stats.channel_message_counts.entry(header.channel_id).or_default() += 1;
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
        self.content = self.content.saturating_add(header.uncompressed_size);
        if self.content > self.most_content {
            return Err(McapError::ChunkTooLarge(header.uncompressed_size));
        }
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
        validate(&index, &record)?;
        self.last_indexes = chunk.indexes;
        for schema in chunk.schemas {
            self.summary.schemas.insert(schema.id, Arc::new(schema));
        }
        for channel in chunk.channels {
            let schema = self.summary.schemas.get(&channel.schema_id).cloned();
            let records::Channel { id, topic, message_encoding, metadata, .. } = channel;
            let channel = Channel { id, topic, schema, message_encoding, metadata };
            self.summary.channels.insert(id, Arc::new(channel));
        }
        self.count(&header);
        self.summary.chunk_indexes.push(index);
        Ok(())
    }

    /// Adds the chunk of `last_indexes` to the statistics.
    fn count(&mut self, header: &ChunkHeader) {
        let messages: u64 = self.last_indexes.iter().map(|index| index.records.len() as u64).sum();
        let stats = self.summary.stats.get_or_insert_default();
        if messages > 0 {
            let start = if stats.message_count == 0 { u64::MAX } else { stats.message_start_time };
            stats.message_start_time = start.min(header.message_start_time);
            stats.message_end_time = stats.message_end_time.max(header.message_end_time);
        }
        stats.message_count += messages;
        for index in &self.last_indexes {
            let count = stats.channel_message_counts.entry(index.channel_id).or_default();
            *count += index.records.len() as u64;
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
        complete_counts(summary);
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
        complete_counts(&mut self.summary);
        self
    }
}

/// Sets the counts of a summary's records in its statistics.
pub(crate) fn complete_counts(summary: &mut Summary) {
    let stats = summary.stats.get_or_insert_default();
    stats.schema_count = summary.schemas.len() as u16;
    stats.channel_count = summary.channels.len() as u32;
    stats.chunk_count = summary.chunk_indexes.len() as u32;
    stats.metadata_count = summary.metadata_indexes.len() as u32;
}

/// The definitions in a chunk, and the indexes of its messages.
#[derive(Default)]
pub(crate) struct ChunkContent {
    pub schemas: Vec<Schema<'static>>,
    pub channels: Vec<records::Channel>,
    pub indexes: Vec<MessageIndex>,
}

impl ChunkContent {
    /// Decompresses a chunk record and checks its checksum.
    pub fn read(mut record: &[u8]) -> McapResult<Self> {
        check_records(record)?;
        let options = LinearReaderOptions::default()
            .with_skip_start_magic(true)
            .with_skip_end_magic(true)
            .with_prevalidate_chunk_crcs(true)
            .with_record_length_limit(MAX_RECORD);
        let mut reader = LinearReader::new_with_options(options);
        let mut content = Self::default();
        let mut offset = 0;
        while let Some(event) = reader.next_event() {
            match event? {
                LinearReadEvent::ReadRequest(length) => {
                    let (part, rest) = record.split_at(length.min(record.len()));
                    reader.insert(part.len()).copy_from_slice(part);
                    reader.notify_read(part.len());
                    record = rest;
                }
                LinearReadEvent::Record { opcode, data } => {
                    content.add(offset, opcode, data)?;
                    offset += RECORD_HEADER + data.len() as u64;
                }
            }
        }
        content.indexes.sort_by_key(|index| index.channel_id);
        Ok(content)
    }

    fn add(&mut self, offset: u64, opcode: u8, data: &[u8]) -> McapResult<()> {
        match parse_record(opcode, data)? {
            Record::Schema { header, data } => {
                let records::SchemaHeader { id, name, encoding } = header;
                self.schemas.push(Schema { id, name, encoding, data: data.into_owned().into() });
            }
            Record::Channel(channel) => self.channels.push(channel),
            Record::Message { header, .. } => {
                let entry = MessageIndexEntry { log_time: header.log_time, offset };
                let channel_id = header.channel_id;
                match self.indexes.iter_mut().find(|index| index.channel_id == channel_id) {
                    Some(index) => index.records.push(entry),
                    None => self.indexes.push(MessageIndex { channel_id, records: vec![entry] }),
                }
            }
            _ => {}
        }
        Ok(())
    }
}

/// Checks that the records in an uncompressed chunk end within it: the library subtracts their
/// lengths from that of the chunk.
fn check_records(record: &[u8]) -> McapResult<()> {
    let content = record.get(RECORD_HEADER as usize..).ok_or(McapError::UnexpectedEof)?;
    let Record::Chunk { header, data } = parse_record(op::CHUNK, content)? else {
        return Err(McapError::BadIndex);
    };
    let mut rest: &[u8] = if header.compression.is_empty() { &data } else { &[] };
    while !rest.is_empty() {
        let (start, more) = rest.split_first_chunk::<9>().ok_or(McapError::UnexpectedEof)?;
        let [_opcode, length @ ..] = *start;
        let length = usize::try_from(u64::from_le_bytes(length)).ok();
        rest = length.and_then(|length| more.get(length..)).ok_or(McapError::UnexpectedEof)?;
    }
    Ok(())
}

/// Checks that a reader with an index can decompress a chunk record to its end. Readers without an
/// index stop earlier and accept some damaged chunks.
fn validate(index: &ChunkIndex, record: &[u8]) -> McapResult<()> {
    let summary = Summary { chunk_indexes: vec![index.clone()], ..Summary::default() };
    let options = IndexedReaderOptions::new().with_record_length_limit(MAX_RECORD);
    let mut reader = IndexedReader::new_with_options(&summary, options)?;
    while let Some(IndexedReadEvent::ReadChunkRequest { offset, length }) =
        reader.next_event().transpose()?
    {
        let start = (offset - index.chunk_start_offset) as usize;
        let compressed =
            record.get(start..).filter(|rest| rest.len() == length).ok_or(McapError::BadIndex)?;
        reader.insert_chunk_record_data(offset, compressed)?;
    }
    Ok(())
}
