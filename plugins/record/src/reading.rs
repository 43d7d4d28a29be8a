//! Reads recordings, in order of time, without reading more of a file than is asked for.

use std::collections::{BTreeSet, HashMap};
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::time::Duration;

use mcap::sans_io::indexed_reader::ReadOrder;
use mcap::sans_io::{
    IndexedReadEvent, IndexedReader, IndexedReaderOptions, SummaryReadEvent, SummaryReader, SummaryReaderOptions,
};
use mcap::{McapError, McapResult, Summary};

use crate::decode::MessageError;
use crate::scan::{MAX_RECORD, scan};
use crate::schema::Topic;

/// Why a recording can't be read.
#[derive(Debug, thiserror::Error)]
pub enum ReadingError {
    /// It can't be opened or read.
    #[error("can't read {path} ({reason})")]
    Io {
        /// The file.
        path: PathBuf,
        /// Why.
        reason: io::Error,
    },
    /// It isn't an MCAP file, or a damaged one.
    #[error("{path} can't be read as a recording ({reason}); `regatta record --repair` keeps what is whole in it")]
    Mcap {
        /// The file.
        path: PathBuf,
        /// Why.
        reason: McapError,
    },
    /// It is an MCAP file of something else.
    #[error("{path} has no topic /frames: it isn't a recording of a fleet")]
    NoFrames {
        /// The file.
        path: PathBuf,
    },
    /// A message in it contradicts its schema.
    #[error("{path} has a message on {topic} at {:.3} s that can't be understood ({reason})", at.as_secs_f64())]
    Message {
        /// The file.
        path: PathBuf,
        /// The topic.
        topic: String,
        /// Its time in the recording.
        at: Duration,
        /// Why.
        reason: MessageError,
    },
}

/// A recording on disk. Of its messages, no more than a chunk or two are in memory at a time.
#[derive(Debug)]
pub struct Recording {
    path: PathBuf,
    file: File,
    summary: Summary,
    topics: HashMap<u16, Topic>,
    closed: bool,
}

/// One message of a recording.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Entry<'recording> {
    pub topic: &'recording Topic,
    /// Nanoseconds on the recording's clock.
    pub log_time: u64,
    pub message: &'recording [u8],
}

/// The part of a recording to read.
#[derive(Clone, Debug, Default)]
pub(crate) struct Selection {
    /// From this time on, in nanoseconds.
    pub from: u64,
    /// Only these topics; all of them if empty.
    pub topics: Vec<Topic>,
}

impl Recording {
    /// Opens a recording. One that was never closed is read through first, up to its last whole chunk.
    ///
    /// # Errors
    /// [`ReadingError`].
    pub fn open(path: &Path) -> Result<Self, ReadingError> {
        let failed = |reason| ReadingError::Io { path: path.to_owned(), reason };
        let mut file = File::open(path).map_err(failed)?;
        let (summary, closed) = match summary(&mut file) {
            Ok(Some(summary)) => (summary, true),
            Err(McapError::Io(error)) => return Err(failed(error)),
            _ => (scan(&mut file, &BTreeSet::new()).map_err(failed)?.summary, false),
        };
        let topics: HashMap<_, _> = summary
            .channels
            .iter()
            .filter_map(|(id, channel)| Some((*id, Topic::from_name(&channel.topic)?)))
            .collect();
        if !topics.values().any(|topic| *topic == Topic::Frames) {
            return Err(ReadingError::NoFrames { path: path.to_owned() });
        }
        Ok(Self { path: path.to_owned(), file, summary, topics, closed })
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Whether it was closed. If not, what came after its last whole chunk is missing.
    pub fn is_closed(&self) -> bool {
        self.closed
    }

    /// Its topics, sorted.
    pub fn topics(&self) -> Vec<Topic> {
        let topics: BTreeSet<_> = self.topics.values().cloned().collect();
        topics.into_iter().collect()
    }

    /// Time of its first and last message.
    pub fn span(&self) -> (Duration, Duration) {
        let stats = self.summary.stats.as_ref();
        let (start, end) = stats.map_or((0, 0), |stats| (stats.message_start_time, stats.message_end_time));
        (Duration::from_nanos(start), Duration::from_nanos(end))
    }

    /// Number of messages on a topic.
    pub fn count(&self, topic: &Topic) -> u64 {
        let counts = self.summary.stats.as_ref().map(|stats| &stats.channel_message_counts);
        let of = |channel: &u16| counts.and_then(|counts| counts.get(channel)).copied().unwrap_or(0);
        self.topics.iter().filter(|(_, other)| *other == topic).map(|(channel, _)| of(channel)).sum()
    }

    /// Reads messages in order of time; those of the same time in the order in which they were recorded.
    pub(crate) fn read(&self, selection: &Selection) -> Result<Reader<'_>, ReadingError> {
        self.reader(IndexedReaderOptions::new().starting_at(selection.from), &selection.topics)
    }

    /// The last message on a topic before or at `time`, and its time.
    pub(crate) fn last_until(&self, topic: &Topic, time: u64) -> Result<Option<(u64, Vec<u8>)>, ReadingError> {
        let options = IndexedReaderOptions::new().ending_at(time).with_order(ReadOrder::ReverseLogTime);
        let mut reader = self.reader(options, std::slice::from_ref(topic))?;
        Ok(reader.next()?.map(|entry| (entry.log_time, entry.message.to_vec())))
    }

    fn reader(&self, options: IndexedReaderOptions, topics: &[Topic]) -> Result<Reader<'_>, ReadingError> {
        let options = options.with_record_length_limit(MAX_RECORD);
        let options = match topics {
            [] => options,
            topics => options.include_topics(topics.iter().map(Topic::name)),
        };
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

    /// Says where a message is that can't be understood.
    pub(crate) fn malformed(&self, topic: &Topic, log_time: u64, reason: MessageError) -> ReadingError {
        let (path, at) = (self.path.clone(), Duration::from_nanos(log_time));
        ReadingError::Message { path, topic: topic.name(), at, reason }
    }
}

/// Hands out a recording's messages one by one.
pub(crate) struct Reader<'recording> {
    recording: &'recording Recording,
    reader: IndexedReader,
    /// The chunk read last, still compressed.
    chunk: Vec<u8>,
    /// The message read last.
    message: Vec<u8>,
    /// Its topic and time, if it was only looked at.
    ahead: Option<(&'recording Topic, u64)>,
}

impl<'recording> Reader<'recording> {
    /// Time of the next message.
    pub fn peek(&mut self) -> Result<Option<u64>, ReadingError> {
        if self.ahead.is_none() {
            let recording = self.recording;
            self.ahead = self.advance().map_err(|error| recording.damaged(error))?;
        }
        Ok(self.ahead.map(|(_, log_time)| log_time))
    }

    /// The next message on one of our topics.
    pub fn next(&mut self) -> Result<Option<Entry<'_>>, ReadingError> {
        self.peek()?;
        Ok(self.ahead.take().map(|(topic, log_time)| Entry { topic, log_time, message: &self.message }))
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

/// What the library calls an error of reading may be damage.
fn undecodable(error: McapError) -> McapError {
    match error {
        McapError::Io(reason) => McapError::DecompressionError(reason.to_string()),
        error => error,
    }
}

/// The summary at a file's end, if the file was closed.
pub(crate) fn summary(file: &mut File) -> McapResult<Option<Summary>> {
    let length = file.seek(SeekFrom::End(0))?;
    let options = SummaryReaderOptions::default().with_file_size(length).with_record_length_limit(MAX_RECORD);
    let mut reader = SummaryReader::new_with_options(options);
    while let Some(event) = reader.next_event() {
        match event? {
            SummaryReadEvent::ReadRequest(wanted) => {
                let read = file.read(reader.insert(wanted))?;
                reader.notify_read(read);
            }
            SummaryReadEvent::SeekRequest(to) => reader.notify_seeked(file.seek(to)?),
        }
    }
    Ok(reader.finish())
}
