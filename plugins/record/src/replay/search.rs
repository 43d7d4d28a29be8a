//! The search of a recording on a thread of its own, so that a replay starts at once: first for
//! marks and closures, which only the chunks with events have; then for the history of its runs,
//! for which all frames are read.

use std::path::Path;
use std::sync::mpsc::{self, Receiver, Sender};

use super::history::{self, RecordedHistory};
use super::marks::{self, FoundMarks};
use crate::reading::{ReadingError, Recording};

/// What a search has found since its last message.
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
    let is_wanted = marks::search(&recording, |marks| found.send(Found::Marks(marks)).is_ok())?;
    if is_wanted && with_history {
        history::search(&recording, |history| found.send(Found::History(history)).is_ok())?;
    }
    Ok(())
}
