//! Tells readers what is being replayed: the file's name, its time, and the marks in it.

use std::path::Path;
use std::sync::mpsc::Receiver;

use regatta_plugin::recording::{MarkKind, RecordingHeader, RecordingMark};
use regatta_plugin::{OpenError, Participant, PublishError, RecordingPublisher};

use super::closures::Closures;
use super::marks::{self, Found, MAX_MARKS, Notes};
use crate::reading::Recording;

/// What is told about the recording, and the search for more.
#[derive(Debug)]
pub(super) struct Teller {
    publisher: RecordingPublisher,
    header: RecordingHeader,
    marks: Vec<RecordingMark>,
    notes: Notes,
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
        let notes = marks::notes(path);
        let mark = |(time, _): &(u64, String)| RecordingMark {
            time_nanos: *time,
            kind: MarkKind::Note as u32,
            count: 1,
            ..RecordingMark::default()
        };
        let search = search(path);
        let marks = notes.iter().map(mark).collect();
        Ok(Self {
            publisher: RecordingPublisher::open_on(participant)?,
            header,
            marks,
            notes,
            search,
            is_news: true,
            closures: Closures::default(),
        })
    }

    /// Tells what is new before a frame is shown: another run, or another clock of its frames.
    pub fn before_frame(&mut self, run_id: u64, time: u64, sim_time: u64) -> Result<(), PublishError> {
        let ahead = time.wrapping_sub(sim_time);
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
        // The first frame tells the run.
        if self.header.run_id != 0 {
            self.tell()?;
        }
        self.publisher.update();
        Ok(())
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

/// Starts the search. Without it, there are no marks, but there is a replay.
fn search(path: &Path) -> Option<Receiver<Found>> {
    let started = marks::search(path);
    started.inspect_err(|error| regatta_plugin::tell!("replay: no marks are searched for: {error}")).ok()
}
