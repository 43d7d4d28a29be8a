//! Writes messages to a file on a separate thread, so that a slow disk doesn't delay the recorder.

use std::fs::{File, OpenOptions};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use mcap::records::{MessageHeader, Metadata};
use mcap::{McapError, McapResult};

use crate::mcap_file::{Compression, McapFile};
use crate::reading::Recording;
use crate::repair::close;
use crate::schema::Topic;

/// The size at which a chunk is closed: a kill loses little, and a seek reads little.
const CHUNK_BYTES: u64 = 4 << 20;
/// The age at which a chunk is closed.
const CHUNK_TIME: Duration = Duration::from_secs(1);
/// The largest amount of messages that wait for the disk. Further messages are dropped.
const QUEUE_BYTES: usize = 256 << 20;

/// The error of writing a recording.
#[derive(Debug, thiserror::Error)]
pub enum SinkError {
    /// The file exists already.
    #[error("{path} exists already; give another file with --output, or --force to overwrite it")]
    Exists {
        /// The file.
        path: PathBuf,
    },
    /// The file can't be created.
    #[error("can't create {path} ({reason})")]
    Create {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        reason: io::Error,
    },
    /// The file can't be written, for example because the disk is full.
    #[error("can't write to {path} ({reason})")]
    Write {
        /// The file.
        path: PathBuf,
        /// The reason given by the system or the MCAP library.
        reason: String,
    },
}

/// The numbers of written and dropped messages.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Frames in the file.
    pub frames: u64,
    /// Bytes in the file.
    pub bytes: u64,
    /// Frames dropped because the disk was too slow.
    pub frames_dropped: u64,
    /// Frames dropped because the disk was full or failed.
    pub frames_failed: u64,
    /// Other messages that were dropped, for either reason.
    pub others_dropped: u64,
}

/// A job of the thread that writes the file.
enum Job {
    Message {
        topic: Topic,
        header: MessageHeader,
        message: Vec<u8>,
    },
    /// Metadata of the recording.
    About(Metadata),
}

/// The queue of messages to a file.
#[derive(Debug)]
pub(crate) struct Sink {
    jobs: Option<Sender<Job>>,
    queued: Arc<AtomicUsize>,
    thread: Option<JoinHandle<(Tally, Option<SinkError>)>>,
    /// The messages that were dropped because the queue was full.
    dropped: Tally,
}

impl Sink {
    /// Creates a file and starts the thread that writes it.
    ///
    /// # Errors
    /// Returns a [`SinkError`] if the file can't be created, or if it exists and `overwrite` is false.
    pub fn create(path: &Path, overwrite: bool, compression: Compression) -> Result<Self, SinkError> {
        let mut options = OpenOptions::new();
        options.read(true).write(true).truncate(overwrite).create(overwrite).create_new(!overwrite);
        let failed = |reason| SinkError::Create { path: path.to_owned(), reason };
        let file = options.open(path).map_err(|reason| match reason.kind() {
            io::ErrorKind::AlreadyExists => SinkError::Exists { path: path.to_owned() },
            _ => failed(reason),
        })?;
        let drain = Drain {
            path: path.to_owned(),
            file: file.try_clone().map_err(failed)?,
            queued: Arc::default(),
            tally: Tally::default(),
        };
        let queued = Arc::clone(&drain.queued);
        let (sender, jobs) = channel();
        let thread = std::thread::Builder::new()
            .name("recording".to_owned())
            .spawn(move || drain.run(file, compression, &jobs))
            .map_err(failed)?;
        Ok(Self { jobs: Some(sender), queued, thread: Some(thread), dropped: Tally::default() })
    }

    /// Queues a message, or drops it if the queue is full. Never blocks.
    pub fn send(&mut self, topic: Topic, log_time: u64, publish_time: u64, message: Vec<u8>) {
        let bytes = message.len();
        let queued = self.queued.load(Ordering::Relaxed);
        // An empty queue accepts any message, because a single one may exceed the limit.
        if queued > 0 && queued + bytes > QUEUE_BYTES {
            *self.dropped.of(&topic, false) += 1;
            return;
        }
        self.queued.fetch_add(bytes, Ordering::Relaxed);
        let header = MessageHeader { channel_id: 0, sequence: 0, log_time, publish_time };
        self.hand_over(Job::Message { topic, header, message });
    }

    /// Queues metadata of the recording.
    pub fn note(&mut self, name: &str, facts: &[(&str, String)]) {
        let metadata = facts.iter().map(|(key, value)| ((*key).to_owned(), value.clone())).collect();
        self.hand_over(Job::About(Metadata { name: name.to_owned(), metadata }));
    }

    fn hand_over(&self, job: Job) {
        if let Some(jobs) = &self.jobs {
            // Sending fails only if the thread has panicked, which `finish` handles.
            let _ = jobs.send(job);
        }
    }

    /// Waits until all messages are written, closes the file, and returns the counts and the first error.
    pub fn finish(&mut self) -> (Tally, Option<SinkError>) {
        self.jobs = None;
        let outcome = self.thread.take().and_then(|thread| thread.join().ok());
        let (written, error) = outcome.unwrap_or_default();
        let tally = Tally {
            frames_dropped: self.dropped.frames_dropped,
            others_dropped: written.others_dropped + self.dropped.others_dropped,
            ..written
        };
        (tally, error)
    }
}

impl Tally {
    /// Returns the count of dropped messages for `topic`.
    fn of(&mut self, topic: &Topic, failed: bool) -> &mut u64 {
        match topic {
            Topic::Frames if failed => &mut self.frames_failed,
            Topic::Frames => &mut self.frames_dropped,
            _ => &mut self.others_dropped,
        }
    }
}

/// The state of the thread that writes the file.
struct Drain {
    path: PathBuf,
    file: File,
    queued: Arc<AtomicUsize>,
    tally: Tally,
}

impl Drain {
    fn run(mut self, file: File, compression: Compression, jobs: &Receiver<Job>) -> (Tally, Option<SinkError>) {
        let written = McapFile::create(file, compression, CHUNK_BYTES).and_then(|mut out| self.write(&mut out, jobs));
        let error = written.err().map(|error| self.give_up(&error, jobs));
        self.tally.bytes = self.file.metadata().map_or(0, |metadata| metadata.len());
        (self.tally, error)
    }

    /// Writes until the queue is closed.
    fn write(&mut self, out: &mut McapFile, jobs: &Receiver<Job>) -> McapResult<()> {
        let mut chunk_ends = Instant::now() + CHUNK_TIME;
        loop {
            match jobs.recv_timeout(chunk_ends.saturating_duration_since(Instant::now())) {
                Ok(Job::Message { topic, header, message }) => {
                    self.queued.fetch_sub(message.len(), Ordering::Relaxed);
                    self.tally.frames += u64::from(topic == Topic::Frames);
                    out.write(&topic, header, &message)?;
                }
                Ok(Job::About(metadata)) => out.writer.write_metadata(&metadata)?,
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return out.writer.finish().map(drop),
            }
            if Instant::now() >= chunk_ends {
                out.writer.flush()?;
                chunk_ends = Instant::now() + CHUNK_TIME;
            }
        }
    }

    /// Reports at once that the recording ends here, closes the file, and counts the messages that arrive afterwards.
    fn give_up(&mut self, error: &McapError, jobs: &Receiver<Job>) -> SinkError {
        let reason = match error {
            McapError::Io(error) => error.to_string(),
            error => error.to_string(),
        };
        let accepted = self.tally.frames;
        self.tally.frames = close(&mut self.file).ok().and_then(|_| frames_in(&self.path)).unwrap_or(0);
        self.tally.frames_failed = accepted.saturating_sub(self.tally.frames);
        regatta_plugin::tell!(
            "record: can't write to {} ({reason}): nothing is recorded from here on",
            self.path.display()
        );
        for job in jobs {
            if let Job::Message { topic, message, .. } = job {
                self.queued.fetch_sub(message.len(), Ordering::Relaxed);
                *self.tally.of(&topic, true) += 1;
            }
        }
        SinkError::Write { path: self.path.clone(), reason }
    }
}

/// Returns the number of frames that a reader finds in a file.
fn frames_in(path: &Path) -> Option<u64> {
    Recording::open(path).ok().map(|recording| recording.count(&Topic::Frames))
}
