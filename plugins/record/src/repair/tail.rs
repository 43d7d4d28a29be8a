//! Writes the end of an MCAP file, after its last chunk.

use std::io::Cursor;

use binrw::{BinWrite, BinWriterExt};
use mcap::records::{self, DataEnd, Footer, SummaryOffset, op};
use mcap::{MAGIC, Summary};

use crate::mcap_record::RECORD_HEADER;
use crate::scan::Scan;

/// Returns everything after the last complete chunk: its indexes, the end of the data, the summary and the footer.
pub(super) fn tail(scan: &Scan) -> Vec<u8> {
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
    // A checksum of 0 means that there is none.
    out.record(op::FOOTER, &Footer { summary_start, summary_offset_start, summary_crc: 0 }, &[]);
    out.bytes.extend_from_slice(MAGIC);
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
