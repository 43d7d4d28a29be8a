//! Closed edges: nobody enters them, and no new route leads along them.

use regatta_layout::EdgeIndex;
use regatta_plugin::closure::ClosedEdge;
use regatta_plugin::event::{EventKind, EventRecord};
use regatta_plugin::frame::RobotState;
use regatta_plugin::order::NO_ROBOT;

use super::{EventBuffer, Fleet};

impl Fleet {
    /// Closes an edge. Who is on it leaves it; who comes to it waits before it.
    pub(super) fn close_edge(&mut self, edge: EdgeIndex, events: &mut EventBuffer) {
        if self.motion.legs.close(edge) {
            self.note_closure(EventKind::EdgeClosed, edge, events);
        }
    }

    /// Opens a closed edge again. Who waits before it drives on.
    pub(super) fn open_edge(&mut self, edge: EdgeIndex, events: &mut EventBuffer) {
        if !self.motion.legs.open(edge) {
            return;
        }
        self.note_closure(EventKind::EdgeOpened, edge, events);
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
        let id = |edge: EdgeIndex| ClosedEdge { edge: self.graph.edge(edge).id };
        let mut closed: Vec<_> = self.motion.legs.closed().map(id).collect();
        closed.sort_unstable();
        closed
    }

    /// How often edges were closed or opened.
    pub fn closure_changes(&self) -> u64 {
        self.closure_changes
    }

    /// Reports a change. Robots that can't stop at once look ahead, so that all of them look again.
    fn note_closure(&mut self, kind: EventKind, edge: EdgeIndex, events: &mut EventBuffer) {
        self.closure_changes += 1;
        let id = self.graph.edge(edge).id;
        events.push_record(EventRecord {
            kind: kind as u32,
            robot: NO_ROBOT,
            id,
            ..EventRecord::default()
        });
        for row in 0..self.robots() {
            if !self.is(row, RobotState::Absent) {
                self.motion.update_base(&mut self.columns.all_rows(), row);
            }
        }
    }
}
