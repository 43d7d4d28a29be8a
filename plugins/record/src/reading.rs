//! Reads recordings in order of time. Only the requested part of a file is read.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::time::Duration;

use mcap::records::{ChunkIndex, MessageIndex, Record};
use mcap::sans_io::indexed_reader::ReadOrder;
use mcap::sans_io::{
    IndexedReadEvent, IndexedReader, IndexedReaderOptions, SummaryReadEvent, SummaryReader, SummaryReaderOptions,
};
use mcap::{McapError, McapResult, Summary, parse_record};

use crate::contacts::ContactDecoder;
use crate::decode::{self, MessageError};
use crate::mcap_record::{MAX_RECORD, RecordSpan};
use crate::progress::Progress;
use crate::recorded::RecordedColumn;
use crate::scan::{ChunkContent, scan};
use crate::schema::Topic;

/// The error of reading a recording.
#[derive(Debug, thiserror::Error)]
pub enum ReadingError {
    /// The file can't be opened or read.
    #[error("can't read {path} ({reason})")]
    Io {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        reason: io::Error,
    },
    /// The file is not an MCAP file, or is damaged.
    #[error("can't read {path} as a recording ({reason}); `regatta record --repair` keeps its undamaged parts")]
    Mcap {
        /// The file.
        path: PathBuf,
        /// The reason given by the MCAP library.
        reason: McapError,
    },
    /// The file is an MCAP file without topics of a fleet.
    #[error("{path} has no topics of Regatta: it isn't a recording of a fleet")]
    NoFleet {
        /// The file.
        path: PathBuf,
    },
    /// The recording has no frames, because other topics were chosen.
    #[error("{path} has no frames: only other topics were recorded")]
    NoFrames {
        /// The file.
        path: PathBuf,
    },
    /// A message doesn't match its schema.
    #[error("{path} has an invalid message on {topic} at {:.3} s ({reason})", at.as_secs_f64())]
    Message {
        /// The file.
        path: PathBuf,
        /// The message's topic.
        topic: String,
        /// The message's time in the recording.
        at: Duration,
        /// The error of decoding it.
        reason: MessageError,
    },
}

/// A recording on disk. Not more than about two chunks of its messages are in memory at a time.
#[derive(Debug)]
pub struct Recording {
    path: PathBuf,
    file: File,
    summary: Summary,
    topics: HashMap<u16, Topic>,
    closed: bool,
}

/// Facts of a recording's metadata, by record and name.
pub(crate) type Facts = BTreeMap<String, BTreeMap<String, String>>;

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

impl Recording {
    /// Opens a recording. One that was never closed is first scanned up to its last complete chunk.
    ///
    /// # Errors
    /// Returns a [`ReadingError`] if the file can't be read or isn't a recording.
    pub fn open(path: &Path) -> Result<Self, ReadingError> {
        let failed = |reason| ReadingError::Io { path: path.to_owned(), reason };
        let mut file = File::open(path).map_err(failed)?;
        let (summary, closed) = match summary(&mut file) {
            Ok(Some(summary)) => (summary, true),
            Err(McapError::Io(error)) => return Err(failed(error)),
            _ => {
                let mut progress = Progress::start("reading");
                let mut report = |done| progress.report(done).map_err(Into::into);
                (scan(&mut file, &BTreeSet::new(), &mut report).map_err(failed)?.summary, false)
            }
        };
        let topics: HashMap<_, _> = summary
            .channels
            .iter()
            .filter_map(|(id, channel)| Some((*id, Topic::from_name(&channel.topic)?)))
            .collect();
        if !topics.values().any(|topic| topic.schema().starts_with("regatta.")) {
            return Err(ReadingError::NoFleet { path: path.to_owned() });
        }
        Ok(Self { path: path.to_owned(), file, summary, topics, closed })
    }

    /// Opens a recording that has frames.
    ///
    /// # Errors
    /// Returns a [`ReadingError`] as [`open`](Self::open), and also if the recording has no frames.
    pub fn open_frames(path: &Path) -> Result<Self, ReadingError> {
        let recording = Self::open(path)?;
        match recording.count(&Topic::Frames) {
            0 => Err(ReadingError::NoFrames { path: path.to_owned() }),
            _ => Ok(recording),
        }
    }

    /// Returns the file's path.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Whether the recording was closed. If not, the messages after its last complete chunk are missing.
    pub fn is_closed(&self) -> bool {
        self.closed
    }

    /// Returns the topics, sorted.
    pub fn topics(&self) -> Vec<Topic> {
        let topics: BTreeSet<_> = self.topics.values().cloned().collect();
        topics.into_iter().collect()
    }

    /// Returns the times of the first and the last message.
    pub fn span(&self) -> (Duration, Duration) {
        let stats = self.summary.stats.as_ref();
        let (start, end) = stats.map_or((0, 0), |stats| (stats.message_start_time, stats.message_end_time));
        (Duration::from_nanos(start), Duration::from_nanos(end))
    }

    /// Returns the number of messages on a topic.
    pub fn count(&self, topic: &Topic) -> u64 {
        let counts = self.summary.stats.as_ref().map(|stats| &stats.channel_message_counts);
        let of = |channel: &u16| counts.and_then(|counts| counts.get(channel)).copied().unwrap_or(0);
        self.topics.iter().filter(|(_, other)| *other == topic).map(|(channel, _)| of(channel)).sum()
    }

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

    /// Reads messages in order of time. Messages of the same time keep the order in which they were recorded.
    pub(crate) fn read(&self, selection: &Selection) -> Result<Reader<'_>, ReadingError> {
        let options = IndexedReaderOptions::new().starting_at(selection.from).ending_at(selection.to);
        self.reader(options, &selection.topics)
    }

    /// Returns the time and the bytes of the last message on a topic at or before `time`.
    pub(crate) fn last_until(&self, topic: &Topic, time: u64) -> Result<Option<(u64, Vec<u8>)>, ReadingError> {
        let options = IndexedReaderOptions::new().ending_at(time).with_order(ReadOrder::ReverseLogTime);
        let mut reader = self.reader(options, std::slice::from_ref(topic))?;
        Ok(reader.next()?.map(|entry| (entry.log_time, entry.message.to_vec())))
    }

    /// Returns the time and the bytes of the state of a topic before `time`. If that is lost, a repetition of it after
    /// `time` serves as well.
    pub(crate) fn state_before(&self, topic: &Topic, time: u64) -> Result<Option<(u64, Vec<u8>)>, ReadingError> {
        let before = time.checked_sub(1).map_or(Ok(None), |before| self.last_until(topic, before))?;
        if before.is_some() {
            return Ok(before);
        }
        let mut reader = self.reader(IndexedReaderOptions::new().starting_at(time), std::slice::from_ref(topic))?;
        let Some(Entry { log_time, message, .. }) = reader.next()? else { return Ok(None) };
        let is_repeated = match topic {
            Topic::World => decode::world(message).map(|world| world.is_repeated),
            Topic::Column(_) => RecordedColumn::parse(message).map(|column| column.is_repeated),
            _ => Ok(false),
        };
        let is_repeated = is_repeated.map_err(|reason| self.malformed(topic, log_time, reason))?;
        Ok(is_repeated.then(|| (log_time, message.to_vec())))
    }

    /// Returns a decoder with the list of contacts before `time`.
    pub(crate) fn contacts_before(&self, time: u64) -> Result<ContactDecoder, ReadingError> {
        let mut decoder = ContactDecoder::default();
        let Some(before) = time.checked_sub(1) else { return Ok(decoder) };
        let Some((from, _)) = self.last_until(&Topic::Contacts, before)? else { return Ok(decoder) };
        let options = IndexedReaderOptions::new().starting_at(from).ending_at(before);
        let mut reader = self.reader(options, &[Topic::Contacts, Topic::ContactUpdates])?;
        while let Some(Entry { topic, log_time, message }) = reader.next()? {
            decoder.decode(topic, message).map_err(|reason| self.malformed(topic, log_time, reason))?;
        }
        Ok(decoder)
    }

    fn reader(&self, options: IndexedReaderOptions, topics: &[Topic]) -> Result<Reader<'_>, ReadingError> {
        let is_recorded = |topic: &Topic| self.topics.values().any(|recorded| recorded == topic);
        let options = match topics {
            [] => options,
            topics if topics.iter().any(is_recorded) => options.include_topics(topics.iter().map(Topic::name)),
            // Nothing: with topics that don't exist, the reader would read all messages.
            _ => IndexedReaderOptions::new().starting_at(0).ending_before(0),
        };
        let options = options.with_record_length_limit(MAX_RECORD);
        let reader = IndexedReader::new_with_options(&self.summary, options).map_err(|error| self.damaged(error))?;
        Ok(Reader { recording: self, reader, chunk: Vec::new(), message: Vec::new(), ahead: None })
    }

    fn damaged(&self, reason: McapError) -> ReadingError {
        let path = self.path.clone();
        match reason {
            McapError::Io(reason) => ReadingError::Io { path, reason },
            reason => ReadingError::Mcap { path, reason },
        }
    }

    /// Returns the error of an invalid message, with the message's topic and time.
    pub(crate) fn malformed(&self, topic: &Topic, log_time: u64, reason: MessageError) -> ReadingError {
        let (path, at) = (self.path.clone(), Duration::from_nanos(log_time));
        ReadingError::Message { path, topic: topic.name(), at, reason }
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
        Ok(self.ahead.take().map(|(topic, log_time)| Entry { topic, log_time, message: &self.message }))
    }

    /// Exchanges the buffer of the message that was returned last, to keep that message without a copy.
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
                    self.reader.insert_chunk_record_data(offset, &self.chunk).map_err(undecodable)?;
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

/// Turns an I/O error of the MCAP library into a decompression error: the library reads from memory, so its I/O errors
/// are caused by damaged data.
fn undecodable(error: McapError) -> McapError {
    match error {
        McapError::Io(reason) => McapError::DecompressionError(reason.to_string()),
        error => error,
    }
}

/// Reads the summary at the end of a file. Returns `None` if the file was never closed.
pub(crate) fn summary(file: &mut File) -> McapResult<Option<Summary>> {
    let length = file.seek(SeekFrom::End(0))?;
    let options = SummaryReaderOptions::default().with_file_size(length).with_record_length_limit(MAX_RECORD);
    let mut reader = SummaryReader::new_with_options(options);
    while let Some(event) = reader.next_event() {
        match event? {
            SummaryReadEvent::ReadRequest(length) => {
                let read = file.read(reader.insert(length))?;
                reader.notify_read(read);
            }
            SummaryReadEvent::SeekRequest(to) => reader.notify_seeked(file.seek(to)?),
        }
    }
    Ok(reader.finish())
}
