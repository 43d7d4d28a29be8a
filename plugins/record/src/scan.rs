//! Walks through a recording from its start, as far as it is whole. For files that were never closed, or are damaged.

use std::collections::BTreeSet;
use std::io::{self, Read, Seek, SeekFrom};
use std::ops::Range;
use std::sync::Arc;

use mcap::records::{self, ChunkIndex, MessageIndex, MessageIndexEntry, MetadataIndex, Record, op};
use mcap::sans_io::{
    IndexedReadEvent, IndexedReader, IndexedReaderOptions, LinearReadEvent, LinearReader, LinearReaderOptions,
};
use mcap::{Channel, MAGIC, McapError, McapResult, Schema, Summary, parse_record};

/// Opcode and length before each record.
pub(crate) const RECORD_HEADER: u64 = 9;

/// No chunk and no record is larger: one that says so is damaged.
pub(crate) const MAX_RECORD: usize = 1 << 30;

/// What a recording holds up to the first thing that is damaged, missing, or no data.
#[derive(Default)]
pub(crate) struct Scan {
    /// As if the file had been closed after that.
    pub summary: Summary,
    /// Bytes that are whole: from here on, the file can be written anew.
    pub end: u64,
    /// Message indexes of the last chunk, if they are to be written anew as well.
    pub last_indexes: Vec<MessageIndex>,
    /// Bytes in between that can't be understood.
    pub holes: Vec<Range<u64>>,
}

/// One record's place in a file.
struct Place {
    opcode: u8,
    start: u64,
    length: u64,
}

impl Place {
    fn end(&self) -> u64 {
        self.start + RECORD_HEADER + self.length
    }
}

/// Reads a recording through. After damage it goes on at the next of the places that are `known` to begin a record.
///
/// # Errors
/// If the file can't be read, or isn't even the start of one (`UnexpectedEof`, `InvalidData`).
pub(crate) fn scan(file: &mut (impl Read + Seek), known: &BTreeSet<u64>) -> io::Result<Scan> {
    let length = file.seek(SeekFrom::End(0))?;
    file.rewind()?;
    let mut magic = [0; MAGIC.len()];
    file.read_exact(&mut magic)?;
    if magic != *MAGIC {
        return Err(io::Error::new(io::ErrorKind::InvalidData, "it doesn't start as an MCAP file does"));
    }
    let mut scan = Scan::default();
    let mut end = MAGIC.len() as u64;
    loop {
        let next = known.range(end + 1..).next().copied();
        let place = next_record(file, end, next.unwrap_or(length).min(length))?;
        let place = place.filter(|place| is_data(place.opcode) && scan.take(file, place).is_ok());
        match (place, next) {
            (Some(place), _) => end = place.end(),
            (None, Some(next)) => {
                scan.leave_out(end..next);
                end = next;
            }
            // The first that can't be understood ends what can be kept.
            (None, None) => break,
        }
    }
    match end == MAGIC.len() as u64 {
        true => Err(io::Error::new(io::ErrorKind::UnexpectedEof, "it ends within its header")),
        false => Ok(scan.finish(end)),
    }
}

/// Records of the part of a file that holds data.
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

/// The record that starts at `start`, unless it reaches beyond `limit`.
fn next_record(file: &mut (impl Read + Seek), start: u64, limit: u64) -> io::Result<Option<Place>> {
    let room = limit.saturating_sub(start + RECORD_HEADER);
    if start + RECORD_HEADER > limit {
        return Ok(None);
    }
    file.seek(SeekFrom::Start(start))?;
    let mut header = [0; RECORD_HEADER as usize];
    file.read_exact(&mut header)?;
    let [opcode, length @ ..] = header;
    let length = u64::from_le_bytes(length);
    Ok((length <= room).then_some(Place { opcode, start, length }))
}

impl Scan {
    fn take(&mut self, file: &mut (impl Read + Seek), place: &Place) -> McapResult<()> {
        if place.opcode != op::MESSAGE_INDEX {
            self.last_indexes.clear();
        }
        match place.opcode {
            op::CHUNK => self.take_chunk(file, place),
            op::MESSAGE_INDEX => self.take_index(file, place),
            op::METADATA => {
                let body = read_body(file, place)?;
                let Record::Metadata(metadata) = parse_record(op::METADATA, &body)? else { return Ok(()) };
                let (offset, length) = (place.start, RECORD_HEADER + place.length);
                self.summary.metadata_indexes.push(MetadataIndex { offset, length, name: metadata.name });
                Ok(())
            }
            // Ours have none of these outside of chunks; those of others stay where they are.
            _ => Ok(()),
        }
    }

    fn take_chunk(&mut self, file: &mut (impl Read + Seek), place: &Place) -> McapResult<()> {
        let length = usize::try_from(place.length).ok().filter(|length| *length <= MAX_RECORD);
        let length = length.ok_or(McapError::ChunkTooLarge(place.length))?;
        file.seek(SeekFrom::Start(place.start))?;
        let mut record = vec![0; RECORD_HEADER as usize + length];
        file.read_exact(&mut record)?;
        let Record::Chunk { header, .. } = parse_record(op::CHUNK, &record[RECORD_HEADER as usize..])? else {
            return Err(McapError::BadIndex);
        };
        let index = ChunkIndex {
            message_start_time: header.message_start_time,
            message_end_time: header.message_end_time,
            chunk_start_offset: place.start,
            chunk_length: RECORD_HEADER + place.length,
            message_index_offsets: Default::default(),
            message_index_length: 0,
            compression: header.compression.clone(),
            compressed_size: header.compressed_size,
            uncompressed_size: header.uncompressed_size,
        };
        // All of it before any of it counts.
        let chunk = ChunkContent::read(&record)?;
        decode(&index, &record)?;
        self.last_indexes = chunk.indexes;
        chunk.schemas.into_iter().for_each(|schema| drop(self.summary.schemas.insert(schema.id, Arc::new(schema))));
        for channel in chunk.channels {
            let schema = self.summary.schemas.get(&channel.schema_id).cloned();
            let records::Channel { id, topic, message_encoding, metadata, .. } = channel;
            self.summary.channels.insert(id, Arc::new(Channel { id, topic, schema, message_encoding, metadata }));
        }
        self.count(&header);
        self.summary.chunk_indexes.push(index);
        Ok(())
    }

    /// Adds the chunk whose indexes were taken last to the statistics.
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
            *stats.channel_message_counts.entry(index.channel_id).or_default() += index.records.len() as u64;
        }
    }

    fn take_index(&mut self, file: &mut (impl Read + Seek), place: &Place) -> McapResult<()> {
        let body = read_body(file, place)?;
        let Record::MessageIndex(index) = parse_record(op::MESSAGE_INDEX, &body)? else { return Ok(()) };
        // One that follows on no chunk, or isn't of it, belongs to a chunk that is damaged.
        let is_of_chunk = self.last_indexes.iter().any(|of_chunk| of_chunk.channel_id == index.channel_id);
        if let Some(chunk) = self.summary.chunk_indexes.last_mut().filter(|_| is_of_chunk) {
            chunk.message_index_offsets.insert(index.channel_id, place.start);
            chunk.message_index_length += RECORD_HEADER + place.length;
        }
        Ok(())
    }

    /// Passes over what can't be understood.
    fn leave_out(&mut self, hole: Range<u64>) {
        let indexes = std::mem::take(&mut self.last_indexes).len();
        let chunk = self.summary.chunk_indexes.last_mut();
        if let Some(chunk) = chunk.filter(|chunk| chunk.message_index_offsets.len() < indexes) {
            // With some of its indexes missing a reader would take it to lack those messages; with none it looks.
            chunk.message_index_offsets.clear();
            chunk.message_index_length = 0;
        }
        self.holes.push(hole);
    }

    /// Adds definitions that stand in another summary of the same file.
    pub fn define(&mut self, other: &Summary) {
        let summary = &mut self.summary;
        for (id, schema) in &other.schemas {
            summary.schemas.entry(*id).or_insert_with(|| Arc::clone(schema));
        }
        for (id, channel) in &other.channels {
            summary.channels.entry(*id).or_insert_with(|| Arc::clone(channel));
        }
        let stats = summary.stats.get_or_insert_default();
        (stats.schema_count, stats.channel_count) = (summary.schemas.len() as u16, summary.channels.len() as u32);
    }

    /// If a chunk comes last, its indexes may be incomplete: they are written anew.
    fn finish(mut self, end: u64) -> Self {
        self.end = end;
        if let Some(chunk) = self.summary.chunk_indexes.last_mut().filter(|_| !self.last_indexes.is_empty()) {
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

fn read_body(file: &mut (impl Read + Seek), place: &Place) -> McapResult<Vec<u8>> {
    if place.length > MAX_RECORD as u64 {
        return Err(McapError::RecordTooLarge { opcode: place.opcode, len: place.length });
    }
    file.seek(SeekFrom::Start(place.start + RECORD_HEADER))?;
    let mut body = vec![0; place.length as usize];
    file.read_exact(&mut body)?;
    Ok(body)
}

/// Decompresses a chunk record to its very end, as readers with an index do, and those without don't.
fn decode(index: &ChunkIndex, record: &[u8]) -> McapResult<()> {
    let summary = Summary { chunk_indexes: vec![index.clone()], ..Summary::default() };
    let options = IndexedReaderOptions::new().with_record_length_limit(MAX_RECORD);
    let mut reader = IndexedReader::new_with_options(&summary, options)?;
    while let Some(IndexedReadEvent::ReadChunkRequest { offset, length }) = reader.next_event().transpose()? {
        let start = (offset - index.chunk_start_offset) as usize;
        let compressed = record.get(start..).filter(|rest| rest.len() == length).ok_or(McapError::BadIndex)?;
        reader.insert_chunk_record_data(offset, compressed)?;
    }
    Ok(())
}

/// What lies in a chunk.
#[derive(Default)]
struct ChunkContent {
    schemas: Vec<Schema<'static>>,
    channels: Vec<records::Channel>,
    indexes: Vec<MessageIndex>,
}

impl ChunkContent {
    /// Decompresses a chunk record and checks its sum.
    fn read(mut record: &[u8]) -> McapResult<Self> {
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
                LinearReadEvent::ReadRequest(wanted) => {
                    let (part, rest) = record.split_at(wanted.min(record.len()));
                    reader.insert(part.len()).copy_from_slice(part);
                    reader.notify_read(part.len());
                    record = rest;
                }
                LinearReadEvent::Record { opcode, data } => {
                    content.take(offset, opcode, data)?;
                    offset += RECORD_HEADER + data.len() as u64;
                }
            }
        }
        content.indexes.sort_by_key(|index| index.channel_id);
        Ok(content)
    }

    fn take(&mut self, offset: u64, opcode: u8, data: &[u8]) -> McapResult<()> {
        match parse_record(opcode, data)? {
            Record::Schema { header, data } => {
                let records::SchemaHeader { id, name, encoding } = header;
                self.schemas.push(Schema { id, name, encoding, data: data.into_owned().into() });
            }
            Record::Channel(channel) => self.channels.push(channel),
            Record::Message { header, .. } => {
                let entry = MessageIndexEntry { log_time: header.log_time, offset };
                match self.indexes.iter_mut().find(|index| index.channel_id == header.channel_id) {
                    Some(index) => index.records.push(entry),
                    None => self.indexes.push(MessageIndex { channel_id: header.channel_id, records: vec![entry] }),
                }
            }
            _ => {}
        }
        Ok(())
    }
}
