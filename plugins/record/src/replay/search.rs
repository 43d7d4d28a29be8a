//! The searches of a recording, each on a thread of its own. A replay starts at once: the first
//! search is for marks and closures, which only chunks with events have, then for the history of
//! its runs, for which all frames are read. Dragging the playhead stays smooth: after a jump, the
//! list of contacts is decoded from up to a hundred changes. The notes beside a recording are read
//! here, too.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{self, Receiver, Sender};
use std::time::{Duration, Instant};

use regatta_plugin::contact::{ContactChange, ContactLevel};
use regatta_plugin::event::EventKind;
use regatta_plugin::recording::{MarkKind, RecordingMark};

use super::closures::ClosureChange;
use super::history::{self, RecordedHistory};
use crate::contacts::ContactDecoder;
use crate::decode::{self, MessageError};
use crate::reading::{Entry, ReadingError, Recording, Selection};
use crate::schema::Topic;

/// The maximum number of marks that are kept.
pub(super) const MAX_MARKS: usize = 65_536;
/// The time between two messages of the search.
const TELL_EVERY: Duration = Duration::from_millis(250);

/// The marks and closures that were found since the last message of the search.
#[derive(Debug, Default)]
pub(super) struct FoundMarks {
    /// In the order of time.
    pub marks: Vec<RecordingMark>,
    /// Edges that were closed and opened.
    pub closures: Vec<ClosureChange>,
    /// The time up to which the recording has been searched.
    pub until: u64,
}

/// A message of the search.
#[derive(Debug)]
pub(super) enum Found {
    Marks(FoundMarks),
    History(RecordedHistory),
}

/// Starts a search. The thread ends with the recording, at its first damaged message, or when the
/// receiver is dropped.
pub(super) fn start(path: &Path, with_history: bool) -> std::io::Result<Receiver<Found>> {
    let (found, finds) = mpsc::channel();
    let path = path.to_owned();
    std::thread::Builder::new().name("search".into()).spawn(move || {
        if let Err(error) = run(&path, with_history, &found) {
            regatta_plugin::tell!(
                "replay: the search for marks and hot spots ended early: {error}"
            );
        }
    })?;
    Ok(finds)
}

fn run(path: &Path, with_history: bool, found: &Sender<Found>) -> Result<(), ReadingError> {
    let recording = Recording::open_frames(path)?;
    // Sending fails only if the replay has ended.
    let is_wanted = search_marks(&recording, |marks| found.send(Found::Marks(marks)).is_ok())?;
    if is_wanted && with_history {
        history::search(&recording, |history| found.send(Found::History(history)).is_ok())?;
    }
    Ok(())
}

/// Searches a recording for marks and closures, and passes them to `tell`, until that returns
/// `false`. Returns whether it never did.
fn search_marks(
    recording: &Recording,
    mut tell: impl FnMut(FoundMarks) -> bool,
) -> Result<bool, ReadingError> {
    let topics = vec![Topic::Events, Topic::ContactEvents];
    let mut reader = recording.read(&Selection::all_of(topics))?;
    let (mut found, mut told) = (FoundMarks::default(), Instant::now());
    while let Some(entry) = reader.next()? {
        recording.located(entry.topic, entry.log_time, found.add_message(&entry))?;
        if told.elapsed() > TELL_EVERY {
            told = Instant::now();
            if !tell(std::mem::take(&mut found)) {
                return Ok(false);
            }
        }
    }
    found.until = u64::MAX;
    Ok(tell(found))
}

impl FoundMarks {
    /// Adds the marks and closures of a message: at most one mark of each kind, which counts the
    /// events of its tick.
    fn add_message(&mut self, entry: &Entry<'_>) -> Result<(), MessageError> {
        let Entry { topic, log_time, message } = *entry;
        self.until = log_time;
        let first = self.marks.len();
        if *topic == Topic::ContactEvents {
            for event in decode::contact_events(message)?.2 {
                if event.level == ContactLevel::Touching as u32
                    && event.change == ContactChange::Began as u32
                {
                    self.add(first, log_time, MarkKind::Contact, event.robots[0]);
                }
            }
            return Ok(());
        }
        let (header, events) = decode::events(message)?;
        for event in events {
            self.closures.extend(ClosureChange::of(header.run_id, log_time, &event));
            let kind = match event.kind() {
                Some(EventKind::Faulted | EventKind::BrokenDown) => MarkKind::Fault,
                Some(EventKind::Held | EventKind::Stalled) => MarkKind::Stop,
                _ => continue,
            };
            self.add(first, log_time, kind, event.robot);
        }
        Ok(())
    }

    /// Counts an event in the mark of its kind. The marks of its message are those from `first` on.
    fn add(&mut self, first: usize, time_nanos: u64, kind: MarkKind, robot: u32) {
        let kind = kind as u32;
        match self.marks[first..].iter_mut().find(|mark| mark.kind == kind) {
            Some(mark) => mark.count += 1,
            None => {
                let mark = RecordingMark { time_nanos, kind, robot, count: 1, reserved: 0 };
                self.marks.push(mark);
            }
        }
    }
}

/// The notes of a recording: time on its clock in nanoseconds, and text.
pub(super) type Notes = Vec<(u64, String)>;

/// The size of the largest file of notes.
const MAX_NOTES_BYTES: u64 = 16 << 20;

/// Returns the file of a recording's notes.
pub(super) fn notes_file(recording: &Path) -> PathBuf {
    let mut path = recording.as_os_str().to_owned();
    path.push(".notes");
    path.into()
}

/// Reads the notes of a recording: lines of `FILE.notes`, each a time in seconds, a space and a
/// text. Other lines are reported and left out.
pub(super) fn notes(recording: &Path) -> Notes {
    let path = notes_file(recording);
    let text = match regatta_base::file::read_text(&path, MAX_NOTES_BYTES) {
        Ok(text) => text,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Vec::new(),
        Err(error) => {
            regatta_plugin::tell!("replay: {}: {error}", path.display());
            return Vec::new();
        }
    };
    let mut notes = Vec::new();
    for (i, line) in text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty()) {
        match note(line) {
            Some(note) => notes.push(note),
            None => regatta_plugin::tell!(
                "replay: {}:{}: not a note; write a time in seconds, a space and a text",
                path.display(),
                i + 1
            ),
        }
    }
    notes.sort();
    notes
}

fn note(line: &str) -> Option<(u64, String)> {
    let (time, text) = line.trim().split_once(char::is_whitespace)?;
    let time = Duration::try_from_secs_f64(time.trim_end_matches('s').parse().ok()?).ok()?;
    Some((u64::try_from(time.as_nanos()).ok()?, text.trim().to_owned()))
}

/// The time without another jump after which the list is decoded.
const AFTER: Duration = Duration::from_millis(150);

/// A list that is due, or is being decoded.
#[derive(Clone, Copy, Debug)]
enum Wanted {
    Since(Instant),
    Asked(u64),
}

/// The thread, and the list that it is to decode.
#[derive(Debug)]
pub(super) struct ContactSearch {
    requests: Sender<u64>,
    found: Receiver<(u64, ContactDecoder)>,
    wanted: Option<Wanted>,
}

impl ContactSearch {
    /// Starts the thread. It ends when this is dropped, or at the first damaged message.
    pub fn start(path: &Path) -> std::io::Result<Self> {
        let (requests, requested) = mpsc::channel::<u64>();
        let (find, found) = mpsc::channel();
        let path = path.to_owned();
        std::thread::Builder::new().name("contacts".into()).spawn(move || {
            let Ok(recording) = Recording::open_frames(&path) else { return };
            while let Ok(time) = requested.recv() {
                let time = requested.try_iter().last().unwrap_or(time);
                // The replay decodes the list again when it needs it, and reports the error.
                let Ok(decoder) = recording.contacts_before(time.saturating_add(1)) else { return };
                if find.send((time, decoder)).is_err() {
                    return;
                }
            }
        })?;
        Ok(Self { requests, found, wanted: None })
    }

    /// Notes a jump.
    pub fn jump(&mut self) {
        self.wanted = Some(Wanted::Since(Instant::now()));
    }

    /// Requests the list at a time if it is due. Returns it once it is decoded.
    pub fn poll(&mut self, time: u64) -> Option<ContactDecoder> {
        match self.wanted? {
            Wanted::Since(jumped) => {
                if jumped.elapsed() > AFTER && self.requests.send(time).is_ok() {
                    self.wanted = Some(Wanted::Asked(time));
                }
                None
            }
            Wanted::Asked(asked) => {
                let (_, decoder) = self.found.try_iter().find(|(time, _)| *time == asked)?;
                self.wanted = None;
                Some(decoder)
            }
        }
    }

    /// Cancels the request for a list, and returns whether there was one.
    pub fn cancel(&mut self) -> bool {
        self.wanted.take().is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn notes_are_a_time_and_a_text() {
        assert_eq!(
            note("12.5 robot 7 is stuck"),
            Some((12_500_000_000, "robot 7 is stuck".to_owned()))
        );
        assert_eq!(note(" 3s  a"), Some((3_000_000_000, "a".to_owned())));
        for bad in ["12.5", "soon it jams", "-1 a", "1e30 a", "nan a"] {
            assert_eq!(note(bad), None, "{bad}");
        }
    }
}
