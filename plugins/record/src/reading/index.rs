//! Reads the index of a recording, without its messages.

use std::cmp::Reverse;
use std::collections::BTreeMap;
use std::io::{Read, Seek, SeekFrom};

use mcap::records::{ChunkIndex, MessageIndex, Record};
use mcap::{McapError, McapResult};

use super::{ReadingError, Recording};
use crate::mcap_file::{MAX_RECORD, RecordSpan};
use crate::parse::parse_record;
use crate::scan::ChunkContent;
use crate::schema::Topic;

/// The metadata of a recording: values by record and key.
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

    /// Returns the metadata.
    pub(crate) fn metadata(&self) -> Result<Facts, ReadingError> {
        let mut facts = Facts::new();
        for index in &self.summary.metadata_indexes {
            if let Record::Metadata(metadata) = self.record(index.offset)? {
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
                indexes = self.read_chunk(chunk).map_err(|error| self.damaged(error))?.indexes;
            }
            each(chunk, &indexes);
        }
        Ok(())
    }

    fn read_chunk(&self, chunk: &ChunkIndex) -> McapResult<ChunkContent> {
        let mut file = &self.file;
        if chunk.chunk_length > MAX_RECORD as u64 {
            return Err(McapError::ChunkTooLarge(chunk.chunk_length));
        }
        let mut record = vec![0; chunk.chunk_length as usize];
        file.seek(SeekFrom::Start(chunk.chunk_start_offset))?;
        file.read_exact(&mut record)?;
        ChunkContent::read(&record)
    }

    /// Returns the time of the last message on a topic at or before `time`, by the index alone.
    /// Reads a chunk only if the file was never closed.
    pub(crate) fn time_until(&self, topic: &Topic, time: u64) -> Result<Option<u64>, ReadingError> {
        let mut chunks: Vec<_> = self.summary.chunk_indexes.iter().collect();
        chunks.retain(|chunk| chunk.message_start_time <= time);
        chunks.sort_by_key(|chunk| Reverse(chunk.message_end_time));
        let mut newest = None;
        for chunk in chunks {
            if newest.is_some_and(|newest| newest >= chunk.message_end_time) {
                break;
            }
            if chunk.message_index_offsets.is_empty() {
                return Ok(self.last_until(topic, time)?.map(|(time, _)| time));
            }
            for channel in self.channels(topic) {
                let Some(offset) = chunk.message_index_offsets.get(&channel) else { continue };
                if let Record::MessageIndex(index) = self.record(*offset)? {
                    let times = index.records.iter().map(|entry| entry.log_time);
                    newest = newest.max(times.filter(|found| *found <= time).max());
                }
            }
        }
        Ok(newest)
    }

    /// Reads the record at an offset.
    fn record(&self, offset: u64) -> Result<Record<'static>, ReadingError> {
        self.read_record(offset).map_err(|error| self.damaged(error))
    }

    fn read_record(&self, offset: u64) -> McapResult<Record<'static>> {
        let mut file = &self.file;
        let span = RecordSpan::read(&mut file, offset, u64::MAX)?.ok_or(McapError::BadIndex)?;
        let content = span.read_content(&mut file)?;
        parse_record(span.opcode, &content).map(Record::into_owned)
    }
}
