//! The course of an order: driving and actions.

use super::catalogue::Effect;
use super::errors::{Cause, Fault};
use super::jobs::Job;
use super::{Charging, Command, Site, Vehicle};
use crate::message::{Action, ActionStatus, Load, Version};

impl Vehicle {
    /// Begins what can begin, and drives as far as nothing holds the vehicle.
    pub(super) fn advance(&mut self, site: &Site) {
        while self.cancelling.is_none() {
            let begun_at_node = self.jobs.begin_possible();
            let reachable = self.progress.reachable(&mut self.jobs);
            // The edge may have been entered just now.
            if self.jobs.begin_possible() || begun_at_node {
                self.outbox.state = true;
            }
            if reachable > self.progress.granted {
                self.grant(reachable, site);
            }
            let stays = self.progress.steps.front().is_some_and(|step| step.leg.is_none());
            if !(stays && self.progress.granted > 0) {
                return;
            }
            self.progress.traverse(&mut self.jobs);
            self.outbox.state = true;
        }
    }

    /// Lets the engine drive so many steps; those behind them are its horizon.
    fn grant(&mut self, reachable: usize, site: &Site) {
        let new = self.progress.steps.iter().enumerate().skip(self.progress.granted);
        let legs = new.filter_map(|(index, step)| {
            let leg = site.map.route_leg(step.leg?)?;
            Some(if index < reachable { leg } else { leg.horizon() })
        });
        let legs: Vec<_> = legs.collect();
        self.progress.granted = reachable;
        if legs.first().is_some_and(|leg| leg.released) {
            self.outbox.commands.push(Command::Extend(legs));
        }
    }

    /// Lets simulated time pass for the actions that run.
    pub(super) fn let_time_pass(&mut self, seconds: f64, site: &Site) {
        let ended = self.jobs.pass(seconds);
        for id in &ended {
            self.conclude_job(id, site);
        }
        for id in self.instants.pass(seconds) {
            self.conclude_instant(&id, site);
        }
        if self.is_standing() && self.instants.end_pausing() {
            self.outbox.state = true;
        }
        if !ended.is_empty() {
            self.advance(site);
        }
    }

    /// Ends an action of the order that has taken its time.
    fn conclude_job(&mut self, id: &str, site: &Site) {
        let Some((action, effect)) = self.jobs.find(id).map(Job::parts) else { return };
        let outcome = if self.fate.fails_action() {
            Err("a disturbance lets this action fail".to_owned())
        } else {
            self.carry_out(&action, effect, site)
        };
        let can_be_tried_again = self.version == Version::V3_0 && action.retriable == Some(true);
        let status = match &outcome {
            Ok(()) => ActionStatus::Finished,
            Err(_) if can_be_tried_again => ActionStatus::Retriable,
            Err(_) => ActionStatus::Failed,
        };
        if let Some(job) = self.jobs.find(id) {
            job.end(status);
            job.result = outcome.as_ref().err().cloned();
        }
        self.tell_outcome(id, outcome);
    }

    /// Ends an instant action that has taken its time.
    fn conclude_instant(&mut self, id: &str, site: &Site) {
        let Some((action, effect)) = self.instants.find(id).map(Job::parts) else { return };
        let outcome = self.carry_out(&action, effect, site);
        self.end_instant(id, outcome);
    }

    /// Ends an instant action.
    pub(super) fn end_instant(&mut self, id: &str, outcome: Result<(), String>) {
        if let Some(job) = self.instants.find(id) {
            job.end(match outcome {
                Ok(()) => ActionStatus::Finished,
                Err(_) => ActionStatus::Failed,
            });
        }
        self.tell_outcome(id, outcome);
    }

    fn tell_outcome(&mut self, id: &str, outcome: Result<(), String>) {
        self.outbox.state = true;
        if let Err(reason) = outcome {
            self.report(Fault::new(Cause::ActionFailed, reason).about("actionId", id));
        }
    }

    /// Does what an action does at its end.
    ///
    /// # Errors
    /// The reason if it fails.
    fn carry_out(&mut self, action: &Action, effect: Effect, site: &Site) -> Result<(), String> {
        match effect {
            Effect::Picks => self.pick(action),
            Effect::Drops => self.drop_load(action),
            Effect::Charges => self.charge(site),
            Effect::EndsCharging => {
                self.charging = Charging::No;
                Ok(())
            }
            Effect::Localizes => self.localize(action, site),
            _ => Ok(()),
        }
    }

    fn pick(&mut self, action: &Action) -> Result<(), String> {
        let place = action.text("lhd").map(str::to_owned);
        if self.loads.iter().any(|load| load.load_position == place) {
            return Err("there is a load already".to_owned());
        }
        self.loads.push(Load {
            load_id: action.text("loadId").map(str::to_owned),
            load_type: action.text("loadType").map(str::to_owned),
            load_position: place,
            weight: None,
        });
        Ok(())
    }

    fn drop_load(&mut self, action: &Action) -> Result<(), String> {
        let (place, id) = (action.text("lhd"), action.text("loadId"));
        let found = self.loads.iter().rposition(|load| {
            place.is_none_or(|place| load.load_position.as_deref() == Some(place))
                && id.is_none_or(|id| load.load_id.as_deref().is_none_or(|load| load == id))
        });
        let index = found.ok_or_else(|| "there is no such load".to_owned())?;
        self.loads.remove(index);
        Ok(())
    }

    fn charge(&mut self, site: &Site) -> Result<(), String> {
        let node = self.here.and_then(|here| site.map.node(here));
        if !node.is_some_and(|node| node.is_charger) {
            return Err("the vehicle isn't at a charger".to_owned());
        }
        self.charging = Charging::Yes;
        Ok(())
    }

    /// A vehicle knows where it is: only what it knows is taken.
    fn localize(&mut self, action: &Action, site: &Site) -> Result<(), String> {
        /// The largest difference to the pose that it knows, in metres.
        const TOLERANCE: f64 = 1.0;
        let seen = self.seen.ok_or("the vehicle has no position yet")?;
        let [x, y] = ["x", "y"].map(|key| action.number(key));
        let (Some(x), Some(y)) = (x, y) else { return Err("x or y is missing".to_owned()) };
        if (x - seen.x).hypot(y - seen.y) > TOLERANCE {
            return Err(format!("the vehicle is at ({:.2}, {:.2})", seen.x, seen.y));
        }
        let Some(id) = action.text("lastNodeId") else { return Ok(()) };
        if site.map.find_node(id) != self.here || self.here.is_none() {
            return Err(format!("the vehicle isn't at the node '{id}'"));
        }
        id.clone_into(&mut self.progress.last_node_id);
        Ok(())
    }
}
