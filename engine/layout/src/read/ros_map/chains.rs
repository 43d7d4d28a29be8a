//! Lines of cells between junctions and ends of a skeleton.

use std::collections::{BTreeMap, BTreeSet};

use super::roadmap::Space;
use super::skeleton::NEIGHBOURS;

/// The largest number of rounds of pruning.
const MAX_ROUNDS: usize = 20;

/// Junctions that are connected by roads of at most this many cells are merged.
const SAME_JUNCTION: usize = 3;

/// Returns the lines of cells between junctions and ends.
pub fn trace(cells: &[u32], space: &Space) -> Vec<Vec<u32>> {
    let mut tracer =
        Tracer { on: vec![false; space.squares.len()], width: space.width, left: BTreeSet::new() };
    for &cell in cells {
        tracer.on[cell as usize] = true;
    }
    let nodes: BTreeSet<u32> =
        cells.iter().copied().filter(|&cell| tracer.neighbours(cell).count() != 2).collect();
    let mut chains = Vec::new();
    for &node in cells.iter().filter(|cell| nodes.contains(cell)) {
        let nexts: Vec<u32> = tracer.neighbours(node).collect();
        chains.extend(
            nexts
                .into_iter()
                .filter_map(|next| tracer.follow(node, next, |cell| nodes.contains(&cell))),
        );
    }
    // The remaining cells are loops without a junction.
    let mut seen: BTreeSet<u32> = chains.iter().flatten().copied().collect();
    for &start in cells {
        let next = tracer.neighbours(start).next();
        let Some(next) = next.filter(|_| !nodes.contains(&start) && !seen.contains(&start)) else {
            continue;
        };
        let chain = tracer.follow(start, next, |cell| cell == start);
        seen.extend(chain.iter().flatten());
        chains.extend(chain);
    }
    chains
}

struct Tracer {
    on: Vec<bool>,
    width: usize,
    /// Nodes with the first cell of a chain that starts there and has been followed from its other
    /// end.
    left: BTreeSet<(u32, u32)>,
}

impl Tracer {
    /// Returns the neighbours of a cell on the skeleton; a diagonal one only if no other connects
    /// them.
    fn neighbours(&self, cell: u32) -> impl Iterator<Item = u32> {
        let (cell, width) = (cell as usize, self.width as isize);
        let at = move |[x, y]: [isize; 2]| cell.wrapping_add_signed(x + y * width);
        NEIGHBOURS.into_iter().filter_map(move |[x, y]| {
            let is_diagonal = x != 0 && y != 0;
            let connected = is_diagonal && (self.on[at([x, 0])] || self.on[at([0, y])]);
            (self.on[at([x, y])] && !connected).then(|| at([x, y]) as u32)
        })
    }

    /// Follows a line of cells to the next node; `None` if that has been done from its other end.
    fn follow(&mut self, start: u32, next: u32, is_node: impl Fn(u32) -> bool) -> Option<Vec<u32>> {
        if self.left.contains(&(start, next)) {
            return None;
        }
        let mut chain = vec![start, next];
        let (mut before, mut cell) = (start, next);
        while !is_node(cell) {
            let Some(after) = self.neighbours(cell).find(|&after| after != before) else { break };
            (before, cell) = (cell, after);
            chain.push(cell);
        }
        self.left.insert((start, next));
        self.left.insert((cell, before));
        Some(chain)
    }
}

/// Lines of cells between nodes, each at least two.
pub struct Chains<'a> {
    pub chains: Vec<Vec<u32>>,
    pub space: &'a Space,
}

fn ends(chain: &[u32]) -> [u32; 2] {
    [chain[0], chain[chain.len() - 1]]
}

impl Chains<'_> {
    fn length(&self, chain: &[u32]) -> f64 {
        chain
            .windows(2)
            .map(|pair| self.space.centre(pair[0]).distance(self.space.centre(pair[1])))
            .sum()
    }

    fn degrees(&self) -> BTreeMap<u32, u32> {
        let mut degrees = BTreeMap::new();
        for end in self.chains.iter().flat_map(|chain| ends(chain)) {
            *degrees.entry(end).or_insert(0) += 1;
        }
        degrees
    }

    /// Removes dead ends that are shorter than the robot's width, or that don't leave the free
    /// space around their junction.
    pub fn prune(&mut self, robot_cells: f64) {
        for _ in 0..MAX_ROUNDS {
            let degrees = self.degrees();
            let before = self.chains.len();
            let mut chains = std::mem::take(&mut self.chains);
            chains.retain(|chain| !self.is_spur(chain, &degrees, robot_cells));
            self.chains = chains;
            self.join_through();
            if self.chains.len() == before {
                return;
            }
        }
    }

    fn is_spur(&self, chain: &[u32], degrees: &BTreeMap<u32, u32>, robot_cells: f64) -> bool {
        let [a, b] = ends(chain);
        let junction = match (degrees[&a], degrees[&b]) {
            (1, 3..) => b,
            (3.., 1) => a,
            _ => return false,
        };
        self.length(chain) < robot_cells.max(self.space.distance(junction))
    }

    /// Joins the two chains at each node that has exactly two.
    fn join_through(&mut self) {
        let mut at: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
        for (index, chain) in self.chains.iter().enumerate() {
            for end in ends(chain) {
                at.entry(end).or_default().push(index);
            }
        }
        let nodes: Vec<u32> =
            at.iter().filter(|(_, chains)| chains.len() == 2).map(|(&node, _)| node).collect();
        for node in nodes {
            let [first, second] = at[&node][..] else { continue };
            if first == second {
                continue;
            }
            let mut joined = std::mem::take(&mut self.chains[first]);
            let mut rest = std::mem::take(&mut self.chains[second]);
            if ends(&joined)[1] != node {
                joined.reverse();
            }
            if rest[0] != node {
                rest.reverse();
            }
            joined.extend(&rest[1..]);
            let far = ends(&rest)[1];
            for index in at.entry(far).or_default() {
                if *index == second {
                    *index = first;
                }
            }
            self.chains[first] = joined;
        }
        self.chains.retain(|chain| !chain.is_empty());
    }

    /// Merges adjacent junctions.
    pub fn merge_junctions(&mut self) {
        let degrees = self.degrees();
        let (links, mut others): (Vec<_>, Vec<_>) = self.chains.drain(..).partition(|chain| {
            let [a, b] = ends(chain);
            chain.len() <= SAME_JUNCTION && a != b && degrees[&a] > 2 && degrees[&b] > 2
        });
        // A junction moves at most once, and not to a junction that moves.
        let mut moved: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        let mut targets = BTreeSet::new();
        for link in links {
            let [to, from] = ends(&link);
            if moved.contains_key(&from) || moved.contains_key(&to) || targets.contains(&from) {
                others.push(link);
                continue;
            }
            targets.insert(to);
            moved.insert(from, link);
        }
        for chain in &mut others {
            for _ in 0..2 {
                if let Some(link) = moved.get(&chain[chain.len() - 1]) {
                    chain.extend(link.iter().rev().skip(1));
                }
                chain.reverse();
            }
        }
        others.retain(|chain| ends(chain)[0] != ends(chain)[1] || chain.len() > 4 * SAME_JUNCTION);
        self.chains = others;
    }

    /// Divides loops in the middle.
    pub fn split_loops(&mut self) {
        for index in 0..self.chains.len() {
            let chain = &mut self.chains[index];
            if chain[0] == chain[chain.len() - 1] && chain.len() > 2 {
                let rest = chain.split_off(chain.len() / 2);
                chain.push(rest[0]);
                self.chains.push(rest);
            }
        }
        self.chains.retain(|chain| chain.len() > 1 && chain[0] != chain[chain.len() - 1]);
    }

    /// Removes connected parts below a length in cells. Returns their number and their total
    /// length.
    pub fn drop_short_parts(&mut self, least: f64) -> (usize, f64) {
        let numbers: BTreeMap<u32, usize> = self.degrees().into_keys().zip(0..).collect();
        let mut parents: Vec<usize> = (0..numbers.len()).collect();
        for chain in &self.chains {
            let [a, b] = ends(chain).map(|end| root(&mut parents, numbers[&end]));
            parents[a] = b;
        }
        let mut lengths = vec![0.0; parents.len()];
        let parts: Vec<usize> =
            self.chains.iter().map(|chain| root(&mut parents, numbers[&chain[0]])).collect();
        for (chain, &part) in self.chains.iter().zip(&parts) {
            lengths[part] += self.length(chain);
        }
        let dropped: Vec<f64> =
            lengths.iter().copied().filter(|&length| length > 0.0 && length < least).collect();
        let mut part = parts.into_iter();
        self.chains.retain(|_| part.next().is_some_and(|part| lengths[part] >= least));
        (dropped.len(), dropped.iter().sum())
    }
}

/// Returns the root of a node in a forest, and shortens the path to it.
fn root(parents: &mut [usize], mut node: usize) -> usize {
    while parents[node] != node {
        parents[node] = parents[parents[node]];
        node = parents[node];
    }
    node
}
