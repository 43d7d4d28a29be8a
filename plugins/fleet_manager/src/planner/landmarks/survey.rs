//! Works the driving times between nodes and landmarks out, a few trees of fastest ways at a time.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::panic::resume_unwind;

use super::{LANDMARKS, Landmarks};
use crate::roads::Roads;

/// The shortest unit of time, in seconds. Multiples of a power of two are exact.
const SHORTEST_UNIT: f32 = 1.0 / 32.0;
/// Stands for longer times, too, and for ways that don't exist.
const LONGEST: u16 = u16::MAX;

/// Driving times that are being worked out.
#[derive(Clone, Debug)]
pub struct Survey {
    landmarks: Vec<u32>,
    /// The ways away from nodes, and those towards them.
    ways: [Ways; 2],
    /// To each landmark, and from each, alternately.
    trees: Vec<Vec<u16>>,
    unit: f32,
}

impl Survey {
    /// Begins with roads on which each edge takes at least so many seconds beyond the driving time
    /// on empty roads.
    pub fn new(roads: &Roads, delay: &[f32]) -> Self {
        let unit = SHORTEST_UNIT;
        let ways = [Ways::new(roads, true), Ways::new(roads, false)];
        let mut survey = Self { landmarks: choose(roads), ways, trees: Vec::new(), unit };
        survey.begin(roads, delay);
        survey
    }

    /// Begins anew, with other delays.
    pub fn begin(&mut self, roads: &Roads, delay: &[f32]) {
        let fastest = roads.classes().iter().map(|class| class.max_speed).fold(0.0, f32::max);
        let secs = |edge: u32| {
            let road = roads.edge(edge);
            road.length / road.speeds[0].min(fastest) + delay[edge as usize]
        };
        let is_long =
            |tree: &Vec<u16>| tree.iter().any(|time| (LONGEST / 8 * 7..LONGEST).contains(time));
        if self.trees.iter().any(is_long) {
            self.unit *= 2.0;
        }
        self.trees.clear();
        let unit = self.unit;
        // Rounded down leg by leg, and not way by way: so the bound falls by no more than a leg's
        // time along it.
        self.ways.iter_mut().for_each(|ways| ways.weigh(|edge| (secs(edge) / unit) as u32));
    }

    /// Works so many more trees out, on some threads; returns whether there is none left.
    pub fn go_on(&mut self, trees: usize, threads: usize) -> bool {
        let (ways, landmarks) = (&self.ways, &self.landmarks);
        let numbers: Vec<usize> = (self.trees.len()..2 * landmarks.len()).take(trees).collect();
        let tree = |number: &usize| ways[number % 2].times(landmarks[number / 2]);
        if threads == 1 || numbers.len() < 2 {
            self.trees.extend(numbers.iter().map(tree));
        } else {
            self.trees.extend(std::thread::scope(|scope| {
                let parts = numbers.chunks(numbers.len().div_ceil(threads));
                let work: Vec<_> = parts
                    .map(|part| scope.spawn(move || part.iter().map(tree).collect::<Vec<_>>()))
                    .collect();
                let trees = work
                    .into_iter()
                    .flat_map(|thread| thread.join().unwrap_or_else(|panic| resume_unwind(panic)));
                trees.collect::<Vec<_>>()
            }));
        }
        self.trees.len() == 2 * self.landmarks.len()
    }

    /// The result, after the last tree.
    pub fn landmarks(&self) -> Landmarks {
        let mut times = vec![[[0; LANDMARKS]; 2]; self.ways[0].starts.len() - 1];
        for (number, tree) in self.trees.iter().enumerate() {
            times
                .iter_mut()
                .zip(tree)
                .for_each(|(times, &time)| times[number % 2][number / 2] = time);
        }
        Landmarks { times, unit: self.unit }
    }
}

/// Returns the landmarks: in each of as many sectors round the middle, the node that is farthest
/// out.
fn choose(roads: &Roads) -> Vec<u32> {
    let is_passed = |node: &u32| !roads.exits(*node).is_empty() && roads.arrival(*node).is_some();
    let bounds = [0, 1].map(|axis| {
        let at = (0..roads.nodes()).map(|node| roads.position(node)[axis]);
        at.fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], at| [low.min(at), high.max(at)])
    });
    let mut farthest = [(0.0, None); LANDMARKS];
    for node in (0..roads.nodes()).filter(is_passed) {
        // Plants that are much longer than wide have landmarks all round, too.
        let [x, y] = [0, 1].map(|axis| {
            let ([low, high], at) = (bounds[axis], roads.position(node)[axis]);
            (at - 0.5 * (low + high)) / (high - low).max(1.0)
        });
        let sector = (y.atan2(x) / core::f32::consts::TAU + 0.5) * LANDMARKS as f32;
        let best = &mut farthest[(sector as usize).min(LANDMARKS - 1)];
        if best.1.is_none() || x * x + y * y > best.0 {
            *best = (x * x + y * y, Some(node));
        }
    }
    farthest.into_iter().filter_map(|(_, node)| node).collect()
}

/// The ways between neighbours.
#[derive(Clone, Debug)]
struct Ways {
    /// Of node n: `ways[starts[n]..starts[n + 1]]`.
    starts: Vec<u32>,
    /// The neighbour, and the time in units.
    ways: Vec<(u32, u32)>,
    /// The edge of each way.
    edges: Vec<u32>,
}

impl Ways {
    /// The ways away from nodes, or those towards them, without times.
    fn new(roads: &Roads, towards: bool) -> Self {
        let edges = (0..).zip(roads.edges()).filter(|(_, edge)| edge.speeds[0] > 0.0);
        let mut ways: Vec<[u32; 3]> = edges
            .map(|(index, edge)| match towards {
                true => [edge.destination, index, edge.origin],
                false => [edge.origin, index, edge.destination],
            })
            .collect();
        ways.sort_unstable();
        Self {
            starts: (0..=roads.nodes())
                .map(|node| ways.partition_point(|way| way[0] < node) as u32)
                .collect(),
            ways: ways.iter().map(|way| (way[2], 0)).collect(),
            edges: ways.iter().map(|way| way[1]).collect(),
        }
    }

    fn weigh(&mut self, time: impl Fn(u32) -> u32) {
        self.ways.iter_mut().zip(&self.edges).for_each(|(way, &edge)| way.1 = time(edge));
    }

    /// Dijkstra's algorithm: the times of all nodes from one, or to it.
    fn times(&self, landmark: u32) -> Vec<u16> {
        let mut times = vec![LONGEST; self.starts.len() - 1];
        let mut open = BinaryHeap::from([(Reverse(0), landmark)]);
        times[landmark as usize] = 0;
        while let Some((Reverse(so_far), node)) = open.pop() {
            if so_far > times[node as usize] {
                continue;
            }
            let ways = self.starts[node as usize] as usize..self.starts[node as usize + 1] as usize;
            for &(next, time) in &self.ways[ways] {
                let total = u16::try_from(time).unwrap_or(LONGEST).saturating_add(so_far);
                if total < times[next as usize] {
                    times[next as usize] = total;
                    open.push((Reverse(total), next));
                }
            }
        }
        times
    }
}
