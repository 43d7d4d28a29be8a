//! What a recording's index says, without its messages.

use std::cmp::Reverse;
use std::collections::BTreeMap;
use std::io::{Read, Seek, SeekFrom};

use mcap::records::{ChunkIndex, MessageIndex, Record};
use mcap::{McapError, parse_record};

use super::{ReadingError, Recording};
use crate::mcap_record::RecordSpan;
use crate::scan::ChunkContent;
use crate::schema::Topic;

/// Facts of a recording's metadata, by record and name.
pub(crate) type Facts = BTreeMap<String, BTreeMap<String, String>>;

impl Recording {
    /// Returns the size of the file.
    pub(crate) fn bytes(&self) -> Result<u64, ReadingError> {
        let metadata = self.file.metadata().map_err(|error| self.damaged(error.into()))?;
        Ok(metadata.len())
    }

    /// Returns the topic of a channel, if this crate knows it.
    pub(crate) fn topic(&self, channel: u16) -> Option<&Topic> {
        self.topics.get(&channel)
    }

    /// Returns the facts in the metadata, by record and name.
    pub(crate) fn metadata(&self) -> Result<Facts, ReadingError> {
        let mut facts = Facts::new();
        for index in &self.summary.metadata_indexes {
            let record = self.record(index.offset)?;
            if let Record::Metadata(metadata) = record {
                facts.insert(metadata.name, metadata.metadata);
            }
        }
        Ok(facts)
    }

    /// Calls `each` with every chunk and the indexes of its messages.
    pub(crate) fn chunks(
        &self,
        mut each: impl FnMut(&ChunkIndex, &[MessageIndex]),
    ) -> Result<(), ReadingError> {
        for chunk in &self.summary.chunk_indexes {
            let mut indexes = Vec::new();
            for offset in chunk.message_index_offsets.values() {
                if let Record::MessageIndex(index) = self.record(*offset)? {
                    indexes.push(index);
                }
            }
            if indexes.is_empty() {
                // The last chunk of a recording that was never closed has no indexes.
                let mut file = &self.file;
                let mut record = vec![0; chunk.chunk_length as usize];
                let read = file
                    .seek(SeekFrom::Start(chunk.chunk_start_offset))
                    .and_then(|_| file.read_exact(&mut record));
                let content =
                    read.map_err(McapError::from).and_then(|()| ChunkContent::read(&record));
                indexes = content.map_err(|error| self.damaged(error))?.indexes;
            }
            each(chunk, &indexes);
        }
        Ok(())
    }

    /// Returns the time of the last message on a topic at or before `time`, by the index alone;
    /// reads no chunk, unless the file was never closed.
    pub(crate) fn time_until(&self, topic: &Topic, time: u64) -> Result<Option<u64>, ReadingError> {
        let channels: Vec<u16> =
            self.topics.iter().filter(|(_, of)| *of == topic).map(|(id, _)| *id).collect();
        let begun = |chunk: &&ChunkIndex| chunk.message_start_time <= time;
        let mut chunks: Vec<_> = self.summary.chunk_indexes.iter().filter(begun).collect();
        chunks.sort_by_key(|chunk| Reverse(chunk.message_end_time));
        let mut newest = None;
        for chunk in chunks {
            if newest.is_some_and(|newest| newest >= chunk.message_end_time) {
                break;
            }
            if chunk.message_index_offsets.is_empty() {
                return Ok(self.last_until(topic, time)?.map(|(time, _)| time));
            }
            for offset in
                channels.iter().filter_map(|channel| chunk.message_index_offsets.get(channel))
            {
                if let Record::MessageIndex(index) = self.record(*offset)? {
                    let times = index
                        .records
                        .iter()
                        .map(|entry| entry.log_time)
                        .filter(|found| *found <= time);
                    newest = newest.max(times.max());
                }
            }
        }
        Ok(newest)
    }

    /// Reads the record at an offset.
    fn record(&self, offset: u64) -> Result<Record<'static>, ReadingError> {
        let mut file = &self.file;
        let span = RecordSpan::read(&mut file, offset, u64::MAX).map_err(McapError::from);
        let span = span.and_then(|span| span.ok_or(McapError::BadIndex));
        let record = span.and_then(|span| {
            let content = span.read_content(&mut file)?;
            parse_record(span.opcode, &content).map(Record::into_owned)
        });
        record.map_err(|error| self.damaged(error))
    }
}
