//! Cancelling an order (2.x: 6.6.3; 3.0: 6.1.3). The vehicle stops at the next node.

use regatta_plugin::frame::RobotState;

use super::errors::{Cause, Fault};
use super::jobs::Job;
use super::order::End;
use super::{Command, Vehicle};
use crate::message::Action;

/// An order that is being cancelled.
#[derive(Clone, Debug)]
pub(super) struct Cancelling {
    /// The instant actions that wait for its end.
    action_ids: Vec<String>,
    engine: Engine,
}

/// The engine's part in cancelling.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Engine {
    /// It has been told.
    Told,
    /// It has dropped the route beyond the edge of the robot.
    HasCancelled,
}

impl Vehicle {
    /// Begins to cancel the order.
    pub(super) fn cancel_order(&mut self, action: &Action) {
        let id = &action.action_id;
        if let Some(cancelling) = &mut self.cancelling {
            cancelling.action_ids.push(id.clone());
            return;
        }
        let order = self.order.as_ref().map(|held| held.last.order_id.clone());
        let wanted = action.text("orderId");
        if self.is_idle() || wanted.is_some_and(|wanted| order.as_deref() != Some(wanted)) {
            self.instants.find(id).into_iter().for_each(Job::fail);
            let fault = Fault::new(Cause::NothingToCancel, "there is no such order to cancel");
            self.report(fault.about("actionId", id));
            return;
        }
        self.jobs.cancel();
        self.progress.cut();
        self.order.iter_mut().for_each(|held| held.end = End::Cancelled);
        let engine = if self.progress.steps.is_empty() {
            Engine::HasCancelled
        } else {
            self.outbox.commands.push(Command::Cancel);
            Engine::Told
        };
        self.cancelling = Some(Cancelling { action_ids: vec![id.clone()], engine });
    }

    /// Takes that the engine has carried a cancel out.
    pub fn cancelled(&mut self) {
        if let Some(cancelling) = &mut self.cancelling {
            cancelling.engine = Engine::HasCancelled;
        }
    }

    /// Ends the cancelling when nothing moves any more.
    pub(super) fn end_cancelling(&mut self) {
        let Some(cancelling) = &self.cancelling else { return };
        let stands = self.is_standing()
            && self.seen.is_some_and(|seen| {
                seen.state == RobotState::Idle || self.progress.steps.is_empty()
            });
        if cancelling.engine == Engine::Told || !stands {
            return;
        }
        self.progress.clear();
        if !self.jobs.are_over() {
            return;
        }
        let ids = cancelling.action_ids.clone();
        self.cancelling = None;
        ids.iter().for_each(|id| self.end_instant(id, Ok(())));
    }
}
