//! Bases that end within a leg: the limit of a release by distance.
//!
//! The kernel needs to know only how far it is to the place where a robot may have to stop:
//! [`rest`](super::LimitRows::rest) leads there instead of to the end of the leg. So robots that
//! come near it are listed, and the few listed ones are examined exactly, in units of
//! [`Distance`](crate::piece::Distance): none of them drives beyond it.

use super::Motion;
use super::frame::EventSink;
use super::pieces::PieceIndex;
use super::profile::UNLIMITED;
use super::rows::{Rows, leg_of};
use crate::piece::Distance;

/// `brake` of a robot without an acceleration limit whose base ends on its leg: it never binds, but
/// is finite, so that the robot's block is examined for robots near the end of their base.
const NEVER_BINDING: f32 = f32::MAX / 4.0;

/// The part of a leg's length by which the kernel lists robots too early, so that rounding never
/// makes it too late.
const EARLY: f32 = 1e-6;

impl Motion {
    /// Computes the columns of a row's base: `stop`, `rest` and `brake`. It must follow every
    /// change of the leg or the route.
    pub fn update_base(&self, rows: &mut Rows, row: usize) {
        if rows.limits.is_none() {
            return;
        }
        let limit = self.plans.limit_on_leg(rows.route[row]);
        let stop = match rows.leg(row) {
            Some(leg) if limit.is_finite() => {
                let length = self.legs.leg(leg).length;
                (length - limit as f32).max(0.0) + EARLY * (1.0 + length)
            }
            _ => 0.0,
        };
        let acceleration = self.limits[usize::from(rows.robot_type[row])].max_acceleration;
        let brake = match (acceleration.is_finite(), stop > 0.0) {
            (true, _) => self.brake(rows, row, acceleration),
            (false, true) => NEVER_BINDING,
            (false, false) => f32::INFINITY,
        };
        let rest = self.legs.rest(rows.piece.get(row)) - stop;
        if let Some(limits) = &mut rows.limits {
            (limits.stop[row], limits.rest[row], limits.brake[row]) = (stop, rest, brake);
        }
    }

    /// Fills the columns of limits of a fleet that had none: no robot type limits its acceleration.
    pub fn fill_limits(&self, rows: &mut Rows) {
        let Some(limits) = &mut rows.limits else { return };
        limits.acceleration.fill(UNLIMITED);
        limits.cruise.copy_from_slice(rows.speed);
        limits.brake.fill(f32::INFINITY);
        limits.stop.fill(0.0);
        for (row, rest) in limits.rest.iter_mut().enumerate() {
            *rest = self.legs.rest(rows.piece.get(row));
        }
    }

    /// Returns the metres that a robot has driven on its leg; `None` if it stands at the leg's end
    /// or on a node.
    pub fn driven_on_leg(&self, piece: PieceIndex, edge: u32, w: i32) -> Option<f64> {
        let leg = leg_of(piece, edge).filter(|_| !self.legs.is_leg_end(piece, w))?;
        Some(self.legs.driven(leg, piece) + Distance(w).to_metres())
    }

    /// Returns the metres from a robot to the end of its leg, or of its base if that is on the leg.
    pub(super) fn distance_to_end(&self, rows: &Rows, row: usize) -> f64 {
        match self.limit(rows, row) {
            Some(limit) => (limit - i64::from(rows.w[row])) as f64 * Distance(1).to_metres(),
            None => {
                f64::from(self.legs.rest(rows.piece.get(row))) - Distance(rows.w[row]).to_metres()
            }
        }
    }

    /// Stops a robot that has reached the place where its base ends on its leg, exactly there.
    /// Returns whether it has.
    pub(super) fn stop_at_limit(
        &self,
        rows: &mut Rows,
        row: usize,
        events: &mut dyn EventSink,
    ) -> bool {
        let Some(limit) = self.limit_on_piece(rows, row).filter(|limit| rows.w[row] >= *limit)
        else {
            return false;
        };
        rows.w[row] = limit;
        let end = self.plans.end_at_limit(rows.route[row]);
        self.stand(rows, row, end, events);
        true
    }

    /// Returns the `w` at which a robot's base ends, if that is on its piece.
    fn limit_on_piece(&self, rows: &Rows, row: usize) -> Option<i32> {
        let limit = self.limit(rows, row)?;
        let span = self.legs.span(rows.piece.get(row));
        // At `w` = 0 of its last piece the leg would be driven.
        let last = if span.is_last() {
            Some(limit.min(-1))
        } else {
            Some(limit).filter(|limit| *limit < 0)
        };
        // Pieces' ends are rounded: a limit at a piece's start may come out before it.
        last.map(|limit| limit.max(-i64::from(span.length())) as i32)
    }

    /// Returns the distance from the end of a robot's piece to the place where its base ends on its
    /// leg, rounded down to units.
    fn limit(&self, rows: &Rows, row: usize) -> Option<i64> {
        rows.limits.as_ref().filter(|limits| limits.stop[row] > 0.0)?;
        let limit = self.plans.limit_on_leg(rows.route[row]);
        let ahead = limit - self.legs.driven(rows.leg(row)?, rows.piece.get(row));
        Some((ahead / Distance(1).to_metres()).floor() as i64)
    }
}
