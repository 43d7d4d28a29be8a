//! Closed edges: no robot enters them, and no new route leads along them.

use regatta_layout::EdgeIndex;
use regatta_plugin::closure::ClosedEdge;
use regatta_plugin::event::{EventKind, EventRecord};
use regatta_plugin::frame::RobotState;
use regatta_plugin::order::NO_ROBOT;

use super::{EventBuffer, Fleet};

impl Fleet {
    /// Closes an edge. Robots on it leave it; robots that come to it wait before it.
    pub(super) fn close_edge(&mut self, edge: EdgeIndex, events: &mut EventBuffer) {
        if self.motion.legs.close(edge) {
            self.note_closure(EventKind::EdgeClosed, edge, events);
        }
    }

    /// Opens a closed edge. Robots that wait before it drive on.
    pub(super) fn open_edge(&mut self, edge: EdgeIndex, events: &mut EventBuffer) {
        if !self.motion.legs.open(edge) {
            return;
        }
        self.note_closure(EventKind::EdgeOpened, edge, events);
        self.start_waiting(events);
    }

    /// Lets robots drive on that wait before an edge which they may enter by now.
    pub(super) fn start_waiting(&mut self, events: &mut EventBuffer) {
        for row in 0..self.robots() {
            if self.is(row, RobotState::Waiting)
                && self.motion.may_leave(&self.columns.all_rows(), row)
            {
                self.motion.start_driving(&mut self.columns.all_rows(), row, events);
            }
        }
    }

    /// The edges that are closed, sorted by id.
    pub fn closed_edges(&self) -> Vec<ClosedEdge> {
        let closed = self.motion.legs.closed();
        let mut closed: Vec<_> =
            closed.map(|edge| ClosedEdge { edge: self.graph.edge(edge).id }).collect();
        closed.sort_unstable();
        closed
    }

    /// The number of closures and openings of edges.
    pub fn closure_changes(&self) -> u64 {
        self.closure_changes
    }

    /// Reports a change.
    fn note_closure(&mut self, kind: EventKind, edge: EdgeIndex, events: &mut EventBuffer) {
        self.closure_changes += 1;
        let id = self.graph.edge(edge).id;
        events.push_record(EventRecord {
            kind: kind as u32,
            robot: NO_ROBOT,
            id,
            ..EventRecord::default()
        });
        self.look_ahead_again();
    }

    /// Lets all robots look ahead again, because those that can't stop at once have looked ahead
    /// along edges that they may enter no more, or not yet.
    pub(super) fn look_ahead_again(&mut self) {
        for row in 0..self.robots() {
            if !self.is(row, RobotState::Absent) {
                self.motion.update_base(&mut self.columns.all_rows(), row);
            }
        }
    }
}
