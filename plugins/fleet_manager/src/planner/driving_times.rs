//! Driving times between nodes on empty roads.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};

use regatta_base::components::strong_components;
use regatta_base::rows::Rows;

use crate::roads::{Leg, Roads};

/// The largest number of times that are kept: 64 MB. Times to further goals are estimated.
const MOST_NUMBERS: usize = 16_000_000;
/// The number of times after which no further goal is prepared until the next call of
/// [`DrivingTimes::begin`].
const NUMBERS_AT_ONCE: usize = 60_000;

/// Driving times to some goals, which are computed on demand.
#[derive(Debug)]
pub struct DrivingTimes {
    /// By node: the legs that lead to it.
    arrivals: Rows<Arrival>,
    /// By goal: milliseconds from each node; `u32::MAX` from where it can't be reached.
    trees: BTreeMap<u32, Vec<u32>>,
    /// The number of times computed since the last [`begin`](Self::begin).
    spent: usize,
    reach: Reach,
}

/// The nodes from which others can be reached.
#[derive(Debug)]
struct Reach {
    /// By node: a node of the part of the roads in which all nodes can be reached from each other.
    parts: Vec<u32>,
    /// By part: whether it can be reached from each node; of the parts that were asked for.
    sources: BTreeMap<u32, Vec<bool>>,
}

impl Reach {
    fn new(arrivals: &Rows<Arrival>) -> Self {
        let starts = (0..arrivals.len() as u32)
            .flat_map(|node| arrivals.row(node).iter().map(move |leg| (node, leg.start)));
        // The components are the same in both directions.
        let parts = strong_components(&Rows::of_sorted(arrivals.len(), starts));
        Self { parts, sources: BTreeMap::new() }
    }

    fn contains(&mut self, arrivals: &Rows<Arrival>, node: u32, goal: u32) -> bool {
        let part = self.parts[goal as usize];
        if self.parts[node as usize] == part {
            return true;
        }
        self.sources.entry(part).or_insert_with(|| sources(arrivals, part))[node as usize]
    }
}

/// Returns by node whether a goal can be reached from it.
fn sources(arrivals: &Rows<Arrival>, goal: u32) -> Vec<bool> {
    let (mut is_source, mut open) = (vec![false; arrivals.len()], vec![goal]);
    is_source[goal as usize] = true;
    while let Some(node) = open.pop() {
        for leg in arrivals.row(node) {
            if !std::mem::replace(&mut is_source[leg.start as usize], true) {
                open.push(leg.start);
            }
        }
    }
    is_source
}

/// A leg that leads to a node.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Arrival {
    /// The node that it leaves.
    start: u32,
    /// Its driving time, in milliseconds.
    millis: u32,
}

impl DrivingTimes {
    /// Makes the driving times of roads.
    pub fn new(roads: &Roads) -> Self {
        let mut legs: Vec<(u32, Leg)> = (0..roads.nodes())
            .flat_map(|node| roads.exits(node))
            .map(|&leg| (roads.end(leg), leg))
            .collect();
        legs.sort_unstable();
        let arrivals = legs.into_iter().map(|(end, leg)| {
            let secs = roads.edge(leg.edge()).length / roads.allowed_speed(leg);
            (end, Arrival { start: roads.start(leg), millis: (1000.0 * secs) as u32 + 1 })
        });
        let arrivals = Rows::of_sorted(roads.nodes() as usize, arrivals);
        let reach = Reach::new(&arrivals);
        Self { arrivals, trees: BTreeMap::new(), spent: 0, reach }
    }

    /// Whether a way leads from a node to another one, closed roads included.
    pub fn can_reach(&mut self, node: u32, goal: u32) -> bool {
        self.reach.contains(&self.arrivals, node, goal)
    }

    /// Begins another cycle, in which some more driving times may be computed.
    pub fn begin(&mut self) {
        self.spent = 0;
    }

    /// Computes the driving times to a goal, unless they are known, or it would take too much time
    /// or memory now.
    pub fn prepare(&mut self, roads: &Roads, goal: u32) {
        let is_late = self.spent > NUMBERS_AT_ONCE
            || (self.trees.len() + 1) * roads.nodes() as usize > MOST_NUMBERS;
        if is_late || self.trees.contains_key(&goal) {
            return;
        }
        self.spent += roads.nodes() as usize;
        let tree = self.tree(goal);
        self.trees.insert(goal, tree);
    }

    /// Returns the driving time between two nodes, in seconds; `None` if the goal can't be reached.
    /// Unless it was [prepared](Self::prepare), it is an estimate from the distance.
    pub fn between(&self, roads: &Roads, node: u32, goal: u32) -> Option<f64> {
        let Some(tree) = self.trees.get(&goal) else {
            let offset = roads.position(node) - roads.position(goal);
            // Streets are longer than the distance, and robots slower than 1 m/s on part of them.
            return Some(1.5 * f64::from(offset.x.hypot(offset.y)));
        };
        let millis = tree[node as usize];
        (millis != u32::MAX).then(|| f64::from(millis) / 1000.0)
    }

    /// Returns the driving times from all nodes to a goal, in milliseconds.
    fn tree(&self, goal: u32) -> Vec<u32> {
        let mut millis = vec![u32::MAX; self.arrivals.len()];
        lower_costs(&mut millis, [(goal, 0)], |node, so_far| {
            let arrivals = self.arrivals.row(node).iter();
            arrivals.map(move |leg| (leg.start, so_far.saturating_add(leg.millis)))
        });
        millis
    }
}

/// Lowers the costs of nodes to those of the cheapest ways from some starts with given costs, by
/// Dijkstra's algorithm. `ways` returns for a node and the cost to it the nodes to which a way
/// leads from there, each with the total cost.
pub(super) fn lower_costs<C: Copy + Ord, W: Iterator<Item = (u32, C)>>(
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
