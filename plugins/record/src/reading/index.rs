//! What a recording's index says, without its messages.

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
    pub(crate) fn chunks(&self, mut each: impl FnMut(&ChunkIndex, &[MessageIndex])) -> Result<(), ReadingError> {
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
                let read =
                    file.seek(SeekFrom::Start(chunk.chunk_start_offset)).and_then(|_| file.read_exact(&mut record));
                let content = read.map_err(McapError::from).and_then(|()| ChunkContent::read(&record));
                indexes = content.map_err(|error| self.damaged(error))?.indexes;
            }
            each(chunk, &indexes);
        }
        Ok(())
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
