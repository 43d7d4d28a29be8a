//! Releases by distance: a robot's base grows to a place on one of the legs ahead.

use regatta_layout::{Gear, Leg};
use regatta_motion::{Distance, leg_of};
use regatta_plugin::command::CommandRecord;
use regatta_plugin::event::Refusal;
use regatta_plugin::frame::RobotState;

use super::commands::{Action, Rejection};
use super::{EventBuffer, Fleet, Route};

impl Fleet {
    /// Prepares the release of the metres `s` of the command's leg: the first such leg at or after
    /// the end of the base.
    pub(super) fn prepare_release(
        &self,
        command: &CommandRecord,
        row: usize,
    ) -> Result<Action, Rejection> {
        let id = command.id;
        let gear = if command.reverse == 0 { Gear::Forward } else { Gear::Reverse };
        let leg = Leg { edge: self.edge(id)?, gear };
        if command.s.is_nan() || command.s < 0.0 {
            return Err(Rejection { reason: Refusal::DistanceOutOfRange, id });
        }
        let metres = if command.s >= self.motion.legs.leg(leg).length {
            f64::INFINITY
        } else {
            f64::from(command.s)
        };
        self.release_on(row, leg, metres).ok_or(Rejection { reason: Refusal::NotAhead, id })
    }

    /// Returns the action that releases a leg up to that many metres; `None` if it isn't ahead.
    fn release_on(&self, row: usize, leg: Leg, metres: f64) -> Option<Action> {
        let plans = &self.motion.plans;
        let route = self.columns.route[row];
        let (released, last) = plans.released(route);
        let limit = if last.is_some() { plans.limit(route) } else { self.limit_on_leg(row) };
        if limit.is_finite() && last.or_else(|| self.current_leg(row)) == Some(leg) {
            return Some(if metres <= limit {
                Action::Nothing
            } else {
                Action::Release { row, released, limit: metres }
            });
        }
        // A loop's horizon is its next lap, which is driven without a release.
        let horizon = if plans.is_endless(route) { &[] } else { plans.horizon(route) };
        let before = released + horizon.iter().position(|other| *other == leg)?;
        Some(if metres < Distance(1).to_metres() {
            Action::Release { row, released: before, limit: f64::INFINITY }
        } else {
            Action::Release { row, released: before + 1, limit: metres }
        })
    }

    /// Ends a robot's base on its route there.
    pub(super) fn release(
        &mut self,
        row: usize,
        released: usize,
        limit: f64,
        events: &mut EventBuffer,
    ) {
        if self.columns.route[row] == Route::PARKED {
            self.set_commanded_route(row, Vec::new(), released, limit);
        } else {
            self.allow_limit(limit);
            self.motion.plans.set_base(self.columns.route[row], released, limit);
            self.motion.update_base(&mut self.columns.all_rows(), row);
        }
        if self.is(row, RobotState::Waiting) || self.is(row, RobotState::Idle) {
            self.motion.start_driving(&mut self.columns.all_rows(), row, events);
        }
    }

    /// Gives a robot a route of legs. The last released one (without any, its current leg) is
    /// released up to `limit` metres.
    pub(super) fn set_commanded_route(
        &mut self,
        row: usize,
        legs: Vec<Leg>,
        released: usize,
        limit: f64,
    ) {
        self.allow_limit(limit);
        self.set_route(row, |plans| plans.command(legs, released, limit));
    }

    /// Returns the metres of a robot's current leg at which its base ends; infinity if it ends at
    /// the leg's end or later. Without a route, it ends where the robot stands.
    pub(super) fn limit_on_leg(&self, row: usize) -> f64 {
        let columns = &self.columns;
        match columns.route[row] {
            Route::PARKED => {
                let driven = self.motion.driven_on_leg(
                    columns.piece.get(row),
                    columns.edge[row],
                    columns.w[row],
                );
                driven.unwrap_or(f64::INFINITY)
            }
            route => self.motion.plans.limit_on_leg(route),
        }
    }

    fn current_leg(&self, row: usize) -> Option<Leg> {
        leg_of(self.columns.piece.get(row), self.columns.edge[row])
    }

    /// Adds the columns that a base needs which ends within a leg.
    fn allow_limit(&mut self, limit: f64) {
        if limit.is_finite() && self.columns.add_limits() {
            self.motion.fill_limits(&mut self.columns.all_rows());
        }
    }
}
