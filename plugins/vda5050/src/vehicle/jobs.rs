//! The actions of an order, by blocking type (2.x: 6.8; 3.0: 6.2.2).

use super::catalogue::{Ability, Effect};
use crate::message::{Action, ActionState, ActionStatus};

/// An action of an order.
#[derive(Clone, Debug)]
pub(super) struct Job {
    pub action: Action,
    pub ability: Ability,
    pub status: ActionStatus,
    pub place: Place,
    /// The place of its node or edge in the order.
    pub sequence_id: u32,
    pub phase: Phase,
    pub result: Option<String>,
}

/// A part of an order to which an action belongs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Place {
    Node,
    Edge,
}

/// Whether an action is due.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Phase {
    /// Its node or edge is ahead.
    Ahead,
    /// Its node is reached, or its edge entered. It has so many seconds left; `None` if something
    /// else ends it.
    Due { left: Option<f64> },
}

impl Job {
    pub(super) fn new(action: Action, ability: Ability, place: Place, sequence_id: u32) -> Self {
        let (status, phase) = (ActionStatus::Waiting, Phase::Ahead);
        Self { action, ability, status, place, sequence_id, phase, result: None }
    }

    /// Whether it is due and hasn't ended.
    fn is_open(&self) -> bool {
        matches!(self.phase, Phase::Due { .. }) && !self.status.is_over()
    }

    pub(super) fn end(&mut self, status: ActionStatus) {
        self.status = status;
    }

    pub(super) fn fail(&mut self) {
        self.end(ActionStatus::Failed);
    }

    /// The action, and what it does.
    pub(super) fn parts(&mut self) -> (Action, Effect) {
        (self.action.clone(), self.ability.effect)
    }

    pub(super) fn state(&self) -> ActionState {
        ActionState {
            action_id: self.action.action_id.clone(),
            action_type: Some(self.action.action_type.clone()),
            action_descriptor: self.action.action_descriptor.clone(),
            action_status: self.status,
            action_result: self.result.clone(),
        }
    }

    /// Begins it anew.
    fn begin(&mut self) {
        self.status = ActionStatus::Running;
        self.phase = Phase::Due { left: self.ability.seconds };
    }

    /// Lets time pass. Returns whether it has taken its time.
    fn pass(&mut self, seconds: f64) -> bool {
        let Phase::Due { left: Some(left) } = &mut self.phase else { return false };
        *left -= seconds;
        *left <= 0.0
    }
}

/// The actions of an order, in its order.
#[derive(Clone, Debug, Default)]
pub(super) struct Jobs {
    jobs: Vec<Job>,
}

impl Jobs {
    pub(super) fn clear(&mut self) {
        self.jobs.clear();
    }

    pub(super) fn push(&mut self, job: Job) {
        self.jobs.push(job);
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = &Job> {
        self.jobs.iter()
    }

    pub(super) fn find(&mut self, action_id: &str) -> Option<&mut Job> {
        self.jobs.iter_mut().find(|job| job.action.action_id == action_id)
    }

    /// Whether all have ended.
    pub(super) fn are_over(&self) -> bool {
        self.jobs.iter().all(|job| job.status.is_over())
    }

    /// Removes those of the horizon: their nodes and edges come after a place of the order.
    pub(super) fn forget_after(&mut self, sequence_id: u32) {
        self.jobs.retain(|job| job.sequence_id <= sequence_id);
    }

    /// Removes those that have ended.
    pub(super) fn forget_ended(&mut self) {
        self.jobs.retain(|job| !job.status.is_over());
    }

    /// Removes the oldest ones that have ended, beyond a number.
    pub(super) fn keep(&mut self, most: usize) {
        let mut excess = self.jobs.len().saturating_sub(most);
        self.jobs.retain(|job| {
            let goes = excess > 0 && job.status.is_over();
            excess -= usize::from(goes);
            !goes
        });
    }

    /// Ends those that pause the vehicle. Returns whether there were such.
    pub(super) fn end_pausing(&mut self) -> bool {
        let pausing = self.jobs.iter_mut().filter(|job| {
            job.ability.effect == Effect::Pauses && job.status == ActionStatus::Running
        });
        pausing.map(|job| job.end(ActionStatus::Finished)).count() > 0
    }

    /// Makes those of a node or an edge due.
    pub(super) fn trigger(&mut self, sequence_id: u32) {
        let ahead = self.jobs.iter_mut().filter(|job| job.sequence_id == sequence_id);
        for job in ahead.filter(|job| job.phase == Phase::Ahead && !job.status.is_over()) {
            job.phase = Phase::Due { left: job.ability.seconds };
        }
    }

    /// Ends those of an edge that is left: those that run are finished, others have failed.
    pub(super) fn leave_edge(&mut self, sequence_id: u32) {
        let of_edge = self.jobs.iter_mut().filter(|job| job.sequence_id == sequence_id);
        for job in of_edge.filter(|job| job.place == Place::Edge && job.is_open()) {
            job.end(match job.status {
                ActionStatus::Running | ActionStatus::Paused => ActionStatus::Finished,
                _ => ActionStatus::Failed,
            });
        }
    }

    /// Whether one that is due forbids to drive.
    pub(super) fn stop_driving(&self) -> bool {
        self.open().any(|job| job.action.blocking_type.stops_driving())
    }

    /// Whether one of a node or an edge forbids to drive.
    pub(super) fn will_stop_at(&self, sequence_id: u32) -> bool {
        let mut of_place = self.jobs.iter().filter(|job| job.sequence_id == sequence_id);
        of_place.any(|job| !job.status.is_over() && job.action.blocking_type.stops_driving())
    }

    fn open(&self) -> impl Iterator<Item = &Job> {
        self.jobs.iter().filter(|job| job.is_open())
    }

    /// Begins those that may run beside those before them. Returns whether there are such.
    pub(super) fn begin_possible(&mut self) -> bool {
        let (mut others, mut alone, mut begun) = (false, false, false);
        for job in self.jobs.iter_mut().filter(|job| job.is_open()) {
            let is_alone = job.action.blocking_type.is_alone();
            let may_run = !(alone || is_alone && others);
            if may_run && job.status == ActionStatus::Waiting {
                job.begin();
                begun = true;
            }
            (others, alone) = (true, alone || is_alone);
        }
        begun
    }

    /// Lets time pass for those that run. Returns the ids of those that have taken theirs.
    pub(super) fn pass(&mut self, seconds: f64) -> Vec<String> {
        let running = self.jobs.iter_mut().filter(|job| {
            matches!(job.phase, Phase::Due { .. }) && job.status == ActionStatus::Running
        });
        let ended = running.filter_map(|job| job.pass(seconds).then_some(&job.action.action_id));
        ended.cloned().collect()
    }

    /// Pauses those that run, or lets them go on.
    pub(super) fn pause(&mut self, paused: Paused) {
        let (from, to) = match paused {
            Paused::Yes => (ActionStatus::Running, ActionStatus::Paused),
            Paused::Ending | Paused::No => (ActionStatus::Paused, ActionStatus::Running),
        };
        self.jobs.iter_mut().filter(|job| job.status == from).for_each(|job| job.status = to);
    }

    /// Ends all: those that can't be cancelled any more go on.
    pub(super) fn cancel(&mut self) {
        for job in self.jobs.iter_mut().filter(|job| !job.status.is_over()) {
            let is_running = matches!(job.status, ActionStatus::Running | ActionStatus::Paused);
            if !is_running || job.ability.can_be_cancelled() {
                job.end(ActionStatus::Failed);
            }
        }
    }

    /// Ends all.
    pub(super) fn fail_all(&mut self) {
        for job in self.jobs.iter_mut().filter(|job| !job.status.is_over()) {
            job.end(ActionStatus::Failed);
        }
    }

    /// Ends the waiting for a trigger. Returns whether one waited.
    pub(super) fn release_waiting(&mut self) -> bool {
        let waiting = self.jobs.iter_mut().filter(|job| {
            job.ability.effect == Effect::Waits && job.status == ActionStatus::Running
        });
        waiting.map(|job| job.end(ActionStatus::Finished)).count() > 0
    }

    /// Tries a failed one again. Returns whether that was possible.
    pub(super) fn retry(&mut self, action_id: &str) -> bool {
        let failed = self.find(action_id).filter(|job| job.status == ActionStatus::Retriable);
        failed.map(Job::begin).is_some()
    }

    /// Lets a failed one fail. Returns whether that was possible.
    pub(super) fn give_up(&mut self, action_id: &str) -> bool {
        let failed = self.find(action_id).filter(|job| job.status == ActionStatus::Retriable);
        failed.map(|job| job.end(ActionStatus::Failed)).is_some()
    }
}

/// Whether a vehicle is paused.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Paused {
    Yes,
    /// Its pause has ended, and the robot may be held for a moment still.
    Ending,
    #[default]
    No,
}
