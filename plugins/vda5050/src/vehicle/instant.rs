//! Instant actions (2.x: 6.9; 3.0: 6.2.1).

use super::catalogue::Effect;
use super::errors::{Cause, Fault, Until};
use super::jobs::{Job, Paused, Place};
use super::{Command, Site, Vehicle};
use crate::message::{Action, ActionScope, ActionStatus, BlockingType, InstantActions};

/// The most instant actions whose states are kept: those that have ended longest ago go first.
const MOST_INSTANTS: usize = 100;

impl Vehicle {
    /// Takes instant actions. One that is there already isn't carried out again: messages may come
    /// twice.
    pub fn take_instant_actions(&mut self, message: InstantActions, site: &Site) {
        for action in message.actions {
            if self.instants.find(&action.action_id).is_none() {
                self.take_instant_action(action, site);
            }
        }
        self.instants.keep(MOST_INSTANTS);
        self.outbox.state = true;
    }

    fn take_instant_action(&mut self, action: Action, site: &Site) {
        let kind = action.action_type.clone();
        let id = action.action_id.clone();
        let Some(ability) = site.catalogue.find(&kind, ActionScope::Instant).cloned() else {
            let reason = format!("the vehicle has no instant action '{kind}'");
            let fault = Fault::new(Cause::InvalidInstantAction, reason);
            self.report(fault.about("actionId", id).about("actionType", kind));
            self.instants.push(Job::refused(action));
            return;
        };
        self.forget_faults(Until::NewInstantAction);
        let effect = ability.effect;
        // Nothing waits for an instant action, and it waits for nothing.
        let unblocking = Action { blocking_type: BlockingType::None, ..action.clone() };
        self.instants.push(Job::new(unblocking, ability, Place::Node, 0));
        self.instants.trigger(0);
        self.instants.begin_possible();
        self.act(&action, effect, site);
    }

    /// Does what an instant action does at its beginning.
    fn act(&mut self, action: &Action, effect: Effect, site: &Site) {
        let id = &action.action_id;
        let aim = action.text("actionId").unwrap_or_default();
        match effect {
            Effect::Pauses => self.pause(Paused::Yes, Command::Hold),
            Effect::Resumes => {
                self.pause(Paused::Ending, Command::Resume);
                self.end_instant(id, Ok(()));
            }
            Effect::Cancels => self.cancel_order(action),
            Effect::AsksForState => self.end_instant(id, Ok(())),
            Effect::AsksForFactsheet => {
                self.outbox.factsheet = true;
                self.end_instant(id, Ok(()));
            }
            Effect::Triggers => {
                let waited = self.jobs.release_waiting();
                self.end_instant(id, waited.then_some(()).ok_or("no action waits".to_owned()));
                self.advance(site);
            }
            Effect::Retries => {
                let tried = self.jobs.retry(aim);
                self.end_instant(id, tried.then_some(()).ok_or_else(|| not_retriable(aim)));
            }
            Effect::GivesUp => {
                let ended = self.jobs.give_up(aim);
                self.end_instant(id, ended.then_some(()).ok_or_else(|| not_retriable(aim)));
                self.advance(site);
            }
            Effect::Clears => {
                self.end_instant(id, Ok(()));
                self.instants.forget_ended();
            }
            _ => {}
        }
    }

    fn pause(&mut self, paused: Paused, command: Command) {
        self.paused = paused;
        self.jobs.pause(paused);
        if command == Command::Resume && self.condition.holds() {
            // It goes on when it can.
            self.paused = Paused::No;
            return;
        }
        self.outbox.commands.push(command);
    }
}

fn not_retriable(action_id: &str) -> String {
    format!("the action '{action_id}' doesn't wait to be tried again")
}

impl Job {
    /// An action that isn't carried out.
    fn refused(action: Action) -> Self {
        let ability = super::catalogue::Ability {
            name: action.action_type.clone(),
            effect: Effect::Lasts,
            scopes: &[],
            seconds: None,
        };
        let mut job = Self::new(action, ability, Place::Node, 0);
        job.end(ActionStatus::Failed);
        job
    }
}
