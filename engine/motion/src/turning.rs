//! Turns on the spot: at a node where the heading of the next leg differs from the robot's.
//!
//! Only types with a rotation speed turn; others drive through, and their heading jumps. A robot
//! arrives at the node at speed 0 (`profile.rs` brakes for it), turns by the shorter way or as the
//! edges say, and enters the next leg when its heading is that of the leg's start. A turn takes
//! whole ticks. Its rate follows the same velocity profile as driving, with angles in place of
//! distances.

use regatta_base::graph::{EdgeIndex, Leg, Rotation};

use super::frame::EventSink;
use super::headings::{HeadingRule, NEGLIGIBLE_TURN, SMOOTH, tangent_angle, turn_between, wrap};
use super::pieces::PieceIndex;
use super::profile::brake_speed;
use super::rows::RowList;
use super::rows::Rows;
use super::{KinematicLimits, Motion};
use crate::frame::RobotState;
use crate::piece::Distance;

impl Motion {
    /// Lists the rows that turn at the start of a tick.
    pub(super) fn list_turning(&self, rows: &Rows, list: &mut RowList) {
        if self.limits.iter().any(KinematicLimits::can_turn) {
            for (row, state) in rows.state.iter().enumerate() {
                if *state == RobotState::Turning as u8 {
                    list.push(row);
                }
            }
        }
    }

    /// Whether a robot of some type has to turn between two legs.
    pub(super) fn turns_between(&self, robot_type: u16, from: Option<Leg>, to: Leg) -> bool {
        match (&self.headings, from) {
            (Some(headings), Some(from)) if self.limits[usize::from(robot_type)].can_turn() => {
                is_turn(headings.end(from), headings.start(to), headings.rotation(Some(from), to))
            }
            _ => false,
        }
    }

    /// Whether a robot that stands at the start of a leg has to turn before it drives it.
    pub(super) fn must_turn(&self, rows: &Rows, row: usize, leg: Leg) -> bool {
        let Some(headings) = &self.headings else { return false };
        let can_turn = self.limits[usize::from(rows.robot_type[row])].can_turn();
        can_turn
            && is_turn(
                self.heading(rows, row),
                headings.start(leg),
                headings.rotation(rows.leg(row), leg),
            )
    }

    /// Stops a robot at the end of its leg and makes it turn, unless it is held.
    pub(super) fn begin_turn(&self, rows: &mut Rows, row: usize) {
        self.stop(rows, row);
        rows.w[row] = rows.w[row].min(0);
        let heading = self.heading(rows, row);
        self.set_heading_rule(rows, row, HeadingRule::fixed(heading));
        if !rows.is_stopped(row) {
            rows.state[row] = RobotState::Turning as u8;
        }
    }

    /// Turns a robot for a tick; at the end of the turn it enters its next leg.
    pub(super) fn turn(&self, rows: &mut Rows, row: usize, events: &mut dyn EventSink) {
        if !rows.is(row, RobotState::Turning) {
            return;
        }
        let mut cursor = self.route_cursor(rows, row);
        let leg = match self.next_leg(&mut cursor) {
            Ok(leg) => leg,
            Err(end) => return self.end_base(rows, row, end, events),
        };
        let before = rows.leg(row);
        let (Some(headings), Some(columns)) = (&self.headings, &mut rows.headings) else { return };
        let left =
            turn_between(columns.offset[row], headings.start(leg), headings.rotation(before, leg));
        let limits = &self.limits[usize::from(rows.robot_type[row])];
        let (rate, step) = turn_step(limits, columns.rate[row], left.abs(), self.time_step.seconds);
        if step < left.abs() - NEGLIGIBLE_TURN {
            columns.rate[row] = rate;
            columns.offset[row] = wrap(columns.offset[row] + step.copysign(left));
            return;
        }
        rows.state[row] = RobotState::Driving as u8;
        self.enter_leg(rows, row, leg, &cursor, 0);
    }

    /// Makes the heading of a row that of the edge that it is on, or of the node.
    pub(super) fn follow_edge(&self, rows: &mut Rows, row: usize, edge: Option<EdgeIndex>) {
        let Some(headings) = &self.headings else { return };
        let rule = edge.map_or(HeadingRule::TANGENT, |edge| headings.rule(edge));
        self.set_heading_rule(rows, row, rule);
    }

    fn set_heading_rule(&self, rows: &mut Rows, row: usize, rule: HeadingRule) {
        if let Some(columns) = &mut rows.headings {
            columns.gain[row] = rule.gain;
            columns.offset[row] = rule.offset;
            columns.rate[row] = 0.0;
        }
    }

    /// Returns x, y and heading at a distance `w` from the end of a piece, as in frames.
    pub fn pose(&self, piece: PieceIndex, w: i32, rule: HeadingRule) -> [f32; 3] {
        let [x, y] =
            self.legs.pieces()[piece.row()].position(Distance(w).to_metres() as f32).to_array();
        [x, y, rule.heading(tangent_angle(&self.legs, piece, w))]
    }

    /// Returns the heading of a row as in frames.
    fn heading(&self, rows: &Rows, row: usize) -> f32 {
        let tangent = tangent_angle(&self.legs, rows.piece.get(row), rows.w[row].min(0));
        let rule = match &rows.headings {
            Some(columns) => HeadingRule { gain: columns.gain[row], offset: columns.offset[row] },
            None => HeadingRule::TANGENT,
        };
        rule.heading(tangent)
    }
}

/// Whether a robot turns on the spot from one heading to another.
fn is_turn(from: f32, to: f32, rotation: Rotation) -> bool {
    rotation != Rotation::None && turn_between(from, to, Rotation::Shorter).abs() > SMOOTH
}

/// Returns the rate after a tick of `seconds` that begins at `rate`, with `left` radians to turn,
/// and the angle that is turned in it.
fn turn_step(limits: &KinematicLimits, rate: f32, left: f32, seconds: f32) -> (f32, f32) {
    let acceleration = limits.max_rotation_acceleration;
    if acceleration.is_infinite() {
        return (limits.max_rotation_speed, limits.max_rotation_speed * seconds);
    }
    let change = acceleration * seconds;
    let wanted = (rate + change).min(limits.max_rotation_speed);
    let now = wanted.min(brake_speed(0.0, acceleration, change, rate, -left));
    (now, 0.5 * (rate + now) * seconds)
}
