//! What a robot is going to drive, for whoever asks.

use super::{Fleet, Route};
use crate::graph::Leg;
use crate::motion::leg_of;

/// What a robot has still to drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ahead<'fleet> {
    /// The leg that it is on; none at its end, on a node, or without a route.
    pub on: Option<Leg>,
    /// The legs after that which it may drive now.
    pub base: &'fleet [Leg],
    /// The legs after those: planned, not released. Of a loop, what is left of one lap.
    pub horizon: &'fleet [Leg],
}

impl Fleet {
    /// What a robot has still to drive; `None` if there is no such robot. Looks at one robot and copies no route.
    pub fn ahead(&self, robot: u32) -> Option<Ahead<'_>> {
        let row = self.row(robot).ok()?;
        let (piece, route) = (self.columns.piece[row], self.columns.route[row]);
        let plans = &self.motion.plans;
        let drives = route != Route::PARKED && !self.motion.roads.is_at_end(piece, self.columns.w[row]);
        let on = leg_of(piece, self.columns.edge[row]).filter(|_| drives);
        Some(Ahead { on, base: plans.base(route), horizon: plans.horizon(route) })
    }
}

impl<'fleet> Ahead<'fleet> {
    /// How many legs it may drive now, the one that it is on among them.
    pub fn released(&self) -> usize {
        usize::from(self.on.is_some()) + self.base.len()
    }

    /// How many legs there are in all.
    pub fn len(&self) -> usize {
        self.released() + self.horizon.len()
    }

    /// Whether it has nothing to drive.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The legs, in the order in which they are driven.
    pub fn legs(&self) -> impl Iterator<Item = Leg> + use<'fleet> {
        self.on.into_iter().chain(self.base.iter().copied()).chain(self.horizon.iter().copied())
    }
}
