//! The thread that writes a recording's files.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::{Duration, Instant};

use mcap::records::{MessageHeader, Metadata};
use mcap::{McapError, McapResult};

use super::join::join;
use super::part::{Kept, Part, Queued};
use super::parts::Parts;
use super::{Job, Lost, Payload, Settings, SinkError, Tally};
use crate::contacts::ContactEncoder;
use crate::disk::{self, Growth};
use crate::mcap_file::Compression;
use crate::progress::Progress;
use crate::reading::Recording;
use crate::repair;
use crate::schema::Topic;

/// The age at which a chunk is closed.
const CHUNK_TIME: Duration = Duration::from_secs(1);
/// After a full disk, the recording continues when the disk has room for this many bytes.
const ROOM_TO_RESUME: u64 = 32 << 20;

/// The state of the thread that writes the files.
pub(super) struct Drain {
    path: PathBuf,
    compression: Compression,
    parts: Parts,
    target: Target,
    queued: Arc<AtomicUsize>,
    /// Counts what is written.
    progress: Arc<AtomicU64>,
    /// The metadata that each file begins with.
    about: Vec<Metadata>,
    /// The topics so far, in the order of their channels.
    channels: Vec<Topic>,
    kept: Kept,
    contacts: ContactEncoder,
    growth: Growth,
    /// The time of the first message.
    started: Option<Instant>,
    lost: Lost,
    first_error: Option<SinkError>,
    tally: Tally,
}

/// The destination of messages.
enum Target {
    /// A file.
    File(Box<Part>),
    /// Nothing is written while the disk is full. Holds the losses before that.
    Full(Lost),
    /// Nothing is written any more.
    Nowhere,
}

impl Drain {
    /// Creates the first file.
    pub fn create(
        path: &Path,
        settings: Settings,
        queued: Arc<AtomicUsize>,
        progress: Arc<AtomicU64>,
    ) -> Result<Self, SinkError> {
        let mut drain = Self {
            path: path.to_owned(),
            compression: settings.compression,
            parts: Parts::new(path, settings.division, settings.overwrite),
            target: Target::Nowhere,
            queued,
            progress,
            about: Vec::new(),
            channels: Vec::new(),
            kept: Kept::default(),
            contacts: ContactEncoder::default(),
            growth: Growth::default(),
            started: None,
            lost: Lost::default(),
            first_error: None,
            tally: Tally::default(),
        };
        drain.start_part()?;
        Ok(drain)
    }

    /// Writes until the queue is closed.
    pub fn run(mut self, jobs: &Receiver<Job>) -> (Tally, Option<SinkError>) {
        let mut chunk_ends = Instant::now() + CHUNK_TIME;
        loop {
            match jobs.recv_timeout(chunk_ends.saturating_duration_since(Instant::now())) {
                Ok(Job::Message { topic, header, payload }) => {
                    self.queued.fetch_sub(payload.len(), Ordering::Relaxed);
                    self.take(topic, header, payload);
                    self.progress.fetch_add(1, Ordering::Relaxed);
                }
                Ok(Job::About(metadata)) => self.note(metadata),
                Ok(Job::End(metadata)) => self.end(&metadata),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return (self.tally, self.first_error),
            }
            if Instant::now() >= chunk_ends {
                self.each_second();
                chunk_ends = Instant::now() + CHUNK_TIME;
            }
        }
    }

    /// Adds metadata that each file begins with.
    fn note(&mut self, metadata: Metadata) {
        if let Target::File(part) = &mut self.target {
            let written = part.note(&metadata);
            self.check(written);
        }
        self.about.push(metadata);
    }

    fn take(&mut self, topic: Topic, header: MessageHeader, payload: Payload) {
        self.started.get_or_insert_with(Instant::now);
        if let Target::File(part) = &self.target
            && topic == Topic::Frames
            && self.parts.is_complete(part, header.log_time)
        {
            self.start_next_part();
        }
        let Self { target: Target::File(part), kept, contacts, channels, .. } = self else {
            *self.lost.of(&topic, true) += 1;
            return;
        };
        let (topic, message) = match payload {
            Payload::Message(message) => (topic, message),
            Payload::Contacts(list) => contacts.encode(header.log_time, list),
        };
        if !channels.contains(&topic) {
            channels.push(topic.clone());
        }
        let written = part.take(Queued { topic, header, message }, kept);
        self.check(written);
    }

    /// Returns the time since the first message.
    fn time(&self) -> Duration {
        self.started.map_or(Duration::ZERO, |started| started.elapsed())
    }

    fn each_second(&mut self) {
        let now = self.time();
        match &mut self.target {
            Target::File(part) => {
                let written = part.flush(&mut self.kept);
                let bytes = part.bytes() + self.closed_bytes();
                let free = disk::free_space(&self.path);
                if let Some(line) = self.growth.observe(now, bytes, free) {
                    regatta_plugin::tell!("record: {}: {line}", self.path.display());
                }
                self.check(written);
            }
            Target::Full(_) => self.resume_if_room(),
            Target::Nowhere => {}
        }
    }

    fn closed_bytes(&self) -> u64 {
        self.parts.closed.iter().map(|part| part.bytes).sum()
    }

    /// Closes the current file and starts the next one.
    fn start_next_part(&mut self) {
        let Target::File(part) = &mut self.target else { return };
        let written = part.finish(&mut self.kept, None);
        if written.is_err() {
            return self.check(written);
        }
        self.parts.close(part, part.frames);
        self.start_another_part();
    }

    /// Starts a file.
    fn start_part(&mut self) -> Result<(), SinkError> {
        let (path, file) = self.parts.create()?;
        let (part, started) =
            Part::start(path, file, self.compression, &self.channels, &self.about);
        self.target = Target::File(Box::new(part));
        self.kept.start_file();
        self.contacts.restart();
        self.check(started);
        Ok(())
    }

    /// Starts another file, or gives up if it can't be created.
    fn start_another_part(&mut self) {
        if let Err(error) = self.start_part() {
            regatta_plugin::tell!("record: {error}: nothing is recorded from now on");
            self.first_error.get_or_insert(error);
            self.target = Target::Nowhere;
        }
    }

    /// Handles an error of writing: closes the file after the last chunk that fits, and counts the
    /// lost messages.
    fn check(&mut self, written: McapResult<()>) {
        let (Err(error), Target::File(part)) = (written, &mut self.target) else { return };
        let before = self.lost;
        part.abandon();
        let repaired = repair::close(&mut part.file, &mut Progress::hidden());
        let messages = repaired.map_or(0, |repair| repair.messages);
        let frames = frames_in(&part.path).unwrap_or(0);
        let frames_failed = part.frames.saturating_sub(frames);
        self.lost.frames_failed += frames_failed;
        self.lost.others += part.messages.saturating_sub(messages).saturating_sub(frames_failed);
        self.parts.close(part, frames);
        let path = part.path.clone();
        let reason = match &error {
            McapError::Io(error) => error.to_string(),
            error => error.to_string(),
        };
        let next = if is_full(&error) {
            self.target = Target::Full(before);
            "until there is room again"
        } else {
            self.target = Target::Nowhere;
            "from now on"
        };
        regatta_plugin::tell!(
            "record: can't write to {} ({reason}): nothing is recorded {next}",
            path.display()
        );
        self.first_error.get_or_insert(SinkError::Write { path, reason });
    }

    /// Goes on in another file if the disk has room again.
    fn resume_if_room(&mut self) {
        let Target::Full(before) = &self.target else { return };
        if disk::free_space(&self.path).is_some_and(|free| free >= ROOM_TO_RESUME) {
            let frames = self.lost.frames_failed - before.frames_failed;
            let others = self.lost.others - before.others;
            self.start_another_part();
            if let Target::File(part) = &self.target {
                let path = part.path.display();
                regatta_plugin::tell!(
                    "record: there is room again: the recording goes on in {path}; {frames} frames \
                     and {others} other messages were lost meanwhile"
                );
            }
        }
    }

    /// Closes the last file, joins the files of a ring, and completes the tally.
    fn end(&mut self, about: &Metadata) {
        let time = self.time();
        if let Target::File(part) = &mut self.target {
            let written = part.finish(&mut self.kept, Some(about));
            if written.is_ok() {
                self.parts.close(part, part.frames);
            }
            self.check(written);
        }
        self.target = Target::Nowhere;
        let closed = &self.parts.closed;
        self.tally.frames = closed.iter().map(|part| part.frames).sum();
        self.tally.bytes = self.closed_bytes();
        self.tally.lost = self.lost;
        self.tally.name = self.parts.name();
        self.tally.growth = disk::summary(self.tally.bytes, time, disk::free_space(&self.path));
        if let Some((path, parts)) = self.parts.ring() {
            match join(path, parts, &self.progress) {
                Ok(()) => self.tally.name = path.display().to_string(),
                Err(error) => {
                    regatta_plugin::tell!("record: the files of the ring aren't joined: {error}")
                }
            }
        }
    }
}

/// Whether an error is caused by a lack of room, which may be temporary.
fn is_full(error: &McapError) -> bool {
    let McapError::Io(error) = error else { return false };
    matches!(error.kind(), io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded)
}

/// Returns the number of frames that a reader finds in a file.
fn frames_in(path: &Path) -> Option<u64> {
    Recording::open(path).ok().map(|recording| recording.count(&Topic::Frames))
}
