//! The model by brute force: all states of robots at nodes, and the moves between them. Of the code
//! under test it takes nothing but the table of conflicts.

use regatta_base::graph::{Gear, Leg};

use crate::EdgeIndex;
use crate::model::route_graph::RouteGraph;
use crate::traffic::conflicts::{Conflicts, Sweeps};
use crate::traffic::network::Network;
use crate::traffic::robot::RobotType;

/// A move of a robot.
#[derive(Clone, Copy, Debug)]
pub struct Move {
    pub from: usize,
    pub to: usize,
    /// The nodes where a standing robot forbids it, as bits.
    pub blockers: u32,
}

/// All moves of a layout of at most 32 nodes. A set of nodes is a number of bits.
#[derive(Debug)]
pub struct Model {
    pub nodes: usize,
    pub moves: Vec<Move>,
    /// By node: the nodes where no robot can stand at the same time, as bits.
    pub touching: Vec<u32>,
}

impl Model {
    pub fn new(graph: &RouteGraph, robot: &RobotType) -> Self {
        let network = Network::new(graph);
        let conflicts = Conflicts::new(&network, &Sweeps::new(graph), robot);
        let nodes = graph.nodes().len();
        let mut moves = Vec::new();
        for (index, edge) in (0..).zip(graph.edges()) {
            let gears = [Some(Gear::Forward), edge.reverse_speed.map(|_| Gear::Reverse)];
            for gear in gears.into_iter().flatten() {
                let leg = Leg { edge: EdgeIndex(index), gear };
                let blocks = (0..nodes as u32).filter(|&node| conflicts.is_blocked(leg, node));
                moves.push(Move {
                    from: graph.leg_start(leg).0 as usize,
                    to: graph.leg_end(leg).0 as usize,
                    blockers: bits(blocks.map(|node| node as usize)),
                });
            }
        }
        let touching = (0..nodes as u32).map(|node| {
            let others = (0..nodes as u32).filter(|&other| conflicts.is_touching(node, other));
            bits(others.map(|other| other as usize))
        });
        Self { nodes, moves, touching: touching.collect() }
    }

    /// All sets of nodes where robots can stand at once.
    pub fn placements(&self) -> impl Iterator<Item = u32> + '_ {
        (0..1 << self.nodes).filter(|set| members(*set).all(|node| self.touching[node] & set == 0))
    }

    /// The moves that a robot at a node can make while others stand on a set of nodes.
    pub fn free(&self, node: usize, others: u32) -> impl Iterator<Item = Move> + '_ {
        let others = others & !(1 << node);
        let from = self.moves.iter().filter(move |step| step.from == node);
        from.filter(move |step| step.blockers & others == 0 && others >> step.to & 1 == 0).copied()
    }

    /// Whether each robot of a placement may want a move that another one forbids.
    pub fn may_all_wait(&self, placement: u32) -> bool {
        members(placement).all(|node| self.may_wait(node, placement))
    }

    /// Whether each robot of a placement may want a move that another one forbids, or has no move
    /// at all.
    pub fn may_be_stuck(&self, placement: u32) -> bool {
        members(placement).all(|node| {
            self.may_wait(node, placement) || self.moves.iter().all(|step| step.from != node)
        })
    }

    fn may_wait(&self, node: usize, placement: u32) -> bool {
        let others = placement & !(1 << node);
        let mut wishes = self.moves.iter().filter(|step| step.from == node);
        wishes.any(|step| step.blockers & others != 0)
    }

    /// By node: the nodes that one robot alone can reach, as bits; itself among them.
    pub fn reach(&self) -> Vec<u32> {
        self.reach_past(0, u32::MAX)
    }

    /// The same past robots that stand on a set of nodes, and only within a set of nodes.
    pub fn reach_past(&self, standing: u32, within: u32) -> Vec<u32> {
        let mut reach: Vec<u32> = (0..self.nodes).map(|node| 1 << node).collect();
        loop {
            let before = reach.clone();
            for step in &self.moves {
                let is_inside = within >> step.from & 1 == 1 && within >> step.to & 1 == 1;
                if is_inside && step.blockers & standing == 0 {
                    for set in reach.iter_mut().filter(|set| **set >> step.from & 1 == 1) {
                        *set |= 1 << step.to;
                    }
                }
            }
            if reach == before {
                return reach;
            }
        }
    }

    /// Whether two robots that stay on a set of nodes can exchange their places, from any two of
    /// them: by the closure of the relation between all states.
    pub fn can_exchange(&self, within: u32) -> bool {
        let mut states: Vec<(usize, usize)> = Vec::new();
        for a in members(within) {
            let others = members(within).filter(|&b| a != b && self.touching[a] >> b & 1 == 0);
            states.extend(others.map(|b| (a, b)));
        }
        let mut leads = vec![vec![false; states.len()]; states.len()];
        for (from, &(a, b)) in states.iter().enumerate() {
            for (to, &next) in states.iter().enumerate() {
                leads[from][to] = (b == next.1 && self.moves_to(a, 1 << b, next.0))
                    || (a == next.0 && self.moves_to(b, 1 << a, next.1));
            }
        }
        for middle in 0..states.len() {
            let onwards = leads[middle].clone();
            for row in leads.iter_mut().filter(|row| row[middle]) {
                for (lead, on) in row.iter_mut().zip(&onwards) {
                    *lead |= on;
                }
            }
        }
        states.iter().enumerate().any(|(from, &(a, b))| {
            states.iter().position(|&other| other == (b, a)).is_some_and(|to| leads[from][to])
        })
    }

    fn moves_to(&self, node: usize, others: u32, to: usize) -> bool {
        self.free(node, others).any(|step| step.to == to && step.from != to)
    }
}

/// Returns a set of nodes.
pub fn bits(nodes: impl IntoIterator<Item = usize>) -> u32 {
    nodes.into_iter().fold(0, |set, node| set | 1 << node)
}

/// The nodes of a set, in ascending order.
pub fn members(set: u32) -> impl Iterator<Item = usize> + Clone {
    (0..32).filter(move |node| set >> node & 1 == 1)
}
