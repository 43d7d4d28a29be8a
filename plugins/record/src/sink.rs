//! Writes messages to files on a separate thread, so that a slow disk doesn't delay the recorder.

mod drain;
mod join;
mod part;
mod parts;
#[cfg(test)]
pub(crate) mod tests;

use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::mpsc::{Sender, channel};
use std::thread::JoinHandle;
use std::time::Duration;

use mcap::records::{MessageHeader, Metadata};
use regatta_plugin::Finishing;

use crate::contacts::ContactList;
use crate::mcap_file::Compression;
use crate::schema::Topic;
use drain::Drain;
pub(crate) use parts::Division;

/// The largest amount of messages that wait for the disk. Further messages are dropped.
const QUEUE_BYTES: usize = 256 << 20;
/// The time between two looks at the progress of the thread at the end.
const POLL_INTERVAL: Duration = Duration::from_millis(5);

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

/// The settings of a sink.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Settings {
    /// Whether existing files are overwritten.
    pub overwrite: bool,
    pub compression: Compression,
    pub division: Division,
}

/// The numbers of messages that were lost.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Lost {
    /// Frames dropped because the disk was too slow.
    pub frames_dropped: u64,
    /// Frames dropped because the disk was full or failed.
    pub frames_failed: u64,
    /// Other messages that were dropped, for either reason.
    pub others: u64,
}

/// The contents of the files that a sink has written.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tally {
    /// The file, or the first and the last one.
    pub name: String,
    /// Frames in the files.
    pub frames: u64,
    /// Bytes in the files.
    pub bytes: u64,
    /// The growth of the files, and the time for which the disk would last.
    pub growth: String,
    pub lost: Lost,
}

impl Lost {
    /// Returns the count of lost messages for `topic`.
    fn of(&mut self, topic: &Topic, failed: bool) -> &mut u64 {
        match topic {
            Topic::Frames if failed => &mut self.frames_failed,
            Topic::Frames => &mut self.frames_dropped,
            _ => &mut self.others,
        }
    }
}

/// The content of one message.
#[derive(Debug)]
pub(crate) enum Payload {
    /// An encoded message.
    Message(Vec<u8>),
    /// Contacts, which are encoded as changes.
    Contacts(ContactList),
}

impl Payload {
    fn len(&self) -> usize {
        match self {
            Self::Message(message) => message.len(),
            Self::Contacts(list) => size_of_val(&list.pairs[..]),
        }
    }
}

/// A job of the thread that writes the files.
enum Job {
    Message {
        topic: Topic,
        header: MessageHeader,
        payload: Payload,
    },
    /// Metadata that each file begins with.
    About(Metadata),
    /// The end, with metadata that the last file ends with.
    End(Metadata),
}

/// The queue of messages to the files of a recording.
#[derive(Debug)]
pub(crate) struct Sink {
    jobs: Option<Sender<Job>>,
    queued: Arc<AtomicUsize>,
    /// The number of messages, and of blocks of files, that are written.
    progress: Arc<AtomicU64>,
    thread: Option<JoinHandle<(Tally, Option<SinkError>)>>,
    /// The messages that were dropped because the queue was full.
    dropped: Lost,
}

impl Sink {
    /// Creates the first file and starts the thread that writes it.
    ///
    /// # Errors
    /// Returns a [`SinkError`] if the file can't be created, or if it exists and isn't to be
    /// overwritten.
    pub fn create(path: &Path, settings: Settings) -> Result<Self, SinkError> {
        let (queued, progress) = (Arc::default(), Arc::default());
        let drain = Drain::create(path, settings, Arc::clone(&queued), Arc::clone(&progress))?;
        let (sender, jobs) = channel();
        let thread = std::thread::Builder::new()
            .name("recording".to_owned())
            .spawn(move || drain.run(&jobs));
        let thread =
            thread.map_err(|reason| SinkError::Create { path: path.to_owned(), reason })?;
        let (jobs, thread) = (Some(sender), Some(thread));
        Ok(Self { jobs, queued, progress, thread, dropped: Lost::default() })
    }

    /// Queues a message, or drops it if the queue is full. Never blocks.
    pub fn send(&mut self, topic: Topic, log_time: u64, publish_time: u64, payload: Payload) {
        let bytes = payload.len();
        let queued = self.queued.load(Ordering::Relaxed);
        // An empty queue accepts any message, because a single one may exceed the limit.
        if queued > 0 && queued + bytes > QUEUE_BYTES {
            *self.dropped.of(&topic, false) += 1;
            return;
        }
        self.queued.fetch_add(bytes, Ordering::Relaxed);
        let header = MessageHeader { channel_id: 0, sequence: 0, log_time, publish_time };
        self.hand_over(Job::Message { topic, header, payload });
    }

    /// Queues metadata that each file begins with.
    pub fn note(&mut self, name: &str, facts: &[(&str, String)]) {
        self.hand_over(Job::About(metadata(name, facts)));
    }

    fn hand_over(&self, job: Job) {
        if let Some(jobs) = &self.jobs {
            // Sending fails only if the thread has panicked, which `finish` handles.
            let _ = jobs.send(job);
        }
    }

    /// Waits until all messages are written, closes the last file with metadata, and returns the
    /// counts and the first error.
    pub fn finish(&mut self, name: &str, facts: &[(&str, String)]) -> (Tally, Option<SinkError>) {
        self.hand_over(Job::End(metadata(name, facts)));
        self.jobs = None;
        let outcome = self.thread.take().and_then(|thread| {
            self.await_end(&thread);
            thread.join().ok()
        });
        let (mut tally, error) = outcome.unwrap_or_default();
        tally.lost.frames_dropped = self.dropped.frames_dropped;
        tally.lost.others += self.dropped.others;
        (tally, error)
    }

    /// Waits for the thread, and says that it saves its work as long as it does.
    fn await_end<T>(&self, thread: &JoinHandle<T>) {
        let mut finishing = Finishing::begin();
        let mut before = 0;
        while !thread.is_finished() {
            let now = self.progress.load(Ordering::Relaxed);
            if std::mem::replace(&mut before, now) != now {
                finishing.goes_on();
            }
            std::thread::sleep(POLL_INTERVAL);
        }
    }
}

fn metadata(name: &str, facts: &[(&str, String)]) -> Metadata {
    let metadata = facts.iter().map(|(key, value)| ((*key).to_owned(), value.clone())).collect();
    Metadata { name: name.to_owned(), metadata }
}
