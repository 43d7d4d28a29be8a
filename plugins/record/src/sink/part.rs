//! One file of a recording, while it is written.

use std::fs::{File, OpenOptions};
use std::io;
use std::path::{Path, PathBuf};

use mcap::McapResult;
use mcap::records::{MessageHeader, Metadata};

use super::SinkError;
use super::kept::Kept;
use crate::mcap_file::{Compression, McapFile};
use crate::schema::Topic;

/// The size at which a chunk is closed: a kill loses little, and a seek reads little.
const CHUNK_BYTES: u64 = 4 << 20;

/// A message to write.
#[derive(Clone)]
pub(super) struct Queued {
    pub topic: Topic,
    pub header: MessageHeader,
    pub message: Vec<u8>,
}

/// A file of a recording.
pub(super) struct Part {
    pub path: PathBuf,
    pub file: File,
    /// `None` after an error.
    out: Option<McapFile>,
    /// The messages that aren't written yet, by group.
    pending: [Group; GROUPS],
    /// The times of the first and the newest message, in nanoseconds.
    times: Option<(u64, u64)>,
    /// The number of frames accepted.
    pub frames: u64,
    /// The number of messages accepted, frames included.
    pub messages: u64,
    /// The number of messages accepted before the last flush.
    flushed: u64,
}

/// The messages of a group that aren't written yet.
#[derive(Default)]
struct Group {
    messages: Vec<Queued>,
    bytes: u64,
}

/// The number of groups of topics. Each group has chunks of its own, so that a reader of few topics
/// reads little.
const GROUPS: usize = 5;

/// Returns the group of a topic.
fn group(topic: &Topic) -> usize {
    match topic {
        Topic::World | Topic::Events | Topic::Orders | Topic::Tasks | Topic::ContactEvents => 0,
        Topic::Frames => 1,
        Topic::Column(_) => 2,
        Topic::Contacts | Topic::ContactUpdates => 3,
        Topic::Poses | Topic::Robots | Topic::Graph | Topic::GraphPoints => 4,
    }
}

/// Creates a file of a recording.
pub(super) fn create_file(path: &Path, overwrite: bool) -> Result<File, SinkError> {
    let mut options = OpenOptions::new();
    options.read(true).write(true).truncate(overwrite).create(overwrite).create_new(!overwrite);
    options.open(path).map_err(|reason| match reason.kind() {
        io::ErrorKind::AlreadyExists => SinkError::Exists { path: path.to_owned() },
        _ => SinkError::Create { path: path.to_owned(), reason },
    })
}

impl Part {
    /// Starts to write an empty file. Fails at once if not even its header can be written.
    pub fn start(
        path: PathBuf,
        file: File,
        compression: Compression,
        channels: &[Topic],
        about: &[Metadata],
    ) -> (Self, McapResult<()>) {
        let opened = file.try_clone().map_err(Into::into);
        let opened = opened.and_then(|copy| McapFile::create(copy, compression, CHUNK_BYTES));
        let mut part = Self {
            path,
            file,
            out: None,
            pending: Default::default(),
            times: None,
            frames: 0,
            messages: 0,
            flushed: 0,
        };
        let started = opened.and_then(|mut out| {
            // The same topics have the same channels in all files of a recording.
            channels.iter().try_for_each(|topic| out.channel(topic).map(drop))?;
            about.iter().try_for_each(|metadata| out.writer.write_metadata(metadata))?;
            part.out = Some(out);
            Ok(())
        });
        (part, started)
    }

    /// Returns the time from the first message to the newest one, or to a later time, in
    /// nanoseconds.
    pub fn duration_until(&self, log_time: u64) -> u64 {
        self.times.map_or(0, |(first, newest)| newest.max(log_time) - first)
    }

    /// Returns the size of the file so far.
    pub fn bytes(&self) -> u64 {
        self.file.metadata().map_or(0, |metadata| metadata.len())
    }

    /// Returns the size of the file, as if what isn't written yet took as much there as in memory.
    pub fn bytes_at_most(&self) -> u64 {
        self.bytes() + self.pending.iter().map(|group| group.bytes).sum::<u64>()
    }

    /// Takes a message, and writes its group if that has enough for a chunk.
    pub fn take(&mut self, message: Queued, kept: &mut Kept) -> McapResult<()> {
        let time = message.header.log_time;
        let (first, newest) = self.times.unwrap_or((time, time));
        self.times = Some((first.min(time), newest.max(time)));
        self.frames += u64::from(message.topic == Topic::Frames);
        self.messages += 1;
        if let Some(out) = &mut self.out {
            out.channel(&message.topic)?;
        }
        let number = group(&message.topic);
        let group = &mut self.pending[number];
        group.bytes += message.message.len() as u64;
        group.messages.push(message);
        if group.bytes >= CHUNK_BYTES { self.write_group(number, kept) } else { Ok(()) }
    }

    /// Writes metadata.
    pub fn note(&mut self, metadata: &Metadata) -> McapResult<()> {
        self.out.as_mut().map_or(Ok(()), |out| out.writer.write_metadata(metadata))
    }

    /// Writes all messages, and the kept states that are due.
    pub fn flush(&mut self, kept: &mut Kept) -> McapResult<()> {
        match std::mem::replace(&mut self.flushed, self.messages) {
            // Nothing has come, for example because the clock is paused.
            before if before == self.messages => Ok(()),
            before => self.write_all(kept, before > 0),
        }
    }

    /// Writes everything and closes the file.
    pub fn finish(&mut self, kept: &mut Kept, about: Option<&Metadata>) -> McapResult<()> {
        self.write_all(kept, true)?;
        about.map_or(Ok(()), |metadata| self.note(metadata))?;
        self.out.take().map_or(Ok(()), |mut out| out.writer.finish().map(drop))
    }

    fn write_all(&mut self, kept: &mut Kept, again: bool) -> McapResult<()> {
        (0..GROUPS).try_for_each(|group| self.write_group(group, kept))?;
        self.times.map_or(Ok(()), |times| self.write(&kept.due(times, again)))
    }

    /// Gives up writing after an error.
    pub fn abandon(&mut self) {
        self.out = None;
        self.pending = Default::default();
    }

    fn write_group(&mut self, group: usize, kept: &mut Kept) -> McapResult<()> {
        let Group { messages, .. } = std::mem::take(&mut self.pending[group]);
        self.write(&messages)?;
        kept.keep(messages);
        Ok(())
    }

    /// Writes messages as a chunk.
    fn write(&mut self, messages: &[Queued]) -> McapResult<()> {
        let Some(out) = self.out.as_mut().filter(|_| !messages.is_empty()) else { return Ok(()) };
        for Queued { topic, header, message } in messages {
            out.write(topic, *header, message)?;
        }
        out.writer.flush()
    }
}
