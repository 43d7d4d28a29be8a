//! The state that the screen draws.

use regatta_plugin::FleetName;

use super::commands::Outcome;
use super::history::History;
use crate::snapshot::{Collisions, Snapshot, Totals};

/// The state that the screen draws.
#[derive(Debug)]
pub struct View {
    /// Snapshot of the fleet.
    pub snapshot: Snapshot,
    /// History of the last minutes.
    pub history: History,
    /// Reason why the processes can't be listed.
    pub process_error: Option<String>,
    /// Whether the list shows the edges where robots wait, rather than collisions.
    pub shows_jams: bool,
    /// Number of collisions above the first line of the list.
    pub scroll: usize,
    /// Whether the help is shown.
    pub help: bool,
    /// Outcome of the last key.
    pub outcome: Option<Outcome>,
}

impl View {
    /// Creates the view of a fleet before its first frame.
    pub fn new(fleet: &FleetName) -> Self {
        let snapshot = Snapshot {
            fleet: fleet.clone(),
            totals: Totals::default(),
            run: None,
            collisions: Collisions::default(),
            work: None,
            jams: None,
            processes: Vec::new(),
        };
        let history = History::default();
        Self {
            snapshot,
            history,
            process_error: None,
            shows_jams: false,
            scroll: 0,
            help: false,
            outcome: None,
        }
    }

    /// Scrolls the collisions by a number of lines, at most to their end.
    pub fn scroll_by(&mut self, lines: isize) {
        let last = self.snapshot.collisions.list.len().saturating_sub(1);
        self.scroll = self.scroll.min(last).saturating_add_signed(lines).min(last);
    }
}
