//! Reads recordings in order of time. Only the requested part of a file is read.

mod index;
mod reader;

use std::collections::{BTreeSet, HashMap};
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::time::Duration;

use mcap::sans_io::{SummaryReadEvent, SummaryReader, SummaryReaderOptions};
use mcap::{McapError, McapResult, Summary};

use crate::decode::MessageError;
use crate::mcap_file::{MAX_RECORD, most_content, topic_of};
use crate::progress::Progress;
use crate::scan::scan;
use crate::schema::Topic;
pub(crate) use reader::{Entry, Reader, Selection};

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
        "can't read {path} as a recording ({reason}); \
         `regatta record --repair` keeps its undamaged parts"
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
    /// The file would grow out of all proportion.
    #[error(
        "{path} claims to hold {content} bytes in a file of {bytes}: it isn't read, because no \
         recording of a fleet is compressed like this"
    )]
    Bomb {
        /// The file.
        path: PathBuf,
        /// The bytes of its chunks when they are decompressed, as the file says.
        content: u64,
        /// The bytes of the file.
        bytes: u64,
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
    /// The topic of each channel that this crate knows.
    topics: HashMap<u16, Topic>,
    is_closed: bool,
}

impl Recording {
    /// Opens a recording. One that was never closed is first scanned up to its last complete chunk.
    ///
    /// # Errors
    /// Returns a [`ReadingError`] if the file can't be read or isn't a recording.
    pub fn open(path: &Path) -> Result<Self, ReadingError> {
        let opened = regatta_base::file::open(path, u64::MAX);
        let mut file = opened.map_err(|reason| unreadable(path, reason))?;
        let (summary, is_closed) = match summary(&mut file) {
            Ok(Some(summary)) => (summary, true),
            Err(McapError::Io(reason)) => return Err(unreadable(path, reason)),
            _ => {
                let mut progress = Progress::start("reading");
                let scan = scan(&mut file, &BTreeSet::new(), &mut progress);
                (scan.map_err(|reason| unreadable(path, reason))?.summary, false)
            }
        };
        check_content(path, &file, &summary)?;
        let channels = summary.channels.iter();
        let topics: HashMap<_, _> =
            channels.filter_map(|(id, channel)| Some((*id, topic_of(channel)?))).collect();
        if !topics.values().any(|topic| topic.schema().starts_with("regatta.")) {
            return Err(ReadingError::NoFleet { path: path.to_owned() });
        }
        Ok(Self { path: path.to_owned(), file, summary, topics, is_closed })
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
        self.is_closed
    }

    /// Returns the topics, sorted.
    pub fn topics(&self) -> Vec<Topic> {
        let topics: BTreeSet<_> = self.topics.values().cloned().collect();
        topics.into_iter().collect()
    }

    /// Returns the times of the first and the last message.
    pub fn span(&self) -> (Duration, Duration) {
        let Some(stats) = &self.summary.stats else { return Default::default() };
        let (start, end) = (stats.message_start_time, stats.message_end_time);
        (Duration::from_nanos(start), Duration::from_nanos(end))
    }

    /// Returns the number of messages on a topic.
    pub fn count(&self, topic: &Topic) -> u64 {
        let Some(stats) = &self.summary.stats else { return 0 };
        let counts = &stats.channel_message_counts;
        let counts = self.channels(topic).filter_map(|channel| counts.get(&channel));
        counts.fold(0, |sum, count| sum.saturating_add(*count))
    }

    /// Returns the channels of a topic.
    fn channels(&self, topic: &Topic) -> impl Iterator<Item = u16> {
        self.topics.iter().filter(move |(_, other)| *other == topic).map(|(channel, _)| *channel)
    }

    fn damaged(&self, reason: McapError) -> ReadingError {
        match reason {
            McapError::Io(reason) => unreadable(&self.path, reason),
            reason => ReadingError::Mcap { path: self.path.clone(), reason },
        }
    }

    /// Adds a message's topic and time to an error of decoding it.
    pub(crate) fn located<T>(
        &self,
        topic: &Topic,
        log_time: u64,
        decoded: Result<T, MessageError>,
    ) -> Result<T, ReadingError> {
        decoded.map_err(|reason| ReadingError::Message {
            path: self.path.clone(),
            topic: topic.name(),
            at: Duration::from_nanos(log_time),
            reason,
        })
    }
}

/// Checks that the chunks of a recording aren't much larger than its file.
fn check_content(path: &Path, file: &File, summary: &Summary) -> Result<(), ReadingError> {
    let bytes = file.metadata().map_err(|reason| unreadable(path, reason))?.len();
    let sizes = summary.chunk_indexes.iter().map(|chunk| chunk.uncompressed_size);
    let content = sizes.fold(0, u64::saturating_add);
    if content > most_content(bytes) {
        return Err(ReadingError::Bomb { path: path.to_owned(), content, bytes });
    }
    Ok(())
}

fn unreadable(path: &Path, reason: io::Error) -> ReadingError {
    ReadingError::Io { path: path.to_owned(), reason }
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

#[cfg(test)]
mod tests {
    use mcap::records::ChunkIndex;

    use super::*;

    fn chunk(uncompressed_size: u64) -> ChunkIndex {
        ChunkIndex {
            message_start_time: 0,
            message_end_time: 0,
            chunk_start_offset: 8,
            chunk_length: 100,
            message_index_offsets: Default::default(),
            message_index_length: 0,
            compression: "zstd".to_owned(),
            compressed_size: 100,
            uncompressed_size,
        }
    }

    #[test]
    fn a_small_file_that_claims_to_hold_gigabytes_is_refused() {
        let file = tempfile::tempfile().expect("a file");
        file.set_len(262_144).expect("a length");
        let mut summary = Summary { chunk_indexes: vec![chunk(64 << 20); 4], ..Summary::default() };
        assert!(check_content(Path::new("a.mcap"), &file, &summary).is_ok());
        for claims in [vec![chunk(1 << 30); 8], vec![chunk(u64::MAX); 2]] {
            summary.chunk_indexes = claims;
            let error = check_content(Path::new("a.mcap"), &file, &summary).expect_err("a bomb");
            assert!(error.to_string().contains("in a file of 262144"), "{error}");
        }
    }
}
