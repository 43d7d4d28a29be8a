//! The annotations of a replayed recording: its marks, notes, closures and history, and the file
//! and the time that are shown.

use std::path::{Path, PathBuf};
use std::sync::mpsc::Receiver;
use std::time::{Duration, Instant, SystemTime};

use regatta_plugin::frame::FrameHeader;
use regatta_plugin::recording::{MarkKind, RecordingHeader, RecordingMark};
use regatta_plugin::{OpenError, Participant, PublishError, RecordingPublisher};

use super::closures::Closures;
use super::history::Histories;
use super::search::{self, Found, FoundMarks, MAX_MARKS, Notes};
use crate::reading::Recording;

/// The time between two checks for new notes.
const CHECK_EVERY: Duration = Duration::from_millis(300);

/// The annotations that are known, and the search for more.
#[derive(Debug)]
pub(super) struct Annotations {
    publisher: RecordingPublisher,
    header: RecordingHeader,
    marks: Vec<RecordingMark>,
    notes: Notes,
    /// The recording.
    path: PathBuf,
    /// The state of the file of notes when it was read.
    notes_read: Option<FileState>,
    /// The time of the next check for new notes.
    next_check: Instant,
    /// The time that is shown, in nanoseconds.
    shown: u64,
    search: Option<Receiver<Found>>,
    /// `None` if none is wanted, or another process publishes one.
    histories: Option<Histories>,
    /// Whether something has changed since it was published.
    is_changed: bool,
    /// The closed edges.
    pub closures: Closures,
}

impl Annotations {
    /// Opens the services, and starts the search for marks, and, if wanted, for the history.
    pub fn open(
        participant: &Participant,
        recording: &Recording,
        with_history: bool,
    ) -> Result<Self, OpenError> {
        let path = recording.path();
        let (start, end) = recording.span();
        let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
        let header = RecordingHeader {
            start_nanos: start.as_nanos() as u64,
            end_nanos: end.as_nanos() as u64,
            ..RecordingHeader::new(&name)
        };
        let notes_read = FileState::of_notes(path);
        let notes = search::notes(path);
        let histories = with_history.then(|| Histories::open(participant)).flatten();
        // Without the search, there are no marks and no history, but there is a replay.
        let search = search::start(path, histories.is_some())
            .inspect_err(|error| regatta_plugin::tell!("replay: can't search for marks: {error}"));
        Ok(Self {
            publisher: RecordingPublisher::open_on(participant)?,
            header,
            marks: notes.iter().take(MAX_MARKS).map(mark).collect(),
            notes,
            path: path.to_owned(),
            notes_read,
            next_check: Instant::now() + CHECK_EVERY,
            shown: 0,
            search: search.ok(),
            histories,
            is_changed: true,
            closures: Closures::default(),
        })
    }

    /// Publishes changes before a frame of a recorded run is shown: another run, another clock of
    /// its frames, or another note.
    pub fn before_frame(
        &mut self,
        run_id: u64,
        time: u64,
        recorded: &FrameHeader,
    ) -> Result<(), PublishError> {
        if let Some(histories) = &mut self.histories {
            histories.show(run_id, recorded.run_id)?;
        }
        self.shown = time;
        let ahead = time.wrapping_sub(recorded.sim_time_nanos);
        if (self.header.run_id, self.header.ahead_nanos) != (run_id, ahead) {
            (self.header.run_id, self.header.ahead_nanos) = (run_id, ahead);
            self.is_changed = true;
        }
        // The header holds only the start of a long note.
        let (note, shown) = (note_at(&self.notes, time), self.header.note());
        if !note.starts_with(shown) || note.is_empty() != shown.is_empty() {
            self.is_changed = true;
        }
        if self.is_changed {
            self.header.set_note(note_at(&self.notes, time));
        }
        self.publish()
    }

    /// Takes and publishes the results of the search, and connects readers that have joined.
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
        // The run is known from the first frame on.
        if self.header.run_id != 0 {
            self.publish()?;
        }
        self.publisher.update();
        Ok(())
    }

    /// Reads the notes again if their file has changed: a viewer adds some while the recording is
    /// shown.
    fn read_new_notes(&mut self) {
        if Instant::now() < self.next_check {
            return;
        }
        self.next_check = Instant::now() + CHECK_EVERY;
        let now = FileState::of_notes(&self.path);
        if std::mem::replace(&mut self.notes_read, now) == now {
            return;
        }
        self.notes = search::notes(&self.path);
        self.marks.retain(|mark| mark.kind() != Some(MarkKind::Note));
        let room = MAX_MARKS.saturating_sub(self.marks.len());
        self.marks.extend(self.notes.iter().take(room).map(mark));
        self.marks.sort_by_key(|mark| mark.time_nanos);
        self.header.set_note(note_at(&self.notes, self.shown));
        self.is_changed = true;
    }

    fn take(&mut self, found: FoundMarks) {
        self.header.searched_nanos = found.until;
        self.closures.take(found.closures);
        let room = MAX_MARKS.saturating_sub(self.marks.len()).min(found.marks.len());
        self.header.left_out += (found.marks.len() - room) as u64;
        self.marks.extend(&found.marks[..room]);
        // Stable, so that marks of one time stay in the order in which they were found.
        self.marks.sort_by_key(|mark| mark.time_nanos);
        self.is_changed = true;
    }

    fn publish(&mut self) -> Result<(), PublishError> {
        if std::mem::take(&mut self.is_changed) {
            self.publisher.publish(&self.header, &self.marks)?;
        }
        Ok(())
    }
}

/// Returns the text of the last note at or before a time.
fn note_at(notes: &Notes, time: u64) -> &str {
    notes.iter().rfind(|(at, _)| *at <= time).map_or("", |(_, text)| text)
}

fn mark((time, _): &(u64, String)) -> RecordingMark {
    let kind = MarkKind::Note as u32;
    RecordingMark { time_nanos: *time, kind, count: 1, ..RecordingMark::default() }
}

/// The size of a file in bytes, and the time at which it was written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct FileState {
    bytes: u64,
    modified: SystemTime,
}

impl FileState {
    /// Returns the state of a recording's file of notes, if there is one.
    fn of_notes(recording: &Path) -> Option<Self> {
        let file = std::fs::metadata(search::notes_file(recording)).ok()?;
        Some(Self { bytes: file.len(), modified: file.modified().ok()? })
    }
}
