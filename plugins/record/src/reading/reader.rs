//! Reads the messages of a recording one by one.

use std::io::{Read, Seek, SeekFrom};

use mcap::sans_io::{IndexedReadEvent, IndexedReader};
use mcap::{McapError, McapResult};

use super::{Entry, ReadingError, Recording};
use crate::schema::Topic;

/// A cursor over the messages of a recording.
pub(crate) struct Reader<'recording> {
    recording: &'recording Recording,
    reader: IndexedReader,
    /// The chunk read last, compressed.
    chunk: Vec<u8>,
    /// The message read last.
    message: Vec<u8>,
    /// The topic and time of that message, if it was peeked at but not yet returned.
    ahead: Option<(&'recording Topic, u64)>,
}

impl<'recording> Reader<'recording> {
    pub(super) fn new(recording: &'recording Recording, reader: IndexedReader) -> Self {
        Self { recording, reader, chunk: Vec::new(), message: Vec::new(), ahead: None }
    }

    /// Returns the time of the next message without consuming it.
    pub fn peek(&mut self) -> Result<Option<u64>, ReadingError> {
        if self.ahead.is_none() {
            let recording = self.recording;
            self.ahead = self.advance().map_err(|error| recording.damaged(error))?;
        }
        Ok(self.ahead.map(|(_, log_time)| log_time))
    }

    /// Returns the next message on a topic that this crate knows.
    pub fn next(&mut self) -> Result<Option<Entry<'_>>, ReadingError> {
        self.peek()?;
        Ok(self.ahead.take().map(|(topic, log_time)| Entry {
            topic,
            log_time,
            message: &self.message,
        }))
    }

    /// Exchanges the buffer of the message that was returned last, to keep that message without a
    /// copy.
    pub fn swap_message(&mut self, other: &mut Vec<u8>) {
        std::mem::swap(&mut self.message, other);
    }

    /// Copies the next message to `message`.
    fn advance(&mut self) -> McapResult<Option<(&'recording Topic, u64)>> {
        while let Some(event) = self.reader.next_event() {
            match event.map_err(undecodable)? {
                IndexedReadEvent::ReadChunkRequest { offset, length } => {
                    self.chunk.resize(length, 0);
                    let mut file = &self.recording.file;
                    file.seek(SeekFrom::Start(offset))?;
                    file.read_exact(&mut self.chunk)?;
                    self.reader
                        .insert_chunk_record_data(offset, &self.chunk)
                        .map_err(undecodable)?;
                }
                IndexedReadEvent::Message { header, data } => {
                    if let Some(topic) = self.recording.topics.get(&header.channel_id) {
                        self.message.clear();
                        self.message.extend_from_slice(data);
                        return Ok(Some((topic, header.log_time)));
                    }
                }
            }
        }
        Ok(None)
    }
}

/// Turns an I/O error of the MCAP library into a decompression error: the library reads from
/// memory, so its I/O errors are caused by damaged data.
fn undecodable(error: McapError) -> McapError {
    match error {
        McapError::Io(reason) => McapError::DecompressionError(reason.to_string()),
        error => error,
    }
}
