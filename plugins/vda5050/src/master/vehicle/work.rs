//! The work of a vehicle: what it is told of its course, its stops and its battery.

use regatta_plugin::order::StopAction;

use super::super::roads::Roads;
use super::super::talk::{After, Saying};
use super::Vehicle;
use crate::message::ActionParameter;

/// The time after a robot has come to a charger until it begins to charge, in seconds.
const CHARGE_AFTER: f64 = 1.0;
/// The charge up to which a robot that stands at a charger begins to charge, in per cent.
const CHARGE_BELOW: f64 = 95.0;
/// The action that begins to charge.
const CHARGE: &str = "startCharging";

impl Vehicle {
    /// Returns what to tell it now. `is_closed` says whether an edge is closed.
    pub fn say(
        &mut self,
        roads: &Roads,
        is_closed: impl Fn(u32) -> bool,
        now: f64,
    ) -> Option<Saying> {
        if self.trouble.as_ref().is_some_and(|trouble| !trouble.may_be_told()) {
            return None;
        }
        self.charge_at_rest(roads, now);
        let (Some(state), Some(course)) = (&self.state, &self.course) else { return None };
        let next = course.ahead().front().filter(|step| step.released);
        self.is_barred = next.is_some_and(|step| is_closed(step.leg.edge.0));
        self.talk.say(state, course, roads, self.is_held || self.is_barred, now)
    }

    /// Lets a vehicle without work charge that stands at a charger.
    fn charge_at_rest(&mut self, roads: &Roads, now: f64) {
        let (Some(state), Some(course)) = (&self.state, &self.course) else { return };
        let rests = course.is_at_end(roads)
            && course.ahead().is_empty()
            && !self.talk.has_jobs()
            && roads.node(roads.end(course.place().0)).is_charger
            && !state.power_supply.charging
            && state.power_supply.state_of_charge < CHARGE_BELOW;
        if !rests {
            self.rests_since = None;
        } else if now - *self.rests_since.get_or_insert(now) >= CHARGE_AFTER {
            // Until then it may have been sent elsewhere, or it refuses to charge.
            self.rests_since = Some(f64::INFINITY);
            self.talk.add_job(CHARGE, Vec::new());
        }
    }

    /// Lets it carry out the action of a stop where it stands. `parameters` has those of a kind of
    /// action.
    pub fn handle(
        &mut self,
        action: StopAction,
        parameters: impl FnOnce(&str) -> Vec<ActionParameter>,
    ) {
        let kind = match action {
            StopAction::Pick => "pick",
            StopAction::Drop => "drop",
            StopAction::Charge => CHARGE,
            StopAction::None | StopAction::Park => return,
        };
        self.talk.add_job(kind, parameters(kind));
    }

    /// Drops its route beyond the edge that it is on.
    pub fn cancel(&mut self, roads: &Roads) {
        let Some(course) = &mut self.course else { return };
        course.drop_horizon();
        if course.base_end(roads) > course.first(roads) && !course.ahead().is_empty() {
            self.talk.cancel(After::End);
        }
    }
}
