//! One file of a recording that is being written.

use std::collections::BTreeMap;
use std::fs::{File, OpenOptions};
use std::io;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use mcap::McapResult;
use mcap::records::{MessageHeader, Metadata};

use super::SinkError;
use crate::encode::mark_repeated;
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
        Topic::World | Topic::Events | Topic::Commands | Topic::Orders => 0,
        Topic::ContactEvents | Topic::Facilities => 0,
        Topic::Frames => 1,
        Topic::Column(_) => 2,
        Topic::Contacts | Topic::ContactUpdates => 3,
        Topic::Poses | Topic::Robots | Topic::ContactMarkers => 4,
        Topic::Graph | Topic::GraphPoints => 4,
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
        let started = part.write_start(compression, channels, about);
        (part, started)
    }

    fn write_start(
        &mut self,
        compression: Compression,
        channels: &[Topic],
        about: &[Metadata],
    ) -> McapResult<()> {
        let mut out = McapFile::create(self.file.try_clone()?, compression, CHUNK_BYTES)?;
        // The same topics have the same channels in all files of a recording.
        for topic in channels {
            out.channel(topic)?;
        }
        for metadata in about {
            out.writer.write_metadata(metadata)?;
        }
        self.out = Some(out);
        Ok(())
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

    /// Returns the size of the file if the pending messages took as much there as in memory.
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
        match &mut self.out {
            Some(out) => out.writer.write_metadata(metadata),
            None => Ok(()),
        }
    }

    /// Writes all messages, and the kept states that are due.
    pub fn flush(&mut self, kept: &mut Kept) -> McapResult<()> {
        let before = std::mem::replace(&mut self.flushed, self.messages);
        // Nothing has come, for example because the clock is paused.
        if before == self.messages {
            return Ok(());
        }
        self.write_all(kept, before > 0)
    }

    /// Writes everything and closes the file.
    pub fn finish(&mut self, kept: &mut Kept, about: Option<&Metadata>) -> McapResult<()> {
        self.write_all(kept, true)?;
        if let Some(metadata) = about {
            self.note(metadata)?;
        }
        match self.out.take() {
            Some(mut out) => out.writer.finish().map(drop),
            None => Ok(()),
        }
    }

    fn write_all(&mut self, kept: &mut Kept, again: bool) -> McapResult<()> {
        for group in 0..GROUPS {
            self.write_group(group, kept)?;
        }
        match self.times {
            Some(times) => self.write(&kept.due(times, again)),
            None => Ok(()),
        }
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

/// The time after which a state that hasn't changed is repeated.
const REPEAT_PERIOD: Duration = Duration::from_mins(1);

/// The number of copies, in different chunks, that are written as soon as possible, so that no
/// damaged chunk has the only one.
const ENOUGH: u8 = 2;

/// The newest message of each topic that is worth repeating: the world, columns, doors and lifts.
/// They are repeated in the recording, so that neither damage nor a reader that starts in the
/// middle misses them.
#[derive(Default)]
pub(super) struct Kept {
    states: BTreeMap<Topic, State>,
}

struct State {
    state: Queued,
    written: Instant,
    /// The number of its copies in the current file, up to [`ENOUGH`].
    copies: u8,
}

impl Kept {
    /// Keeps messages that were written.
    fn keep(&mut self, written: Vec<Queued>) {
        let now = Instant::now();
        for state in written.into_iter().filter(|message| message.topic.is_repeated()) {
            let topic = state.topic.clone();
            let before = self.states.get(&topic).map_or(0, |before| before.copies);
            // Topics that change often need no copies.
            let changes_often = topic.column().is_some() || topic == Topic::Facilities;
            let copies = if changes_often { (before + 1).min(ENOUGH) } else { 1 };
            self.states.insert(topic, State { state, written: now, copies });
        }
    }

    /// Starts another file, which has none of the states yet.
    pub fn start_file(&mut self) {
        for state in self.states.values_mut() {
            state.copies = 0;
        }
    }

    /// Returns the states to repeat now, in a separate chunk: those that the file doesn't have yet.
    /// The first and the newest time of the file are given. With `again`, it also returns states
    /// that the file has only once, or that haven't been written for a while.
    fn due(&mut self, (first, newest): (u64, u64), again: bool) -> Vec<Queued> {
        let now = Instant::now();
        let mut due = Vec::new();
        for State { state, written, copies } in self.states.values_mut() {
            let is_old = *copies < ENOUGH || now.duration_since(*written) >= REPEAT_PERIOD;
            if *copies > 0 && !(again && is_old) {
                continue;
            }
            let mut repeated = state.clone();
            let log_time = if *copies == 0 { first } else { newest };
            repeated.header.log_time = log_time.max(repeated.header.log_time);
            if matches!(repeated.topic, Topic::World | Topic::Column(_)) {
                mark_repeated(&mut repeated.message);
            }
            (*written, *copies) = (now, (*copies + 1).min(ENOUGH));
            due.push(repeated);
        }
        due
    }
}
