//! Closed edges of a recording, from its events as they are replayed, and from the search, which
//! also finds the events that a jump leaves out.

use std::collections::{BTreeMap, BTreeSet};

use regatta_plugin::closure::ClosedEdge;
use regatta_plugin::event::{EventKind, EventRecord};

/// An edge that was closed or opened.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct ClosureChange {
    /// The recorded run.
    pub run_id: u64,
    /// The time on the recording's clock, in nanoseconds.
    pub time: u64,
    /// The id of the edge.
    pub edge: u32,
    /// Whether it was closed.
    pub is_closed: bool,
}

impl ClosureChange {
    /// Returns the change that an event reports, if any.
    pub fn of(run_id: u64, time: u64, event: &EventRecord) -> Option<Self> {
        let is_closed = match event.kind()? {
            EventKind::EdgeClosed => true,
            EventKind::EdgeOpened => false,
            _ => return None,
        };
        Some(Self { run_id, time, edge: event.id, is_closed })
    }
}

/// All changes that are known.
#[derive(Debug, Default)]
pub(super) struct Closures {
    /// Whether an edge was closed, by run, time and id: a change that is found twice counts once.
    changes: BTreeMap<(u64, u64, u32), bool>,
    /// The closures published last.
    published: Vec<ClosedEdge>,
}

impl Closures {
    /// Takes changes, in any order.
    pub fn take(&mut self, changes: impl IntoIterator<Item = ClosureChange>) {
        for ClosureChange { run_id, time, edge, is_closed } in changes {
            self.changes.insert((run_id, time, edge), is_closed);
        }
    }

    /// Begins another run of the replay, in which nothing has been published yet.
    pub fn begin_run(&mut self) {
        self.published.clear();
    }

    /// Returns the edges that are closed at a time of a recorded run, if they differ from the last
    /// returned ones.
    pub fn news(&mut self, run_id: u64, time: u64) -> Option<&[ClosedEdge]> {
        let mut closed = BTreeSet::new();
        let until_now = (run_id, 0, 0)..=(run_id, time, u32::MAX);
        for ((.., edge), is_closed) in self.changes.range(until_now) {
            let edge = ClosedEdge { edge: *edge };
            if *is_closed {
                closed.insert(edge);
            } else {
                closed.remove(&edge);
            }
        }
        let closed: Vec<ClosedEdge> = closed.into_iter().collect();
        if closed == self.published {
            return None;
        }
        self.published = closed;
        Some(&self.published)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_are_closed_from_their_event_on_in_their_run() {
        let change =
            |run_id, time, edge, is_closed| ClosureChange { run_id, time, edge, is_closed };
        let mut closures = Closures::default();
        assert_eq!(closures.news(1, 10), None);
        closures.take([
            change(1, 20, 7, false),
            change(1, 5, 7, true),
            change(1, 8, 3, true),
            change(2, 30, 9, true),
        ]);
        closures.take([change(1, 5, 7, true)]);
        let ids = |closures: &mut Closures, run, time| {
            closures
                .news(run, time)
                .map(|closed| closed.iter().map(|closed| closed.edge).collect::<Vec<_>>())
        };
        assert_eq!(ids(&mut closures, 1, 4), None, "nothing is closed yet");
        assert_eq!(ids(&mut closures, 1, 10), Some(vec![3, 7]));
        assert_eq!(ids(&mut closures, 1, 11), None, "published already");
        assert_eq!(ids(&mut closures, 1, 20), Some(vec![3]));
        closures.begin_run();
        assert_eq!(ids(&mut closures, 1, 6), Some(vec![7]), "back in time");
        assert_eq!(ids(&mut closures, 2, 40), Some(vec![9]));
    }
}
