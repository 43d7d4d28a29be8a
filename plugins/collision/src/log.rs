//! The contact log: a CSV file with a line for each begin and end of a contact or a warning.

use std::fmt::Write as _;
use std::fs::{File, OpenOptions};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use regatta_plugin::contact::{ContactChange, ContactEvent, ContactLevel};

/// The first line of the file.
pub const HEADER: &str =
    "time_secs,tick,change,level,robot_a,robot_b,edge,x_metres,y_metres,relative_speed_metres_per_sec,run_id";

/// An upper bound of the bytes in a line.
const MAX_LINE_BYTES: u64 = 1024;

/// The error of opening or writing the log.
#[derive(Debug, thiserror::Error)]
#[error("can't write {} ({reason})", path.display())]
pub struct LogError {
    path: PathBuf,
    reason: io::Error,
}

/// A change of the log's state that is reported to the user.
#[derive(Debug)]
pub(crate) enum Transition {
    /// Events are lost from now on.
    Failed(LogError),
    /// The file can be written again, after this number of lost events.
    Recovered(u64),
}

/// A CSV file to which lines are appended: those of a tick all together, or none of them.
#[derive(Debug)]
pub(crate) struct ContactLog {
    path: PathBuf,
    file: File,
    /// Length of the file up to the last whole line, in bytes.
    length: u64,
    lost: u64,
    failing: bool,
    text: String,
}

impl ContactLog {
    /// Opens a log, or creates it. Its contents are kept, except for half a line at its end.
    pub(crate) fn open(path: &Path) -> Result<Self, LogError> {
        let failed = |reason| LogError { path: path.to_owned(), reason };
        let mut file = OpenOptions::new().append(true).create(true).open(path).map_err(failed)?;
        let mut length = file.metadata().map_err(failed)?.len();
        if length > 0 {
            length = File::open(path).and_then(|mut there| whole_lines(&mut there, length)).map_err(failed)?;
            file.set_len(length).and_then(|()| file.seek(SeekFrom::End(0))).map_err(failed)?;
        }
        let mut log = Self { path: path.to_owned(), file, length, lost: 0, failing: false, text: String::new() };
        if length == 0 {
            log.text = format!("{HEADER}\n");
            log.write().map_err(failed)?;
        }
        Ok(log)
    }

    /// Appends the events of a tick; `edges` are ids by index. Returns a transition when writing begins to fail, and
    /// when it works again.
    pub(crate) fn add(&mut self, run_id: u64, events: &[ContactEvent], edges: &[u32]) -> Option<Transition> {
        if events.is_empty() {
            return None;
        }
        self.text.clear();
        events.iter().for_each(|event| line(&mut self.text, run_id, event, edges));
        match self.write() {
            Ok(()) => std::mem::take(&mut self.failing).then_some(Transition::Recovered(self.lost)),
            Err(reason) => {
                self.lost += events.len() as u64;
                let first = !std::mem::replace(&mut self.failing, true);
                first.then(|| Transition::Failed(LogError { path: self.path.clone(), reason }))
            }
        }
    }

    fn write(&mut self) -> io::Result<()> {
        let result = self.file.write_all(self.text.as_bytes());
        match result {
            Ok(()) => self.length += self.text.len() as u64,
            // Half a line would corrupt the next one. A pipe or a device can't be truncated.
            Err(_) => drop(self.file.set_len(self.length)),
        }
        result
    }

    /// Returns the number of events that could not be written.
    pub(crate) fn lost(&self) -> u64 {
        self.lost
    }

    pub(crate) fn path(&self) -> &Path {
        &self.path
    }
}

/// Returns the length of the whole lines in a log of `length` bytes.
fn whole_lines(file: &mut File, length: u64) -> io::Result<u64> {
    let mut start = Vec::new();
    file.take(HEADER.len() as u64 + 1).read_to_end(&mut start)?;
    if start != format!("{HEADER}\n").as_bytes() {
        return Err(io::Error::new(
            io::ErrorKind::InvalidData,
            "the file exists and is not a contact log; choose another file",
        ));
    }
    let mut end = Vec::new();
    file.seek(SeekFrom::Start(length.saturating_sub(MAX_LINE_BYTES)))?;
    file.read_to_end(&mut end)?;
    let half = end.iter().rev().take_while(|byte| **byte != b'\n').count();
    Ok(length - half as u64)
}

fn line(text: &mut String, run_id: u64, event: &ContactEvent, edges: &[u32]) {
    let change = match ContactChange::from_number(event.change) {
        Some(ContactChange::Began) => "began",
        Some(ContactChange::Ended) => "ended",
        None => "",
    };
    let level = match ContactLevel::from_number(event.level) {
        Some(ContactLevel::Touching) => "touching",
        Some(ContactLevel::Possible) => "possible",
        None => "",
    };
    let edge = edges.get(event.edge as usize).map(u32::to_string).unwrap_or_default();
    let ContactEvent { tick, robots: [a, b], x, y, relative_speed, .. } = event;
    let secs = event.sim_time_nanos as f64 * 1e-9;
    // Writing to a string can't fail.
    let _ = writeln!(
        text,
        "{secs:.6},{tick},{change},{level},{a},{b},{edge},{x:.4},{y:.4},{relative_speed:.4},{run_id:016x}"
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    fn event(tick: u64) -> ContactEvent {
        ContactEvent {
            tick,
            sim_time_nanos: 1_500_000_000,
            robots: [3, 8],
            level: ContactLevel::Touching as u32,
            change: ContactChange::Began as u32,
            edge: 1,
            x: 2.5,
            y: -1.0,
            relative_speed: 0.75,
        }
    }

    #[test]
    fn lines_are_appended_to_an_existing_log() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("log.csv");
        for tick in [7, 8] {
            assert!(ContactLog::open(&path).unwrap().add(0xab, &[event(tick)], &[10, 20]).is_none());
        }
        let text = std::fs::read_to_string(&path).unwrap();
        let line = |tick| format!("1.500000,{tick},began,touching,3,8,20,2.5000,-1.0000,0.7500,00000000000000ab\n");
        assert_eq!(text, format!("{HEADER}\n{}{}", line(7), line(8)));
    }

    #[test]
    fn half_a_line_at_the_end_is_cut_and_other_files_are_left_alone() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("log.csv");
        std::fs::write(&path, format!("{HEADER}\n1.5,7,began")).unwrap();
        assert!(ContactLog::open(&path).unwrap().add(1, &[event(8)], &[10, 20]).is_none());
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(text.starts_with(&format!("{HEADER}\n1.500000,8,began")), "{text}");
        let other = folder.path().join("plant.yaml");
        std::fs::write(&other, "Edges: []\n").unwrap();
        assert!(ContactLog::open(&other).unwrap_err().to_string().contains("not a contact log"));
        assert_eq!(std::fs::read_to_string(&other).unwrap(), "Edges: []\n");
    }

    #[test]
    fn a_robot_on_no_edge_has_an_empty_field() {
        let mut text = String::new();
        line(&mut text, 1, &ContactEvent { edge: u32::MAX, ..event(1) }, &[10, 20]);
        assert!(text.contains(",3,8,,2.5"), "{text}");
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn a_full_disk_is_reported_once_and_lost_events_are_counted() {
        let file = OpenOptions::new().append(true).open("/dev/full").unwrap();
        let path = PathBuf::from("/dev/full");
        let mut log = ContactLog { path, file, length: 0, lost: 0, failing: false, text: String::new() };
        assert!(matches!(log.add(1, &[event(1); 3], &[]), Some(Transition::Failed(_))));
        assert!(log.add(1, &[event(2); 2], &[]).is_none());
        assert_eq!(log.lost(), 5);
        log.file = tempfile::tempfile().unwrap();
        assert!(matches!(log.add(1, &[event(3)], &[]), Some(Transition::Recovered(5))));
    }
}
