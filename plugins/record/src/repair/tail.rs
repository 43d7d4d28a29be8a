//! Writes the end of an MCAP file, after its last chunk.

use std::io::Cursor;

use binrw::{BinWrite, BinWriterExt};
use mcap::records::{self, DataEnd, Footer, SummaryOffset, op};
use mcap::{MAGIC, Summary};

use crate::mcap_file::RECORD_HEADER;
use crate::scan::Scan;

/// Returns everything after the last complete chunk: its indexes, the end of the data, the summary
/// and the footer.
pub(super) fn tail(scan: &Scan) -> Vec<u8> {
    let mut out = Tail { bytes: Vec::new(), start: scan.end };
    let mut summary = scan.summary.clone();
    let chunks = &mut summary.chunk_indexes;
    if let Some(chunk) = chunks.last_mut() {
        let start = out.position();
        for index in &scan.last_indexes {
            chunk.message_index_offsets.insert(index.channel_id, out.position());
            out.record(op::MESSAGE_INDEX, index, &[]);
        }
        chunk.message_index_length += out.position() - start;
    }
    out.summary(&summary);
    out.bytes
}

/// Returns the end of a file whose messages end at `end`: the end of the data, the summary and the
/// footer.
pub(crate) fn index(summary: &Summary, end: u64) -> Vec<u8> {
    let mut out = Tail { bytes: Vec::new(), start: end };
    out.summary(summary);
    out.bytes
}

/// The end of a file.
struct Tail {
    bytes: Vec<u8>,
    /// The offset of the tail in the file.
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
        cursor.write_le(body).expect("writing to memory never fails");
        self.bytes.extend_from_slice(more);
        let length = (self.bytes.len() - start) as u64 - RECORD_HEADER;
        self.bytes[start + 1..start + RECORD_HEADER as usize]
            .copy_from_slice(&length.to_le_bytes());
    }

    fn summary(&mut self, summary: &Summary) {
        self.record(op::DATA_END, &DataEnd::default(), &[]);
        let summary_start = self.position();
        let groups = [
            self.group(op::SCHEMA, |out| out.schemas(summary)),
            self.group(op::CHANNEL, |out| out.channels(summary)),
            self.group(op::STATISTICS, |out| {
                out.record(op::STATISTICS, &summary.stats.clone().unwrap_or_default(), &[]);
            }),
            self.group(op::CHUNK_INDEX, |out| {
                for chunk in &summary.chunk_indexes {
                    out.record(op::CHUNK_INDEX, chunk, &[]);
                }
            }),
            self.group(op::METADATA_INDEX, |out| {
                for index in &summary.metadata_indexes {
                    out.record(op::METADATA_INDEX, index, &[]);
                }
            }),
        ];
        let summary_offset_start = self.position();
        for offset in groups.iter().flatten() {
            self.record(op::SUMMARY_OFFSET, offset, &[]);
        }
        // A checksum of 0 means that there is none.
        let footer = Footer { summary_start, summary_offset_start, summary_crc: 0 };
        self.record(op::FOOTER, &footer, &[]);
        self.bytes.extend_from_slice(MAGIC);
    }

    /// Writes records with the same opcode, and returns their position, if there are any.
    fn group(&mut self, opcode: u8, write: impl FnOnce(&mut Self)) -> Option<SummaryOffset> {
        let start = self.position();
        write(self);
        let (group_opcode, group_start, group_length) = (opcode, start, self.position() - start);
        (group_length > 0).then_some(SummaryOffset { group_opcode, group_start, group_length })
    }

    fn schemas(&mut self, summary: &Summary) {
        let mut schemas: Vec<_> = summary.schemas.values().collect();
        schemas.sort_by_key(|schema| schema.id);
        for schema in schemas {
            let header = records::SchemaHeader {
                id: schema.id,
                name: schema.name.clone(),
                encoding: schema.encoding.clone(),
            };
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
