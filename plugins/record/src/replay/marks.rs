//! The search of a recording for marks: contacts, faults, stops, and the notes beside it.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use regatta_plugin::contact::{ContactChange, ContactLevel};
use regatta_plugin::event::EventKind;
use regatta_plugin::recording::{MarkKind, RecordingMark};

use super::closures::ClosureChange;
use crate::decode::{self, MessageError};
use crate::reading::{ReadingError, Recording, Selection};
use crate::schema::Topic;

/// The most marks that are kept.
pub(super) const MAX_MARKS: usize = 65_536;
/// The time between two messages of the search.
const TELL_EVERY: Duration = Duration::from_millis(250);

/// What was found since the message before.
#[derive(Debug, Default)]
pub(super) struct FoundMarks {
    /// In the order of time.
    pub marks: Vec<RecordingMark>,
    /// Edges that were closed and opened.
    pub closures: Vec<ClosureChange>,
    /// Everything up to this time has been searched.
    pub until: u64,
}

/// What one message tells.
type Searched = (Vec<RecordingMark>, Vec<ClosureChange>);

/// Searches a recording, and passes on what is found, until `tell` wants no more. Returns whether
/// it did to the end.
pub(super) fn search(
    recording: &Recording,
    mut tell: impl FnMut(FoundMarks) -> bool,
) -> Result<bool, ReadingError> {
    let topics = vec![Topic::Events, Topic::ContactEvents];
    let mut reader = recording.read(&Selection::all_of(topics))?;
    let (mut batch, mut told) = (FoundMarks::default(), Instant::now());
    while let Some(entry) = reader.next()? {
        batch.until = entry.log_time;
        let searched = search_message(entry.topic, entry.log_time, entry.message);
        let (marks, closures) =
            searched.map_err(|reason| recording.malformed(entry.topic, entry.log_time, reason))?;
        batch.marks.extend(marks);
        batch.closures.extend(closures);
        if told.elapsed() > TELL_EVERY {
            told = Instant::now();
            if !tell(std::mem::take(&mut batch)) {
                return Ok(false);
            }
        }
    }
    batch.until = u64::MAX;
    Ok(tell(batch))
}

/// Returns the marks of a message (at most one of each kind, which counts what happened in its
/// tick), and its closures.
fn search_message(topic: &Topic, time: u64, message: &[u8]) -> Result<Searched, MessageError> {
    let (mut marks, mut closures) = (Vec::<RecordingMark>::new(), Vec::new());
    let mut add =
        |kind: MarkKind, robot: u32| match marks.iter_mut().find(|mark| mark.kind == kind as u32) {
            Some(mark) => mark.count += 1,
            None => marks.push(RecordingMark {
                time_nanos: time,
                kind: kind as u32,
                robot,
                count: 1,
                reserved: 0,
            }),
        };
    if *topic == Topic::ContactEvents {
        for event in decode::contact_events(message)?.2 {
            if event.level == ContactLevel::Touching as u32
                && event.change == ContactChange::Began as u32
            {
                add(MarkKind::Contact, event.robots[0]);
            }
        }
    } else {
        let (header, events) = decode::events(message)?;
        for event in events {
            closures.extend(ClosureChange::of(header.run_id, time, &event));
            match event.kind() {
                Some(EventKind::Faulted | EventKind::BrokenDown) => {
                    add(MarkKind::Fault, event.robot)
                }
                Some(EventKind::Held | EventKind::Stalled) => add(MarkKind::Stop, event.robot),
                _ => {}
            }
        }
    }
    Ok((marks, closures))
}

/// The notes of a recording: time on its clock in nanoseconds, and text.
pub(super) type Notes = Vec<(u64, String)>;

/// Returns the file of a recording's notes.
pub(super) fn notes_file(recording: &Path) -> PathBuf {
    let mut path = recording.as_os_str().to_owned();
    path.push(".notes");
    path.into()
}

/// Reads the notes of a recording: lines of `FILE.notes`, each a time in seconds, a space and a
/// text. Lines that aren't are left out, and told.
pub(super) fn notes(recording: &Path) -> Notes {
    let path = notes_file(recording);
    let Ok(text) = std::fs::read_to_string(&path) else { return Vec::new() };
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
