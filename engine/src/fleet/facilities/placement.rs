//! New robots: neither in a closed door, nor in a shaft without its cabin.

use regatta_layout::{EdgeIndex, NodeIndex};
use regatta_plugin::event::Refusal;
use regatta_plugin::frame::RobotState;

use super::cabin::LiftEdge;
use crate::fleet::{Fleet, Placement};

impl Fleet {
    /// Checks that a new robot is neither in a closed door nor in a shaft without a cabin. Before
    /// the first tick, doors and cabins are where robots need them.
    pub(in crate::fleet) fn check_facilities(&self, placement: Placement) -> Result<(), Refusal> {
        let Some(facilities) = &self.facilities else { return Ok(()) };
        let has_begun = facilities.tick.is_some();
        match self.place_of(placement) {
            Place::Node(node) => {
                let Some((lift, level)) = facilities.stop_of.get(&node) else { return Ok(()) };
                let cabin = &facilities.cabins[*lift];
                let comes = !has_begun && self.is_empty_lift(*lift);
                (cabin.is_at(*level) || comes).then_some(()).ok_or(Refusal::NoCabin)
            }
            Place::Edge(edge) => {
                let doors = facilities.doors_of.get(&edge).into_iter().flatten();
                let are_open = |door: &usize| facilities.doors[*door].is_open();
                if has_begun && !doors.clone().all(are_open) {
                    return Err(Refusal::EdgeClosed);
                }
                match facilities.lift_of.get(&edge) {
                    None => Ok(()),
                    Some((_, LiftEdge::Ride)) => Err(Refusal::NoCabin),
                    Some((lift, LiftEdge::Doorway(level))) => {
                        let is_open = facilities.cabins[*lift].is_open_at(*level);
                        let comes = !has_begun
                            && (self.is_empty_lift(*lift)
                                || facilities.cabins[*lift].is_at(*level));
                        (is_open || comes).then_some(()).ok_or(Refusal::NoCabin)
                    }
                }
            }
        }
    }

    /// Before the first tick: opens the doors in which a new robot is, and brings it the cabin.
    pub(in crate::fleet) fn settle_facilities(&mut self, placement: Placement) {
        let place = self.place_of(placement);
        let Some(facilities) = &mut self.facilities else { return };
        if facilities.tick.is_some() {
            return;
        }
        match place {
            Place::Node(node) => {
                if let Some((lift, level)) = facilities.stop_of.get(&node) {
                    facilities.cabins[*lift].set_level(*level);
                }
            }
            Place::Edge(edge) => {
                for door in facilities.doors_of.get(&edge).into_iter().flatten() {
                    facilities.doors[*door].set_open(&mut facilities.outcome);
                }
                if let Some((lift, LiftEdge::Doorway(level))) = facilities.lift_of.get(&edge) {
                    facilities.cabins[*lift].set_level(*level);
                    facilities.cabins[*lift].set_open(&mut facilities.outcome);
                }
            }
        }
        facilities.note_states();
        for (edge, is_barred) in facilities.outcome.gates.drain(..) {
            self.motion.legs.bar(edge, is_barred);
        }
    }

    /// Whether no robot is in a cabin or its doorways.
    fn is_empty_lift(&self, lift: usize) -> bool {
        let Some(facilities) = &self.facilities else { return true };
        (0..self.robots()).all(|row| {
            if self.is(row, RobotState::Absent) {
                return true;
            }
            match self.standing_at(row as u32) {
                Some(node) => facilities.stop_of.get(&node).is_none_or(|(of, _)| *of != lift),
                None => {
                    let edge = EdgeIndex(self.columns.edge[row]);
                    facilities.lift_of.get(&edge).is_none_or(|(of, _)| *of != lift)
                }
            }
        })
    }

    fn place_of(&self, placement: Placement) -> Place {
        match placement {
            Placement::Node(node) => Place::Node(node),
            Placement::Edge(edge, s) => {
                let length = self.motion.legs.tracks().edge_length(edge) as f32;
                let destination = self.graph.edge(edge).destination;
                if s >= length { Place::Node(destination) } else { Place::Edge(edge) }
            }
        }
    }
}

/// The place of a new robot.
enum Place {
    Node(NodeIndex),
    /// Within the edge.
    Edge(EdgeIndex),
}
