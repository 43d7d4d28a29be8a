//! Tells readers what is being replayed: the file's name, its time, the marks in it, and the
//! history of its runs.

use std::path::{Path, PathBuf};
use std::sync::mpsc::Receiver;
use std::time::{Duration, Instant, SystemTime};

use regatta_plugin::frame::FrameHeader;
use regatta_plugin::recording::{MarkKind, RecordingHeader, RecordingMark};
use regatta_plugin::{OpenError, Participant, PublishError, RecordingPublisher};

use super::closures::Closures;
use super::histories::Histories;
use super::marks::{self, FoundMarks, MAX_MARKS, Notes};
use super::search::{self, Found};
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
    /// `None` if none is wanted, or somebody else publishes one.
    histories: Option<Histories>,
    /// Whether something has changed since it was told.
    is_news: bool,
    /// The closed edges.
    pub closures: Closures,
}

impl Teller {
    /// Opens the services, and starts the search for marks, and, if wanted, for the history.
    pub fn open(
        participant: &Participant,
        recording: &Recording,
        with_history: bool,
    ) -> Result<Self, OpenError> {
        let path = recording.path();
        let (start, end) = recording.span();
        let header = RecordingHeader {
            start_nanos: start.as_nanos() as u64,
            end_nanos: end.as_nanos() as u64,
            ..RecordingHeader::new(&path.file_name().unwrap_or(path.as_os_str()).to_string_lossy())
        };
        let notes_were = size_and_time(path);
        let notes = marks::notes(path);
        let histories = with_history.then(|| Histories::open(participant)).flatten();
        let search = search(path, histories.is_some());
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
            histories,
            is_news: true,
            closures: Closures::default(),
        })
    }

    /// Tells what is new before a frame of a recorded run is shown: another run, or another clock
    /// of its frames.
    pub fn before_frame(
        &mut self,
        run_id: u64,
        time: u64,
        recorded: &FrameHeader,
    ) -> Result<(), PublishError> {
        if let Some(histories) = &mut self.histories {
            histories.show(run_id, recorded.run_id)?;
        }
        let ahead = time.wrapping_sub(recorded.sim_time_nanos);
        self.shown = time;
        let note = self.notes.iter().rev().find(|(at, _)| *at <= time).map_or("", |(_, text)| text);
        let is_known = (self.header.run_id, self.header.ahead_nanos) == (run_id, ahead);
        if !is_known
            || !note.starts_with(self.header.note())
            || note.is_empty() != self.header.note().is_empty()
        {
            (self.header.run_id, self.header.ahead_nanos) = (run_id, ahead);
            self.header.set_note(note);
            self.is_news = true;
        }
        self.tell()
    }

    /// Takes what the search has found, tells it, and connects readers that have joined.
    pub fn update(&mut self) -> Result<(), PublishError> {
        while let Some(found) = self.search.as_ref().and_then(|search| search.try_recv().ok()) {
            match (found, &mut self.histories) {
                (Found::Marks(marks), _) => self.take(marks),
                (Found::History(history), Some(histories)) => histories.take(history),
                (Found::History(_), None) => {}
            }
        }
        if let Some(histories) = &mut self.histories {
            histories.update()?;
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
        let note =
            self.notes.iter().rev().find(|(at, _)| *at <= self.shown).map_or("", |(_, text)| text);
        self.header.set_note(note);
        self.is_news = true;
    }

    fn take(&mut self, found: FoundMarks) {
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
    RecordingMark {
        time_nanos: *time,
        kind: MarkKind::Note as u32,
        count: 1,
        ..RecordingMark::default()
    }
}

/// The size of a recording's notes in bytes, and when they were written; `None` without notes.
fn size_and_time(recording: &Path) -> Option<(u64, SystemTime)> {
    let file = std::fs::metadata(marks::notes_file(recording)).ok()?;
    Some((file.len(), file.modified().ok()?))
}

/// Starts the search. Without it, there are no marks and no history, but there is a replay.
fn search(path: &Path, with_history: bool) -> Option<Receiver<Found>> {
    let started = search::start(path, with_history);
    started
        .inspect_err(|error| regatta_plugin::tell!("replay: no marks are searched for: {error}"))
        .ok()
}
