//! Decodes and validates a chunk.

use mcap::records::{self, ChunkIndex, MessageIndex, MessageIndexEntry, Record};
use mcap::sans_io::{
    IndexedReadEvent, IndexedReader, IndexedReaderOptions, LinearReadEvent, LinearReader,
    LinearReaderOptions,
};
use mcap::{McapError, McapResult, Schema, Summary, parse_record};

use crate::mcap_record::{MAX_RECORD, RECORD_HEADER};

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
                match self.indexes.iter_mut().find(|index| index.channel_id == header.channel_id) {
                    Some(index) => index.records.push(entry),
                    None => self
                        .indexes
                        .push(MessageIndex { channel_id: header.channel_id, records: vec![entry] }),
                }
            }
            _ => {}
        }
        Ok(())
    }
}

/// Checks that a reader with an index can decompress a chunk record to its end. Readers without an
/// index stop earlier and accept some damaged chunks.
pub(super) fn validate(index: &ChunkIndex, record: &[u8]) -> McapResult<()> {
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
