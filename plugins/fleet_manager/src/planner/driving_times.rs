//! Driving times between nodes on empty roads, for whoever compares robots.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};

use crate::roads::{Leg, Roads};

/// The most numbers that are kept: 64 MB. Times to further goals are estimated.
const MOST_NUMBERS: usize = 16_000_000;
/// The most numbers that are worked out between two calls of [`DrivingTimes::begin`], but for those
/// of one goal.
const NUMBERS_AT_ONCE: usize = 60_000;

/// Driving times to some goals, worked out when they are asked for.
#[derive(Debug, Default)]
pub struct DrivingTimes {
    /// Legs by the node that they lead to: `arrivals[starts[n]..starts[n + 1]]`. Of each, the node
    /// that it leaves, and its driving time in milliseconds.
    arrivals: Vec<(u32, u32)>,
    starts: Vec<u32>,
    /// By goal: milliseconds from each node; `u32::MAX` from where it can't be reached.
    trees: BTreeMap<u32, Vec<u32>>,
    /// Numbers worked out since the last [`begin`](Self::begin).
    spent: usize,
}

impl DrivingTimes {
    /// Makes the driving times of roads.
    pub fn new(roads: &Roads) -> Self {
        let mut legs: Vec<(u32, Leg)> = (0..roads.nodes())
            .flat_map(|node| roads.exits(node))
            .map(|&leg| (roads.end(leg), leg))
            .collect();
        legs.sort_unstable();
        let starts = (0..=roads.nodes())
            .map(|node| legs.partition_point(|(end, _)| *end < node) as u32)
            .collect();
        let arrival = |(_, leg): (u32, Leg)| {
            let edge = roads.edge(leg.edge());
            let secs = edge.length / edge.speeds[usize::from(leg.is_reverse())];
            (roads.start(leg), (1000.0 * secs) as u32 + 1)
        };
        Self { arrivals: legs.into_iter().map(arrival).collect(), starts, ..Self::default() }
    }

    /// Begins another cycle, in which some more driving times may be worked out.
    pub fn begin(&mut self) {
        self.spent = 0;
    }

    /// Works the driving times to a goal out, unless they are known, or it would take too much time
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
            let ([x, y], [u, v]) = (roads.position(node), roads.position(goal));
            // Streets are longer than the distance, and robots slower than 1 m/s on part of them.
            return Some(1.5 * f64::from((x - u).hypot(y - v)));
        };
        let millis = tree[node as usize];
        (millis != u32::MAX).then(|| f64::from(millis) / 1000.0)
    }

    /// Dijkstra's algorithm, against the direction of travel.
    fn tree(&self, goal: u32) -> Vec<u32> {
        let mut millis = vec![u32::MAX; self.starts.len() - 1];
        let mut open = BinaryHeap::from([(Reverse(0), goal)]);
        millis[goal as usize] = 0;
        while let Some((Reverse(so_far), node)) = open.pop() {
            if so_far > millis[node as usize] {
                continue;
            }
            let arrivals =
                self.starts[node as usize] as usize..self.starts[node as usize + 1] as usize;
            for &(start, time) in &self.arrivals[arrivals] {
                let total = so_far.saturating_add(time);
                if total < millis[start as usize] {
                    millis[start as usize] = total;
                    open.push((Reverse(total), start));
                }
            }
        }
        millis
    }
}
