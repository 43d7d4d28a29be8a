//! Rest places: nodes where robots may stand for any time, all at once, without cutting any part of
//! the roads off.

use std::cmp::Reverse;

use super::blocks::Blocks;
use crate::roads::{Leg, Roads, lower_costs};

/// The largest number of steps that the search for rest places takes: a leg looked at is one.
const MOST_STEPS: usize = 300_000_000;
/// The number of nodes from which the traffic on roads is sampled.
const SAMPLES: u32 = 64;

/// The rest places of some roads.
#[derive(Debug)]
pub struct Rests {
    /// By node.
    is_rest: Vec<bool>,
    count: usize,
}

impl Rests {
    /// Finds rest places in each part of the roads: dead ends first, then nodes with little
    /// traffic. A node becomes one if, with robots on all rest places, every other node of its part
    /// can still be reached from every other one, and each rest place from there and back.
    pub fn new(roads: &Roads, blocks: &mut Blocks) -> Self {
        let mut search = Search::new(roads, blocks);
        let mut steps = 0;
        for part in search.parts() {
            search.rests.clear();
            search.core = part;
            for node in candidates(roads, &search.core) {
                if steps > MOST_STEPS {
                    break;
                }
                steps += 3 * roads.edges().len();
                search.try_node(node);
            }
        }
        let count = search.is_rest.iter().filter(|is_rest| **is_rest).count();
        Self { is_rest: search.is_rest, count }
    }

    /// Whether a node is a rest place.
    pub fn contains(&self, node: u32) -> bool {
        self.is_rest[node as usize]
    }

    /// Number of rest places.
    pub fn len(&self) -> usize {
        self.count
    }
}

/// Returns the nodes of a part in the order in which they are tried.
fn candidates(roads: &Roads, core: &[bool]) -> Vec<u32> {
    let traffic = traffic(roads, core);
    let mut candidates: Vec<u32> = (0..roads.nodes()).filter(|&node| core[node as usize]).collect();
    candidates.sort_by_key(|&node| {
        let mut neighbours: Vec<u32> =
            roads.exits(node).iter().map(|&leg| roads.end(leg)).collect();
        neighbours.sort_unstable();
        neighbours.dedup();
        (neighbours.len() > 1, traffic[node as usize])
    });
    candidates
}

/// Returns for each node how many of the fastest ways from some nodes to all others lead over it.
fn traffic(roads: &Roads, core: &[bool]) -> Vec<u32> {
    let mut counts = vec![0; roads.nodes() as usize];
    let step = (roads.nodes() / SAMPLES).max(1);
    for start in (0..roads.nodes()).step_by(step as usize).filter(|&node| core[node as usize]) {
        let mut millis = vec![u32::MAX; roads.nodes() as usize];
        let exits = |node: u32| roads.exits(node).iter().copied();
        lower_costs(&mut millis, [(start, 0)], |node, so_far| {
            exits(node).map(move |leg| (roads.end(leg), so_far + leg_millis(roads, leg)))
        });
        // From the farthest node to the nearest one: each adds its ways to the node before it.
        let mut order: Vec<u32> =
            (0..roads.nodes()).filter(|&node| millis[node as usize] != u32::MAX).collect();
        order.sort_by_key(|&node| Reverse((millis[node as usize], node)));
        let mut before = vec![start; roads.nodes() as usize];
        for &node in &order {
            for leg in exits(node) {
                let end = roads.end(leg);
                if millis[node as usize] + leg_millis(roads, leg) == millis[end as usize] {
                    before[end as usize] = node;
                }
            }
        }
        let mut ways = vec![1_u32; roads.nodes() as usize];
        for node in order.into_iter().filter(|node| *node != start) {
            ways[before[node as usize] as usize] += ways[node as usize];
            counts[node as usize] += ways[node as usize];
        }
    }
    counts
}

fn leg_millis(roads: &Roads, leg: Leg) -> u32 {
    let road = roads.edge(leg.edge());
    (1000.0 * (road.length / roads.allowed_speed(leg) + road.delay_secs)) as u32 + 1
}

/// The search for rest places.
struct Search<'a> {
    roads: &'a Roads,
    blocks: &'a mut Blocks,
    /// By node: the legs that lead there.
    arrivals: Vec<Vec<Leg>>,
    /// By node: whether it belongs to the part of the roads that is searched, and is no rest place.
    core: Vec<bool>,
    is_rest: Vec<bool>,
    /// With the legs that a robot on them blocks, in ascending order.
    rests: Vec<(u32, Vec<usize>)>,
    /// By leg: how many rest places block it.
    blocked: Vec<u16>,
}

impl<'a> Search<'a> {
    fn new(roads: &'a Roads, blocks: &'a mut Blocks) -> Self {
        let mut arrivals = vec![Vec::new(); roads.nodes() as usize];
        for node in 0..roads.nodes() {
            for &leg in roads.exits(node) {
                arrivals[roads.end(leg) as usize].push(leg);
            }
        }
        let nodes = roads.nodes() as usize;
        let blocked = vec![0; 2 * roads.edges().len()];
        let (is_rest, rests) = (vec![false; nodes], Vec::new());
        Self { roads, blocks, arrivals, core: vec![true; nodes], is_rest, rests, blocked }
    }

    /// The parts of the roads: sets of nodes that all can be reached from each other, by node;
    /// without nodes that are a part of their own.
    fn parts(&self) -> Vec<Vec<bool>> {
        let nodes = self.roads.nodes() as usize;
        let (mut parts, mut done) = (Vec::new(), vec![false; nodes]);
        for node in 0..nodes as u32 {
            if done[node as usize] {
                continue;
            }
            let (there, back) = (self.reached(node, false), self.reached(node, true));
            let both: Vec<bool> = there.iter().zip(&back).map(|(a, b)| *a && *b).collect();
            for (done, is_both) in done.iter_mut().zip(&both) {
                *done |= *is_both;
            }
            if both.iter().filter(|is_both| **is_both).count() > 1 {
                parts.push(both);
            }
        }
        parts
    }

    /// The nodes of the core that can be reached from one, or from which it can be reached.
    fn reached(&self, from: u32, backwards: bool) -> Vec<bool> {
        let mut reached = vec![false; self.roads.nodes() as usize];
        reached[from as usize] = true;
        let mut open = vec![from];
        while let Some(node) = open.pop() {
            let legs = match backwards {
                true => self.arrivals[node as usize].as_slice(),
                false => self.roads.exits(node),
            };
            for &leg in legs.iter().filter(|leg| self.blocked[leg.index()] == 0) {
                let next = if backwards { self.roads.start(leg) } else { self.roads.end(leg) };
                if self.core[next as usize] && !reached[next as usize] {
                    reached[next as usize] = true;
                    open.push(next);
                }
            }
        }
        reached
    }

    /// Makes a node a rest place if it can be one.
    fn try_node(&mut self, node: u32) {
        let keys = self.keys(node);
        for &key in &keys {
            self.blocked[key] += 1;
        }
        self.core[node as usize] = false;
        self.rests.push((node, keys));
        if self.is_good() {
            self.is_rest[node as usize] = true;
        } else if let Some((_, keys)) = self.rests.pop() {
            self.core[node as usize] = true;
            for key in keys {
                self.blocked[key] -= 1;
            }
        }
    }

    /// The legs that robots block which stand at a node.
    fn keys(&mut self, node: u32) -> Vec<usize> {
        let mut keys = Vec::new();
        for &leg in &self.arrivals[node as usize] {
            for footprint in 0..self.roads.footprints().len() {
                let at_end = self.blocks.at_end(self.roads, footprint, leg);
                keys.extend(at_end.iter().map(|key| *key as usize));
            }
        }
        keys.retain(|key| *key < self.blocked.len());
        keys.sort_unstable();
        keys.dedup();
        keys
    }

    /// Whether robots on all rest places leave the rest of the roads in one piece, and can come
    /// and go themselves.
    fn is_good(&self) -> bool {
        let Some(first) = self.core.iter().position(|is_core| *is_core) else { return false };
        let parts = [self.reached(first as u32, false), self.reached(first as u32, true)];
        let is_whole =
            (0..self.core.len()).all(|node| !self.core[node] || (parts[0][node] && parts[1][node]));
        is_whole && self.rests.iter().all(|(rest, keys)| self.can_come_and_go(*rest, keys))
    }

    /// Whether a leg leads from the core to a rest place, and one back, that no robot on another
    /// rest place blocks.
    fn can_come_and_go(&self, rest: u32, keys: &[usize]) -> bool {
        let is_free = |leg: &Leg| {
            let own = u16::from(keys.binary_search(&leg.index()).is_ok());
            self.blocked[leg.index()] == own
        };
        let mut exits = self.roads.exits(rest).iter();
        let mut arrivals = self.arrivals[rest as usize].iter();
        exits.any(|leg| is_free(leg) && self.core[self.roads.end(*leg) as usize])
            && arrivals.any(|leg| is_free(leg) && self.core[self.roads.start(*leg) as usize])
    }
}
