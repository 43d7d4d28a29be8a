//! Hand-over: what happens to the few robots that come to the end of their piece in a tick, and how any robot is
//! put on a leg.

use regatta_plugin::event::EventKind;
use regatta_plugin::frame::{NO_EDGE, RobotState};

use super::{Listed, Motion, Onward, PIECE, REVERSE, Rows};
use crate::fleet::{Ending, Events};
use crate::graph::{Leg, NodeIndex};

impl Motion {
    /// Takes robots over to the next piece of their leg, which is all that most need, without a branch; those for which
    /// it is not all stay on the list.
    pub(super) fn next_pieces(&self, rows: &mut Rows, arrived: &mut Listed) {
        let stretches = self.roads.stretches();
        let mut left = 0;
        for number in 0..arrived.len {
            let row = usize::from(arrived.rows[number]);
            let place = (rows.piece[row] & PIECE) as usize;
            let next = stretches[(place + 1).min(stretches.len() - 1)];
            let w = rows.w[row] - next.length();
            let is_all = !stretches[place].is_last() && w < 0;
            rows.piece[row] += u32::from(is_all);
            rows.w[row] = if is_all { w } else { rows.w[row] };
            rows.s_end[row] = if is_all { next.s_end } else { rows.s_end[row] };
            if let Some(limits) = &mut rows.limits {
                limits.rest[row] = self.roads.rest(rows.piece[row]);
            }
            arrived.rows[left] = row as u16;
            left += usize::from(!is_all);
        }
        arrived.len = left;
    }

    /// Takes a robot with `w` ≥ 0 over to the piece where it is by now, or lets it stand at the end of its base.
    ///
    /// The distance that it went too far on one leg is gone on the next, exactly; if its speed changes there, the
    /// time is kept and not the distance.
    pub(super) fn hand_over(&self, rows: &mut Rows, row: usize, events: &mut Events) {
        while rows.w[row] >= 0 {
            if !self.roads.stretch(rows.piece[row]).is_last() {
                self.put_on_piece(rows, row, rows.piece[row] + 1, rows.w[row]);
            } else if !self.leave_leg(rows, row, events) {
                return;
            }
        }
    }

    /// Drives a robot to the end of its leg and beyond, in a block where some types have limits.
    pub(super) fn hand_over_limited(&self, rows: &mut Rows, row: usize, events: &mut Events) {
        let before = rows.speed[row];
        self.drive_on(rows, row);
        self.hand_over(rows, row, events);
        if rows.is(row, RobotState::Held) && rows.speed[row] == 0.0 && before > 0.0 {
            self.stand(rows, row, events);
        }
    }

    /// Goes on to the next leg; `false` if there is none.
    fn leave_leg(&self, rows: &mut Rows, row: usize, events: &mut Events) -> bool {
        let mut onward = self.onward(rows, row);
        self.report_node(rows, row, onward.node, events);
        match self.next_leg(&mut onward) {
            Ok(leg) => self.enter(rows, row, leg, &onward, rows.w[row]),
            Err(ending) => {
                self.end_base(rows, row, ending, events);
                return false;
            }
        }
        true
    }

    fn report_node(&self, rows: &Rows, row: usize, node: NodeIndex, events: &mut Events) {
        if events.wanted() {
            events.push(EventKind::ReachedNode, rows.robot(row), self.roads.graph().node(node).id);
        }
    }

    /// Puts a robot `surplus` units past the start of a leg, as far as its speed there takes it.
    fn enter(&self, rows: &mut Rows, row: usize, leg: Leg, onward: &Onward, surplus: i32) {
        let lane = self.roads.lane(leg);
        let before = rows.speed[row];
        let turns = (lane.first_piece ^ rows.piece[row]) & REVERSE != 0;
        let cruise = self.lane_speed(rows.kind[row], leg);
        self.command_speed(rows, row, cruise);
        if self.is_limited(rows.kind[row]) {
            rows.speed[row] = if turns { 0.0 } else { before.min(cruise) };
        }
        rows.edge[row] = leg.edge.0;
        rows.route[row] = onward.route;
        let surplus = at_speed(surplus, before, rows.speed[row]);
        self.put_on_piece(rows, row, lane.first_piece, surplus);
        self.look_ahead(rows, row);
    }

    /// Puts a robot `surplus` units past the start of a piece.
    fn put_on_piece(&self, rows: &mut Rows, row: usize, piece: u32, surplus: i32) {
        let stretch = self.roads.stretch(piece);
        rows.piece[row] = piece;
        rows.w[row] = surplus - stretch.length();
        rows.s_end[row] = stretch.s_end;
        if let Some(limits) = &mut rows.limits {
            limits.rest[row] = self.roads.rest(piece);
        }
    }

    /// Lets a robot stand at the end of its leg, which is the end of its base.
    fn end_base(&self, rows: &mut Rows, row: usize, ending: Ending, events: &mut Events) {
        self.stop(rows, row);
        rows.w[row] = 0;
        let (state, event) = match ending {
            Ending::Done => (RobotState::Idle, EventKind::RouteDone),
            Ending::Unreleased => (RobotState::Waiting, EventKind::WaitingForRelease),
            Ending::DeadEnd => (RobotState::Faulted, EventKind::Faulted),
        };
        if !rows.is(row, RobotState::Held) {
            rows.state[row] = state as u8;
            events.push(event, rows.robot(row), 0);
        }
    }

    /// A robot that was told to hold has come to a stand.
    pub(super) fn stand(&self, rows: &Rows, row: usize, events: &mut Events) {
        events.push(EventKind::Held, rows.robot(row), 0);
    }

    /// Lets a robot drive what its route says, from where it stands or while it drives.
    pub(crate) fn set_off(&self, rows: &mut Rows, row: usize, events: &mut Events) {
        let rolling = rows.speed[row] > 0.0 || rows.w[row] < 0;
        rows.state[row] = RobotState::Driving as u8;
        match rows.leg(row) {
            Some(leg) if rolling => {
                self.command_speed(rows, row, self.lane_speed(rows.kind[row], leg));
                self.look_ahead(rows, row);
            }
            _ => {
                let mut onward = self.onward(rows, row);
                match self.next_leg(&mut onward) {
                    Ok(leg) => self.enter(rows, row, leg, &onward, 0),
                    Err(ending) => self.end_base(rows, row, ending, events),
                }
            }
        }
    }

    /// Tells a robot to stand: at once if its type has no limit.
    pub(crate) fn hold(&self, rows: &mut Rows, row: usize, events: &mut Events) {
        rows.state[row] = RobotState::Held as u8;
        self.command_speed(rows, row, 0.0);
        if rows.speed[row] == 0.0 {
            self.stand(rows, row, events);
        }
    }

    /// Puts a robot on a piece at `w` ≤ 0, standing and with nothing to drive.
    pub(crate) fn place(&self, rows: &mut Rows, row: usize, piece: u32, edge: Option<u32>, w: i32) {
        self.stop(rows, row);
        rows.edge[row] = edge.unwrap_or(NO_EDGE);
        rows.state[row] = RobotState::Idle as u8;
        self.put_on_piece(rows, row, piece, 0);
        rows.w[row] = w;
    }

    /// The speed of a robot of some type on a leg, in metres per second.
    pub(super) fn lane_speed(&self, kind: u16, leg: Leg) -> f32 {
        self.roads.lane(leg).speed.min(self.types[usize::from(kind)].max_speed)
    }

    /// The next leg of a route, and moves on there; or how the base ends.
    pub(crate) fn next_leg(&self, onward: &mut Onward) -> Result<Leg, Ending> {
        let leg = self.plans.next(&self.roads, onward)?;
        onward.node = self.roads.lane(leg).end;
        onward.leg = Some(leg);
        Ok(leg)
    }
}

/// How far the rest of a tick goes at another speed.
fn at_speed(surplus: i32, before: f32, now: f32) -> i32 {
    if surplus == 0 || before == now {
        return surplus;
    }
    (f64::from(surplus) * (f64::from(now) / f64::from(before)) + 0.5) as i32
}
