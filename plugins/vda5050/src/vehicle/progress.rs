//! The way of a vehicle along its order: steps ahead, and how many of them the engine may drive.

use std::collections::VecDeque;

use regatta_base::graph::Leg;

use super::jobs::Jobs;
use crate::message::{Edge, Node};

/// An edge of an order and the node where it ends.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Step {
    pub edge: Edge,
    pub node: Node,
    /// The edge of the layout; `None` if both of its ends are the same place.
    pub leg: Option<Leg>,
    /// The index of the node in the map.
    pub place: u32,
}

/// The steps that are still ahead of a vehicle.
#[derive(Clone, Debug, Default)]
pub(super) struct Progress {
    pub steps: VecDeque<Step>,
    /// The number of steps that the engine was told to drive.
    pub granted: usize,
    /// Whether the first edge has been entered: its actions are due.
    entered: Entered,
    /// The last node that was reached, by the id that the order has for it.
    pub last_node_id: String,
    pub last_sequence_id: u32,
    /// The last node of the base: the decision point.
    pub base_end: (String, u32),
    /// The index of that node.
    pub end_place: u32,
}

/// Whether an edge has been entered.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Entered {
    Yes,
    #[default]
    No,
}

impl Progress {
    /// Begins at the first node of an order, which counts as reached.
    pub(super) fn begin(&mut self, first: &Node, place: Option<u32>) {
        self.clear();
        self.reach(first);
        self.end_place = place.unwrap_or(self.end_place);
        self.base_end = (first.node_id.clone(), first.sequence_id);
    }

    fn reach(&mut self, node: &Node) {
        self.last_node_id.clone_from(&node.node_id);
        self.last_sequence_id = node.sequence_id;
    }

    /// Adds steps, in the place of the horizon.
    pub(super) fn append(&mut self, steps: Vec<Step>) {
        self.steps.retain(|step| step.node.released);
        self.steps.extend(steps);
        let base = self.steps.iter().rev().find(|step| step.node.released);
        if let Some(Step { node, place, .. }) = base {
            self.base_end = (node.node_id.clone(), node.sequence_id);
            self.end_place = *place;
        }
    }

    /// The number of steps of the base.
    pub(super) fn released(&self) -> usize {
        self.steps.iter().take_while(|step| step.node.released).count()
    }

    /// Enters the first edge if nothing holds the vehicle, which makes its actions due.
    fn enter(&mut self, jobs: &mut Jobs) {
        let Some(step) = self.steps.front().filter(|step| step.node.released) else { return };
        if self.entered == Entered::No && !jobs.stop_driving() {
            self.entered = Entered::Yes;
            jobs.trigger(step.edge.sequence_id);
        }
    }

    /// Returns the number of steps that the vehicle may drive: up to the end of its base, or to a
    /// node where it has to stop for an action.
    pub(super) fn reachable(&mut self, jobs: &mut Jobs) -> usize {
        self.enter(jobs);
        if self.entered == Entered::No || jobs.stop_driving() {
            return 0;
        }
        let mut count = 0;
        for step in self.steps.iter().take_while(|step| step.node.released) {
            if count > 0 && jobs.will_stop_at(step.edge.sequence_id) {
                break;
            }
            count += 1;
            if jobs.will_stop_at(step.node.sequence_id) {
                break;
            }
        }
        count
    }

    /// Takes the first step as done. Returns its node's index.
    pub(super) fn traverse(&mut self, jobs: &mut Jobs) -> Option<u32> {
        let step = self.steps.pop_front()?;
        self.granted = self.granted.saturating_sub(1);
        self.entered = Entered::No;
        jobs.leave_edge(step.edge.sequence_id);
        jobs.trigger(step.node.sequence_id);
        self.reach(&step.node);
        Some(step.place)
    }

    /// Drops all steps but the one that is being driven.
    pub(super) fn cut(&mut self) {
        self.steps.truncate(self.granted.min(1));
        self.granted = self.steps.len();
    }

    pub(super) fn clear(&mut self) {
        self.steps.clear();
        (self.granted, self.entered) = (0, Entered::No);
    }
}
