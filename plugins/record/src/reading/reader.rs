//! Reads messages: one by one in order of time, or the one that is valid at a time.

use std::collections::BTreeSet;
use std::io::{Read, Seek, SeekFrom};
use std::slice;

use mcap::sans_io::indexed_reader::ReadOrder;
use mcap::sans_io::{IndexedReadEvent, IndexedReader, IndexedReaderOptions};
use mcap::{McapError, McapResult};

use super::{ReadingError, Recording};
use crate::contacts::ContactDecoder;
use crate::decode;
use crate::mcap_file::MAX_RECORD;
use crate::recorded::RecordedColumn;
use crate::schema::Topic;

/// One message of a recording.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Entry<'recording> {
    pub topic: &'recording Topic,
    /// The time on the recording's clock, in nanoseconds.
    pub log_time: u64,
    pub message: &'recording [u8],
}

/// The part of a recording to read.
#[derive(Clone, Debug)]
pub(crate) struct Selection {
    /// The start on the recording's clock, in nanoseconds.
    pub from: u64,
    /// The end, which is included.
    pub to: u64,
    /// The topics; empty for all.
    pub topics: Vec<Topic>,
}

impl Selection {
    /// Returns a selection of all messages on these topics; of all topics, if there are none.
    pub fn all_of(topics: Vec<Topic>) -> Self {
        Self { from: 0, to: u64::MAX, topics }
    }
}

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
        let Some((topic, log_time)) = self.ahead.take() else { return Ok(None) };
        Ok(Some(Entry { topic, log_time, message: &self.message }))
    }

    /// Returns the next message if it has the given time.
    pub fn next_at(&mut self, log_time: u64) -> Result<Option<Entry<'_>>, ReadingError> {
        if self.peek()? == Some(log_time) { self.next() } else { Ok(None) }
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

impl Recording {
    /// Reads messages in order of time. Messages of the same time keep the order in which they were
    /// recorded.
    pub(crate) fn read(&self, selection: &Selection) -> Result<Reader<'_>, ReadingError> {
        let options =
            IndexedReaderOptions::new().starting_at(selection.from).ending_at(selection.to);
        self.reader(options, &selection.topics)
    }

    fn reader(
        &self,
        options: IndexedReaderOptions,
        topics: &[Topic],
    ) -> Result<Reader<'_>, ReadingError> {
        // Recordings of older versions have other names for some topics.
        let channels = topics.iter().flat_map(|topic| self.channels(topic));
        let names: BTreeSet<&str> =
            channels.map(|channel| self.summary.channels[&channel].topic.as_str()).collect();
        let options = if topics.is_empty() {
            options
        } else if !names.is_empty() {
            options.include_topics(names)
        } else {
            // Nothing: with topics that don't exist, the reader would read all messages.
            IndexedReaderOptions::new().starting_at(0).ending_before(0)
        };
        let options = options.with_record_length_limit(MAX_RECORD);
        let reader = IndexedReader::new_with_options(&self.summary, options)
            .map_err(|error| self.damaged(error))?;
        let (chunk, message) = (Vec::new(), Vec::new());
        Ok(Reader { recording: self, reader, chunk, message, ahead: None })
    }

    /// Returns the time and the bytes of the last message on a topic at or before `time`.
    pub(crate) fn last_until(
        &self,
        topic: &Topic,
        time: u64,
    ) -> Result<Option<(u64, Vec<u8>)>, ReadingError> {
        let options =
            IndexedReaderOptions::new().ending_at(time).with_order(ReadOrder::ReverseLogTime);
        let mut reader = self.reader(options, slice::from_ref(topic))?;
        Ok(reader.next()?.map(|entry| (entry.log_time, entry.message.to_vec())))
    }

    /// Returns the time and the bytes of the state of a topic before `time`. If it is lost, a
    /// repetition of it after `time` is used.
    pub(crate) fn state_before(
        &self,
        topic: &Topic,
        time: u64,
    ) -> Result<Option<(u64, Vec<u8>)>, ReadingError> {
        if let Some(before) = time.checked_sub(1)
            && let Some(state) = self.last_until(topic, before)?
        {
            return Ok(Some(state));
        }
        let options = IndexedReaderOptions::new().starting_at(time);
        let mut reader = self.reader(options, slice::from_ref(topic))?;
        let Some(Entry { log_time, message, .. }) = reader.next()? else { return Ok(None) };
        let is_repeated = match topic {
            Topic::World => decode::world(message).map(|world| world.is_repeated),
            Topic::Column(_) => RecordedColumn::parse(message).map(|column| column.is_repeated),
            _ => Ok(false),
        };
        let is_repeated = self.located(topic, log_time, is_repeated)?;
        Ok(is_repeated.then(|| (log_time, message.to_vec())))
    }

    /// Returns a decoder with the list of contacts before `time`.
    pub(crate) fn contacts_before(&self, time: u64) -> Result<ContactDecoder, ReadingError> {
        let mut decoder = ContactDecoder::default();
        let Some(before) = time.checked_sub(1) else { return Ok(decoder) };
        let Some((from, _)) = self.last_until(&Topic::Contacts, before)? else {
            return Ok(decoder);
        };
        let options = IndexedReaderOptions::new().starting_at(from).ending_at(before);
        let mut reader = self.reader(options, &[Topic::Contacts, Topic::ContactUpdates])?;
        while let Some(Entry { topic, log_time, message }) = reader.next()? {
            self.located(topic, log_time, decoder.decode(topic, message))?;
        }
        Ok(decoder)
    }
}
