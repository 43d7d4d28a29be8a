//! Driving times between nodes on empty roads, each computed once for all who ask.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::sync::OnceLock;

use regatta_base::components::strong_components;
use regatta_base::rows::Rows;

use super::{Leg, Roads};

/// The driving times of roads.
#[derive(Debug)]
pub(super) struct DrivingTimes {
    /// By node: the legs that lead to it.
    arrivals: Rows<Arrival>,
    /// By goal: milliseconds from each node; `u32::MAX` from where it can't be reached.
    trees: Box<[OnceLock<Box<[u32]>>]>,
    /// The same without reverse gear.
    forward_trees: Box<[OnceLock<Box<[u32]>>]>,
    /// By node: a node of the part of the roads in which all nodes can be reached from each other.
    parts: Vec<u32>,
    /// By such a node: whether its part can be reached from each node.
    sources: Box<[OnceLock<Box<[bool]>>]>,
}

/// A leg that leads to a node.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Arrival {
    /// The node that it leaves.
    start: u32,
    /// Its driving time, in milliseconds.
    millis: u32,
    is_reverse: bool,
}

impl Roads {
    /// Returns the driving times from all nodes to a goal on empty roads, in milliseconds;
    /// `u32::MAX` from where it can't be reached.
    pub fn millis_to(&self, goal: u32) -> &[u32] {
        let times = self.driving_times();
        times.trees[goal as usize].get_or_init(|| times.tree(goal, |_| true))
    }

    /// The same without reverse gear.
    pub fn forward_millis_to(&self, goal: u32) -> &[u32] {
        let times = self.driving_times();
        times.forward_trees[goal as usize].get_or_init(|| times.tree(goal, |leg| !leg.is_reverse))
    }

    /// Returns a node of the part of the roads around a node in which all nodes can be reached from
    /// each other; the same one for all nodes of the part.
    pub fn part_of(&self, node: u32) -> u32 {
        self.driving_times().parts[node as usize]
    }

    /// Whether a way leads from a node to another one, closed roads included.
    pub fn can_reach(&self, node: u32, goal: u32) -> bool {
        let times = self.driving_times();
        let part = self.part_of(goal);
        if self.part_of(node) == part {
            return true;
        }
        times.sources[part as usize].get_or_init(|| times.sources(part))[node as usize]
    }

    fn driving_times(&self) -> &DrivingTimes {
        self.driving_times.get_or_init(|| DrivingTimes::new(self))
    }
}

impl DrivingTimes {
    fn new(roads: &Roads) -> Self {
        let mut legs: Vec<(u32, Leg)> = (0..roads.nodes())
            .flat_map(|node| roads.exits(node))
            .map(|&leg| (roads.end(leg), leg))
            .collect();
        legs.sort_unstable();
        let arrivals = legs.into_iter().map(|(end, leg)| {
            let road = roads.edge(leg.edge());
            let secs = road.length / roads.allowed_speed(leg) + road.delay_secs;
            let millis = (1000.0 * secs) as u32 + 1;
            (end, Arrival { start: roads.start(leg), millis, is_reverse: leg.is_reverse() })
        });
        let arrivals = Rows::of_sorted(roads.nodes() as usize, arrivals);
        let starts = (0..arrivals.len() as u32)
            .flat_map(|node| arrivals.row(node).iter().map(move |leg| (node, leg.start)));
        // The components are the same in both directions.
        let parts = strong_components(&Rows::of_sorted(arrivals.len(), starts));
        let trees = (0..arrivals.len()).map(|_| OnceLock::new()).collect();
        let forward_trees = (0..arrivals.len()).map(|_| OnceLock::new()).collect();
        let sources = (0..arrivals.len()).map(|_| OnceLock::new()).collect();
        Self { arrivals, trees, forward_trees, parts, sources }
    }

    /// Returns the driving times from all nodes to a goal along some legs, in milliseconds.
    fn tree(&self, goal: u32, takes: impl Fn(&Arrival) -> bool) -> Box<[u32]> {
        let mut millis = vec![u32::MAX; self.arrivals.len()];
        lower_costs(&mut millis, [(goal, 0)], |node, so_far| {
            let arrivals = self.arrivals.row(node).iter().filter(|leg| takes(leg));
            arrivals.map(move |leg| (leg.start, so_far.saturating_add(leg.millis)))
        });
        millis.into_boxed_slice()
    }

    /// Returns by node whether a goal can be reached from it.
    fn sources(&self, goal: u32) -> Box<[bool]> {
        let (mut is_source, mut open) = (vec![false; self.arrivals.len()], vec![goal]);
        is_source[goal as usize] = true;
        while let Some(node) = open.pop() {
            for leg in self.arrivals.row(node) {
                if !std::mem::replace(&mut is_source[leg.start as usize], true) {
                    open.push(leg.start);
                }
            }
        }
        is_source.into_boxed_slice()
    }
}

/// Lowers the costs of nodes to those of the cheapest ways from some starts with given costs, by
/// Dijkstra's algorithm. `ways` returns for a node and the cost to it the nodes to which a way
/// leads from there, each with the total cost.
pub fn lower_costs<C: Copy + Ord, W: Iterator<Item = (u32, C)>>(
    costs: &mut [C],
    starts: impl IntoIterator<Item = (u32, C)>,
    ways: impl Fn(u32, C) -> W,
) {
    let mut open = BinaryHeap::new();
    for (start, cost) in starts {
        costs[start as usize] = cost;
        open.push((Reverse(cost), start));
    }
    while let Some((Reverse(so_far), node)) = open.pop() {
        if so_far > costs[node as usize] {
            continue;
        }
        for (next, total) in ways(node, so_far) {
            if total < costs[next as usize] {
                costs[next as usize] = total;
                open.push((Reverse(total), next));
            }
        }
    }
}
