//! The legs that a robot is going to drive.

use regatta_layout::Leg;
use regatta_motion::{RouteCursor, leg_of};
use regatta_plugin::frame::RobotState;

use super::{Fleet, Route};

/// The legs that a robot has still to drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ahead<'fleet> {
    /// The leg that it is on; `None` at its end, on a node, without a route, or if it has driven
    /// it.
    pub on: Option<Leg>,
    /// The legs after that which it may drive now.
    pub base: &'fleet [Leg],
    /// Metres of the last released leg that are released, from where it is entered; infinity for
    /// all of it.
    pub released_metres: f32,
    /// The legs after those: planned, not released. Of a loop, the rest of one lap.
    pub horizon: &'fleet [Leg],
}

impl Fleet {
    /// Returns the legs that a robot has still to drive; `None` if there is no such robot. Reads
    /// one row and copies no route.
    pub fn ahead(&self, robot: u32) -> Option<Ahead<'_>> {
        let row = self.row(robot).ok()?;
        let (piece, route) = (self.columns.piece.get(row), self.columns.route[row]);
        let plans = &self.motion.plans;
        let is_driving = route != Route::PARKED
            && self.columns.state[row] != RobotState::Idle as u8
            && !self.motion.legs.is_leg_end(piece, self.columns.w[row]);
        let on = leg_of(piece, self.columns.edge[row]).filter(|_| is_driving);
        let base = plans.base(route);
        let is_released = on.is_some() || !base.is_empty();
        let released_metres = if is_released { plans.limit(route) as f32 } else { f32::INFINITY };
        Some(Ahead { on, base, released_metres, horizon: plans.horizon(route) })
    }

    /// Returns the legs that a random walk takes after the one that the robot is on: they are drawn
    /// from the seed. Any other route has none.
    pub fn walk_ahead(&self, robot: u32) -> impl Iterator<Item = Leg> + Clone {
        let row = self.row(robot).ok().filter(|row| self.columns.route[*row].is_walk());
        let mut cursor = row.map(|row| RouteCursor {
            robot,
            route: self.columns.route[row],
            node: self.node_ahead(row),
            leg: leg_of(self.columns.piece.get(row), self.columns.edge[row]),
        });
        std::iter::from_fn(move || self.motion.next_leg(cursor.as_mut()?).ok())
    }

    /// Whether a robot drives on without another command when it has driven all legs
    /// [ahead](Self::ahead).
    pub fn drives_on(&self, robot: u32) -> bool {
        self.row(robot).is_ok_and(|row| self.motion.plans.is_endless(self.columns.route[row]))
    }
}

impl<'fleet> Ahead<'fleet> {
    /// Number of legs that it may drive now, including the one that it is on.
    pub fn released(&self) -> usize {
        usize::from(self.on.is_some()) + self.base.len()
    }

    /// Number of all legs.
    pub fn len(&self) -> usize {
        self.released() + self.horizon.len()
    }

    /// Whether it has nothing to drive.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// All legs, in the order in which they are driven.
    pub fn legs(&self) -> impl Iterator<Item = Leg> + use<'fleet> {
        self.on.into_iter().chain(self.base.iter().copied()).chain(self.horizon.iter().copied())
    }
}
