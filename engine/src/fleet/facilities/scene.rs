//! The robots in doors and cabins, and what the facilities do about them.

use regatta_layout::{EdgeIndex, NodeIndex};
use regatta_plugin::event::EventKind;

use crate::fleet::Fleet;

/// The robots on edges of facilities and at their nodes.
#[derive(Clone, Debug, Default)]
pub(super) struct Occupants {
    /// The edges that robots are on, and not at the end of.
    on: Vec<EdgeIndex>,
    /// The nodes at which robots stand, with the robots.
    at: Vec<(NodeIndex, u32)>,
}

/// The fleet as facilities see it.
pub(super) struct Scene<'a> {
    pub fleet: &'a Fleet,
    pub occupants: &'a Occupants,
}

/// The changes that facilities make.
#[derive(Debug, Default)]
pub(super) struct Outcome {
    /// Edges, and whether robots may not enter them.
    pub gates: Vec<(EdgeIndex, bool)>,
    /// Events, with the id that they carry.
    pub events: Vec<(EventKind, u32)>,
}

impl Outcome {
    pub fn bar(&mut self, edges: &[EdgeIndex], is_barred: bool) {
        self.gates.extend(edges.iter().map(|edge| (*edge, is_barred)));
    }
}

impl Occupants {
    /// Finds the robots on edges that count, and at the nodes at their ends. `counts` is by edge.
    pub fn find(&mut self, fleet: &Fleet, counts: &[bool]) {
        self.on.clear();
        self.at.clear();
        for robot in 0..fleet.robots() as u32 {
            let row = robot as usize;
            let edge = fleet.columns.edge[row];
            // A robot on a node has no edge: there are few of them.
            if counts.get(edge as usize) == Some(&false) {
                continue;
            }
            match fleet.standing_at(robot) {
                Some(node) => self.at.push((node, robot)),
                None if (edge as usize) < counts.len() => self.on.push(EdgeIndex(edge)),
                None => {}
            }
        }
    }
}

impl Scene<'_> {
    /// Whether a robot is on one of some edges.
    pub fn is_any_on(&self, edges: &[EdgeIndex]) -> bool {
        self.occupants.on.iter().any(|edge| edges.contains(edge))
    }

    /// Whether a robot stands at one of some nodes.
    pub fn is_any_at(&self, nodes: &[NodeIndex]) -> bool {
        self.at(nodes).next().is_some()
    }

    /// Whether a robot stands at one of some nodes, nearer than its body reaches.
    pub fn is_any_within(&self, ends: &[(NodeIndex, f32)]) -> bool {
        self.occupants.at.iter().any(|(node, robot)| {
            let reach = self.fleet.reach(*robot);
            ends.iter().any(|(end, metres)| end == node && *metres < reach)
        })
    }

    /// Whether all robots that stand at some nodes drive on along some edges as soon as they may.
    pub fn all_go_on(&self, nodes: &[NodeIndex], edges: &[EdgeIndex]) -> bool {
        self.at(nodes).all(|robot| {
            let leg = self.fleet.wanted_leg(robot);
            leg.is_some_and(|leg| edges.contains(&leg.edge)) && !self.fleet.may_not_drive(robot)
        })
    }

    fn at(&self, nodes: &[NodeIndex]) -> impl Iterator<Item = u32> {
        let standing = self.occupants.at.iter();
        standing.filter(|(node, _)| nodes.contains(node)).map(|(_, robot)| *robot)
    }
}
