//! Reads recordings in order of time. Only the requested part of a file is read.

mod index;
mod reader;
mod state;

use std::collections::{BTreeSet, HashMap};
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::time::Duration;

use mcap::sans_io::{
    IndexedReader, IndexedReaderOptions, SummaryReadEvent, SummaryReader, SummaryReaderOptions,
};
use mcap::{McapError, McapResult, Summary};

use crate::decode::MessageError;
use crate::mcap_record::MAX_RECORD;
use crate::progress::Progress;
use crate::scan::scan;
use crate::schema::Topic;
pub(crate) use reader::Reader;

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
    #[error(
        "can't read {path} as a recording ({reason}); `regatta record --repair` keeps its undamaged parts"
    )]
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

/// A recording on disk. Only a few chunks of its messages are in memory at a time.
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

    /// Whether the recording was closed. If not, the messages after its last complete chunk are
    /// missing.
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
        let (start, end) =
            stats.map_or((0, 0), |stats| (stats.message_start_time, stats.message_end_time));
        (Duration::from_nanos(start), Duration::from_nanos(end))
    }

    /// Returns the number of messages on a topic.
    pub fn count(&self, topic: &Topic) -> u64 {
        let counts = self.summary.stats.as_ref().map(|stats| &stats.channel_message_counts);
        let of =
            |channel: &u16| counts.and_then(|counts| counts.get(channel)).copied().unwrap_or(0);
        self.topics
            .iter()
            .filter(|(_, other)| *other == topic)
            .map(|(channel, _)| of(channel))
            .sum()
    }

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
        let is_recorded = |topic: &Topic| self.topics.values().any(|recorded| recorded == topic);
        let options = match topics {
            [] => options,
            topics if topics.iter().any(is_recorded) => {
                options.include_topics(topics.iter().map(Topic::name))
            }
            // Nothing: with topics that don't exist, the reader would read all messages.
            _ => IndexedReaderOptions::new().starting_at(0).ending_before(0),
        };
        let options = options.with_record_length_limit(MAX_RECORD);
        let reader = IndexedReader::new_with_options(&self.summary, options)
            .map_err(|error| self.damaged(error))?;
        Ok(Reader::new(self, reader))
    }

    fn damaged(&self, reason: McapError) -> ReadingError {
        let path = self.path.clone();
        match reason {
            McapError::Io(reason) => ReadingError::Io { path, reason },
            reason => ReadingError::Mcap { path, reason },
        }
    }

    /// Returns the error of an invalid message, with the message's topic and time.
    pub(crate) fn malformed(
        &self,
        topic: &Topic,
        log_time: u64,
        reason: MessageError,
    ) -> ReadingError {
        let (path, at) = (self.path.clone(), Duration::from_nanos(log_time));
        ReadingError::Message { path, topic: topic.name(), at, reason }
    }
}

/// Reads the summary at the end of a file. Returns `None` if the file was never closed.
pub(crate) fn summary(file: &mut File) -> McapResult<Option<Summary>> {
    let length = file.seek(SeekFrom::End(0))?;
    let options =
        SummaryReaderOptions::default().with_file_size(length).with_record_length_limit(MAX_RECORD);
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
