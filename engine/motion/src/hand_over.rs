//! Hand-over: moves the few robots that reach the end of their piece in a tick to the next one, and
//! puts robots on legs.

use regatta_base::graph::{EdgeIndex, Leg, NodeIndex};

use super::Motion;
use super::frame::{Event, EventSink};
use super::leg_table::PieceSpan;
use super::pieces::PieceIndex;
use super::routes::{BaseEnd, RouteCursor};
use super::rows::RowList;
use super::rows::Rows;
use crate::frame::{NO_EDGE, RobotState};

impl Motion {
    /// Moves robots to the next piece of their leg, without a branch: that is all that most of them
    /// need. The others stay on the list.
    pub(super) fn next_pieces(&self, rows: &mut Rows, arrived: &mut RowList) {
        let spans = self.legs.spans();
        let mut left = 0;
        for number in 0..arrived.len {
            let row = usize::from(arrived.rows[number]);
            let piece = rows.piece.get(row).row();
            let next = spans[(piece + 1).min(spans.len() - 1)];
            let w = rows.w[row] - next.length();
            let is_all = !spans[piece].is_last() && w < 0;
            rows.piece.advance_if(row, is_all);
            rows.w[row] = if is_all { w } else { rows.w[row] };
            rows.s_end[row] = if is_all { next.s_end } else { rows.s_end[row] };
            if let Some(limits) = &mut rows.limits {
                limits.rest[row] = self.legs.rest(rows.piece.get(row)) - limits.stop[row];
            }
            arrived.rows[left] = row as u16;
            left += usize::from(!is_all);
        }
        arrived.len = left;
    }

    /// Moves a robot to the piece that it has reached by now, or stops it at the end of its base.
    ///
    /// The distance beyond the end of one leg is driven on the next, exactly. If the speed changes
    /// there, the time is kept and not the distance.
    pub(super) fn hand_over(&self, rows: &mut Rows, row: usize, events: &mut dyn EventSink) {
        while !self.stop_at_limit(rows, row, events) && rows.w[row] >= 0 {
            let piece = rows.piece.get(row);
            if !self.legs.span(piece).is_last() {
                let next = self.legs.next_piece(piece);
                self.put_on_piece(rows, row, next, self.legs.span(next), rows.w[row]);
            } else if !self.leave_leg(rows, row, events) {
                return;
            }
        }
    }

    /// Drives a robot to the end of its leg and beyond, in a block where some types have limits.
    pub(super) fn hand_over_limited(
        &self,
        rows: &mut Rows,
        row: usize,
        events: &mut dyn EventSink,
    ) {
        let before = rows.speed[row];
        self.drive_near_leg_end(rows, row);
        self.hand_over(rows, row, events);
        if rows.speed[row] == 0.0 && before > 0.0 {
            self.report_held(rows, row, events);
        }
    }

    /// Moves a robot to its next leg; `false` if there is none, or it has to turn first.
    fn leave_leg(&self, rows: &mut Rows, row: usize, events: &mut dyn EventSink) -> bool {
        let mut cursor = self.route_cursor(rows, row);
        self.report_node(rows, row, cursor.node, events);
        match self.next_leg(&mut cursor) {
            Ok(leg) if self.must_turn(rows, row, leg) => {
                self.begin_turn(rows, row);
                return false;
            }
            Ok(leg) => self.enter_leg(rows, row, leg, &cursor, rows.w[row]),
            Err(end) => {
                self.end_base(rows, row, end, events);
                return false;
            }
        }
        true
    }

    fn report_node(&self, rows: &Rows, row: usize, node: NodeIndex, events: &mut dyn EventSink) {
        if events.wanted() {
            events.push(rows.robot(row), Event::ReachedNode(self.legs.node_id(node)));
        }
    }

    /// Puts a robot on a leg. `surplus` is the distance past its start that the robot would have
    /// driven at its old speed.
    pub(super) fn enter_leg(
        &self,
        rows: &mut Rows,
        row: usize,
        leg: Leg,
        cursor: &RouteCursor,
        surplus: i32,
    ) {
        let compiled = self.legs.leg(leg);
        let before = rows.speed[row];
        let changes_gear = compiled.first_piece.gear() != rows.piece.get(row).gear();
        let cruise = self.leg_speed(rows, row, leg);
        self.command_speed(rows, row, cruise);
        if self.is_limited(rows.robot_type[row]) {
            rows.speed[row] = if changes_gear { 0.0 } else { before.min(cruise) };
        }
        rows.edge[row] = leg.edge.0;
        rows.route[row] = cursor.route;
        self.follow_edge(rows, row, Some(leg.edge));
        let surplus = at_speed(surplus, before, rows.speed[row]);
        self.put_on_piece(rows, row, compiled.first_piece, compiled.first_span, surplus);
        self.update_base(rows, row);
    }

    /// Puts a robot `surplus` units past the start of a piece.
    fn put_on_piece(
        &self,
        rows: &mut Rows,
        row: usize,
        piece: PieceIndex,
        span: PieceSpan,
        surplus: i32,
    ) {
        rows.piece.set(row, piece);
        rows.w[row] = surplus - span.length();
        rows.s_end[row] = span.s_end;
        if let Some(limits) = &mut rows.limits {
            limits.rest[row] = self.legs.rest(piece) - limits.stop[row];
        }
    }

    /// Stops a robot at the end of its leg, which is the end of its base.
    pub(super) fn end_base(
        &self,
        rows: &mut Rows,
        row: usize,
        end: BaseEnd,
        events: &mut dyn EventSink,
    ) {
        rows.w[row] = 0;
        self.stand(rows, row, end, events);
    }

    /// Stops a robot where it is, at the end of its base.
    pub(super) fn stand(
        &self,
        rows: &mut Rows,
        row: usize,
        end: BaseEnd,
        events: &mut dyn EventSink,
    ) {
        self.stop(rows, row);
        let (state, event) = match end {
            BaseEnd::Done => (RobotState::Idle, Event::RouteDone),
            BaseEnd::Unreleased => (RobotState::Waiting, Event::WaitingForRelease),
            BaseEnd::DeadEnd => (RobotState::Faulted, Event::Faulted),
        };
        if !rows.is_stopped(row) {
            rows.state[row] = state as u8;
            events.push(rows.robot(row), event);
        }
    }

    /// Reports that a robot has come to a stop, if it has a hold command.
    pub(super) fn report_held(&self, rows: &Rows, row: usize, events: &mut dyn EventSink) {
        if rows.is(row, RobotState::Held) {
            events.push(rows.robot(row), Event::Held);
        }
    }

    /// Makes a robot follow its route, whether it stands or drives.
    pub fn start_driving(&self, rows: &mut Rows, row: usize, events: &mut dyn EventSink) {
        let is_on_leg = rows.speed[row] > 0.0 || rows.w[row] < 0;
        rows.state[row] = RobotState::Driving as u8;
        if self.stop_at_limit(rows, row, events) {
            return;
        }
        match rows.leg(row) {
            Some(leg) if is_on_leg => {
                self.command_speed(rows, row, self.leg_speed(rows, row, leg));
                self.update_base(rows, row);
            }
            _ => {
                let mut cursor = self.route_cursor(rows, row);
                match self.next_leg(&mut cursor) {
                    Ok(leg) if self.must_turn(rows, row, leg) => self.begin_turn(rows, row),
                    Ok(leg) => self.enter_leg(rows, row, leg, &cursor, 0),
                    Err(end) => self.end_base(rows, row, end, events),
                }
            }
        }
    }

    /// Whether a robot that waits at the end of its leg, or on a node, may drive its next leg by
    /// now.
    pub fn may_leave(&self, rows: &Rows, row: usize) -> bool {
        let is_at_end = self.legs.is_leg_end(rows.piece.get(row), rows.w[row]);
        is_at_end && self.next_leg(&mut self.route_cursor(rows, row)).is_ok()
    }

    /// Makes a robot stop, at once if its type has no acceleration limit.
    pub fn hold(&self, rows: &mut Rows, row: usize, events: &mut dyn EventSink) {
        rows.state[row] = RobotState::Held as u8;
        self.command_speed(rows, row, 0.0);
        if rows.speed[row] == 0.0 {
            self.report_held(rows, row, events);
        }
    }

    /// Makes a robot stop as [`hold`](Self::hold) does, in another state in which it may not drive.
    pub fn impair(&self, rows: &mut Rows, row: usize, state: RobotState) {
        rows.state[row] = state as u8;
        self.command_speed(rows, row, 0.0);
    }

    /// Puts a robot on a piece at `w` ≤ 0, idle.
    pub fn place(&self, rows: &mut Rows, row: usize, piece: PieceIndex, edge: Option<u32>, w: i32) {
        self.stop(rows, row);
        rows.edge[row] = edge.unwrap_or(NO_EDGE);
        rows.state[row] = RobotState::Idle as u8;
        self.follow_edge(rows, row, edge.map(EdgeIndex));
        self.put_on_piece(rows, row, piece, self.legs.span(piece), 0);
        rows.w[row] = w;
    }

    /// Returns the speed of a robot on a leg, in metres per second.
    pub(super) fn leg_speed(&self, rows: &Rows, row: usize, leg: Leg) -> f32 {
        let speed =
            self.legs.leg(leg).speed.min(self.limits[usize::from(rows.robot_type[row])].max_speed);
        self.variation.apply(speed, rows.robot(row), leg.edge)
    }

    /// Returns the released leg that a robot drives next as soon as it may, even if that is closed
    /// or barred now.
    pub fn wanted_leg(&self, cursor: &RouteCursor) -> Option<Leg> {
        self.plans.wanted(&self.legs, cursor).ok().map(|(leg, _)| leg)
    }

    /// Returns the next leg of a route and moves the cursor to its end; or the reason why there is
    /// none.
    pub fn next_leg(&self, cursor: &mut RouteCursor) -> Result<Leg, BaseEnd> {
        let leg = self.plans.next(&self.legs, cursor)?;
        cursor.node = self.legs.leg(leg).end;
        cursor.leg = Some(leg);
        Ok(leg)
    }
}

/// Returns the distance that the rest of a tick covers at another speed.
fn at_speed(surplus: i32, before: f32, now: f32) -> i32 {
    if surplus == 0 || before == now {
        return surplus;
    }
    (f64::from(surplus) * (f64::from(now) / f64::from(before)) + 0.5) as i32
}
