//! Tells readers what is being replayed: the file's name, its time, and the marks in it.

use std::path::{Path, PathBuf};
use std::sync::mpsc::Receiver;
use std::time::{Duration, Instant, SystemTime};

use regatta_plugin::recording::{MarkKind, RecordingHeader, RecordingMark};
use regatta_plugin::{OpenError, Participant, PublishError, RecordingPublisher};

use super::closures::Closures;
use super::marks::{self, Found, MAX_MARKS, Notes};
use crate::reading::Recording;

/// The time between two looks whether there are other notes.
const LOOK_EVERY: Duration = Duration::from_millis(300);

/// What is told about the recording, and the search for more.
#[derive(Debug)]
pub(super) struct Teller {
    publisher: RecordingPublisher,
    header: RecordingHeader,
    marks: Vec<RecordingMark>,
    notes: Notes,
    /// The recording, what its file of notes was when it was read, and when to look at it again.
    path: PathBuf,
    notes_were: Option<(u64, SystemTime)>,
    look_at: Instant,
    /// The time that is shown, in nanoseconds.
    shown: u64,
    search: Option<Receiver<Found>>,
    /// Whether something has changed since it was told.
    is_news: bool,
    /// The closed edges.
    pub closures: Closures,
}

impl Teller {
    /// Opens the service, and starts the search for marks.
    pub fn open(participant: &Participant, recording: &Recording) -> Result<Self, OpenError> {
        let path = recording.path();
        let (start, end) = recording.span();
        let header = RecordingHeader {
            start_nanos: start.as_nanos() as u64,
            end_nanos: end.as_nanos() as u64,
            ..RecordingHeader::new(&path.file_name().unwrap_or(path.as_os_str()).to_string_lossy())
        };
        let notes_were = size_and_time(path);
        let notes = marks::notes(path);
        let search = search(path);
        let marks = notes.iter().take(MAX_MARKS).map(mark).collect();
        Ok(Self {
            publisher: RecordingPublisher::open_on(participant)?,
            header,
            marks,
            notes,
            path: path.to_owned(),
            notes_were,
            look_at: Instant::now() + LOOK_EVERY,
            shown: 0,
            search,
            is_news: true,
            closures: Closures::default(),
        })
    }

    /// Tells what is new before a frame is shown: another run, or another clock of its frames.
    pub fn before_frame(&mut self, run_id: u64, time: u64, sim_time: u64) -> Result<(), PublishError> {
        let ahead = time.wrapping_sub(sim_time);
        self.shown = time;
        let note = self.notes.iter().rev().find(|(at, _)| *at <= time).map_or("", |(_, text)| text);
        let is_known = (self.header.run_id, self.header.ahead_nanos) == (run_id, ahead);
        if !is_known || !note.starts_with(self.header.note()) || note.is_empty() != self.header.note().is_empty() {
            (self.header.run_id, self.header.ahead_nanos) = (run_id, ahead);
            self.header.set_note(note);
            self.is_news = true;
        }
        self.tell()
    }

    /// Takes what the search has found, tells it, and connects readers that have joined.
    pub fn update(&mut self) -> Result<(), PublishError> {
        while let Some(found) = self.search.as_ref().and_then(|search| search.try_recv().ok()) {
            self.take(found);
        }
        self.read_new_notes();
        // The first frame tells the run.
        if self.header.run_id != 0 {
            self.tell()?;
        }
        self.publisher.update();
        Ok(())
    }

    /// Reads the notes again if there are others: a viewer adds some while the recording is shown.
    fn read_new_notes(&mut self) {
        if Instant::now() < self.look_at {
            return;
        }
        self.look_at = Instant::now() + LOOK_EVERY;
        let now = size_and_time(&self.path);
        if std::mem::replace(&mut self.notes_were, now) == now {
            return;
        }
        self.notes = marks::notes(&self.path);
        self.marks.retain(|mark| mark.kind() != Some(MarkKind::Note));
        let room = MAX_MARKS.saturating_sub(self.marks.len());
        self.marks.extend(self.notes.iter().take(room).map(mark));
        self.marks.sort_by_key(|mark| mark.time_nanos);
        let note = self.notes.iter().rev().find(|(at, _)| *at <= self.shown).map_or("", |(_, text)| text);
        self.header.set_note(note);
        self.is_news = true;
    }

    fn take(&mut self, found: Found) {
        if found.until == u64::MAX {
            self.search = None;
        }
        self.header.searched_nanos = found.until;
        self.closures.take(found.closures);
        let room = MAX_MARKS.saturating_sub(self.marks.len()).min(found.marks.len());
        self.header.left_out += (found.marks.len() - room) as u64;
        self.marks.extend(&found.marks[..room]);
        // Stable, so that marks of one time stay as they were found.
        self.marks.sort_by_key(|mark| mark.time_nanos);
        self.is_news = true;
    }

    fn tell(&mut self) -> Result<(), PublishError> {
        if std::mem::take(&mut self.is_news) {
            self.publisher.publish(&self.header, &self.marks)?;
        }
        Ok(())
    }
}

fn mark((time, _): &(u64, String)) -> RecordingMark {
    RecordingMark { time_nanos: *time, kind: MarkKind::Note as u32, count: 1, ..RecordingMark::default() }
}

/// The size of a recording's notes in bytes, and when they were written; `None` without notes.
fn size_and_time(recording: &Path) -> Option<(u64, SystemTime)> {
    let file = std::fs::metadata(marks::notes_file(recording)).ok()?;
    Some((file.len(), file.modified().ok()?))
}

/// Starts the search. Without it, there are no marks, but there is a replay.
fn search(path: &Path) -> Option<Receiver<Found>> {
    let started = marks::search(path);
    started.inspect_err(|error| regatta_plugin::tell!("replay: no marks are searched for: {error}")).ok()
}
