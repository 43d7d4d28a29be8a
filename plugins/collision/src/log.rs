//! The contact log: a CSV file with a row for each begin and end of a contact or a warning.

use std::fmt::Write as _;
use std::path::Path;

pub(crate) use regatta_kit::CsvChange;
pub use regatta_kit::CsvError as LogError;
use regatta_kit::CsvFile;
use regatta_plugin::contact::{ContactChange, ContactEvent, ContactLevel};

/// The first line of the file.
pub const HEADER: &str = "time_secs,tick,change,level,robot_a,robot_b,edge,x_metres,y_metres,\
                          relative_speed_metres_per_sec,run_id";

/// A CSV file to which rows are appended: either all rows of a tick, or none.
#[derive(Debug)]
pub(crate) struct ContactLog {
    file: CsvFile,
    text: String,
}

impl ContactLog {
    /// Opens a log, or creates it. Its rows are kept.
    pub(crate) fn open(path: &Path) -> Result<Self, LogError> {
        Ok(Self { file: CsvFile::open(path, HEADER)?, text: String::new() })
    }

    /// Appends the events of a tick; `edges` are ids by index. Returns a change when writing begins
    /// to fail, and when it works again.
    pub(crate) fn add(
        &mut self,
        run_id: u64,
        events: &[ContactEvent],
        edges: &[u32],
    ) -> Option<CsvChange> {
        if events.is_empty() {
            return None;
        }
        self.text.clear();
        for event in events {
            row(&mut self.text, run_id, event, edges);
        }
        self.file.append(&self.text)
    }

    /// Returns the number of events that could not be written.
    pub(crate) fn lost(&self) -> u64 {
        self.file.rows().lost
    }

    pub(crate) fn path(&self) -> &Path {
        self.file.path()
    }
}

fn row(text: &mut String, run_id: u64, event: &ContactEvent, edges: &[u32]) {
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
        "{secs:.6},{tick},{change},{level},{a},{b},{edge},{x:.4},{y:.4},{relative_speed:.4},\
         {run_id:016x}"
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
    fn a_row_has_a_cell_for_each_column() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("log.csv");
        let mut log = ContactLog::open(&path).unwrap();
        assert!(log.add(0xab, &[event(7), event(8)], &[10, 20]).is_none());
        let row = |tick| {
            format!(
                "1.500000,{tick},began,touching,3,8,20,2.5000,-1.0000,0.7500,00000000000000ab\n"
            )
        };
        assert_eq!(
            std::fs::read_to_string(&path).unwrap(),
            format!("{HEADER}\n{}{}", row(7), row(8))
        );
        assert_eq!(row(7).split(',').count(), HEADER.split(',').count());
    }

    #[test]
    fn a_robot_on_no_edge_has_an_empty_cell() {
        let mut text = String::new();
        row(&mut text, 1, &ContactEvent { edge: u32::MAX, ..event(1) }, &[10, 20]);
        assert!(text.contains(",3,8,,2.5"), "{text}");
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn lost_events_are_counted() {
        let mut log = ContactLog::open(Path::new("/dev/full")).unwrap();
        assert!(matches!(log.add(1, &[event(1); 3], &[]), Some(CsvChange::Failed(_))));
        assert!(log.add(1, &[event(2); 2], &[]).is_none());
        assert_eq!(log.lost(), 5);
    }
}
