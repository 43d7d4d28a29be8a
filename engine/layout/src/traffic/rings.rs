//! Rings: robots that all wait for the next one.
//!
//! A robot at a node may wait for a robot at another node if that one blocks a way that leaves the
//! first node. Both must be able to stand there at once. A *ring* of robots are nodes of which none
//! touch, each of which may wait for the next one, and the last one for the first; and no smaller
//! ring is among them. Two robots that wait for each other are the ring of two: mostly they face
//! each other on a single track. Larger rings are searched for without such pairs.

use std::collections::VecDeque;

use regatta_base::graph::NodeIndex;
use regatta_base::rows::Rows;

use super::conflicts::Conflicts;
use super::network::{Network, Search as Direction};
use super::room::Certainty;

/// The largest number of rings that are returned.
pub const MOST_RINGS: usize = 5;
/// The largest number of steps that the search takes: a wait looked at is one, for each robot of a
/// ring.
const MOST_STEPS: u64 = 40_000_000;
/// The largest number of robots in the rings that are searched for first; twice as many then.
const FIRST_ROBOTS: usize = 4;

/// The rings of a layout.
#[derive(Clone, Debug, PartialEq)]
pub struct Rings {
    /// The number of pairs of nodes at which two robots may wait for each other.
    pub pairs: usize,
    /// The number of further pairs at which a zone never lets both robots stand.
    pub kept_apart: usize,
    /// One of these pairs.
    pub pair: Option<(NodeIndex, NodeIndex)>,
    /// The smallest rings of three robots or more, smallest first: at most [`MOST_RINGS`].
    pub smallest: Vec<Vec<NodeIndex>>,
    /// The rings of three robots or more that aren't among those here.
    pub others: Others,
    /// Exact if no ring of three robots or more is smaller than the smallest one here, and there is
    /// none at all if there is none here.
    pub certainty: Certainty,
}

/// The rings that a search hasn't returned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Others {
    /// There are none.
    None,
    /// There are some.
    Some,
    /// There may be some: the search was stopped.
    Unknown,
}

impl Rings {
    /// The fewest robots that may all wait for the next one; `None` if no ring is known.
    pub fn fewest(&self) -> Option<usize> {
        if self.pairs > 0 { Some(2) } else { self.smallest.first().map(Vec::len) }
    }
}

/// Finds the smallest rings.
pub fn rings(network: &Network<'_>, conflicts: &Conflicts) -> Rings {
    let waits = waits(network, conflicts);
    let (mut pairs, mut one_sided) = (Vec::new(), Vec::new());
    for node in 0..network.nodes() {
        for &other in waits.row(node) {
            match is_wait(&waits, other, node) {
                true if node < other => pairs.push((NodeIndex(node), NodeIndex(other))),
                true => (),
                false => one_sided.push((node, other)),
            }
        }
    }
    let one_sided = Rows::of_sorted(network.nodes() as usize, one_sided);
    let mut search = Search::new(conflicts, &waits, &one_sided);
    let others = search.run();
    let is_unknown = search.found.is_empty() && others == Others::Unknown;
    let certainty = if is_unknown { Certainty::Bound } else { search.certainty };
    let smallest = search.found.into_iter().map(|ring| ring.into_iter().map(NodeIndex).collect());
    let smallest = smallest.collect();
    let all = pairs.len();
    let zones = network.graph.zones();
    pairs.retain(|(one, other)| !zones.iter().any(|zone| zone.keeps_apart(&[*one, *other])));
    let (pair, kept_apart, pairs) = (pairs.first().copied(), all - pairs.len(), pairs.len());
    Rings { pairs, kept_apart, pair, smallest, others, certainty }
}

/// By node: the nodes for whose robots a robot may wait.
fn waits(network: &Network<'_>, conflicts: &Conflicts) -> Rows<u32> {
    let mut waits = Vec::new();
    for node in 0..network.nodes() {
        let ways = network.steps(node, Direction::Forwards);
        let mut others: Vec<u32> =
            ways.flat_map(|(leg, _)| conflicts.blockers(leg)).copied().collect();
        others.sort_unstable();
        others.dedup();
        others.retain(|&other| !conflicts.is_touching(node, other));
        waits.extend(others.into_iter().map(|other| (node, other)));
    }
    Rows::of_sorted(network.nodes() as usize, waits)
}

/// Returns by node whether all ways along `next` from it end somewhere. `before` has the same pairs
/// of nodes by the second one.
fn without_next(next: &Rows<u32>, before: &Rows<u32>) -> Vec<bool> {
    let count = next.len() as u32;
    let mut left: Vec<usize> = (0..count).map(|node| next.row(node).len()).collect();
    let mut ends = vec![false; left.len()];
    let mut open: Vec<u32> = (0..count).filter(|&node| left[node as usize] == 0).collect();
    while let Some(node) = open.pop() {
        ends[node as usize] = true;
        for &other in before.row(node) {
            left[other as usize] -= 1;
            if left[other as usize] == 0 {
                open.push(other);
            }
        }
    }
    ends
}

fn is_wait(waits: &Rows<u32>, from: u32, to: u32) -> bool {
    waits.row(from).binary_search(&to).is_ok()
}

/// The search for rings of three robots or more, from small ones to large ones.
struct Search<'a> {
    conflicts: &'a Conflicts,
    /// All waits.
    waits: &'a Rows<u32>,
    /// Those without the one back.
    one_sided: &'a Rows<u32>,
    /// The same, by the node waited for.
    waiting: Rows<u32>,
    steps: u64,
    /// By node: the number of waits to the first node of a ring; `u32::MAX` if there are too many.
    distance: Vec<u32>,
    /// The first rings.
    found: Vec<Vec<u32>>,
    /// Exact if they are the smallest ones.
    certainty: Certainty,
}

/// The reason to end a search.
enum Stop {
    /// There is one ring more than are returned.
    Enough,
    /// It took too many steps.
    TooLong,
}

impl<'a> Search<'a> {
    fn new(conflicts: &'a Conflicts, waits: &'a Rows<u32>, one_sided: &'a Rows<u32>) -> Self {
        let count = one_sided.len();
        let backwards = (0..count as u32)
            .flat_map(|node| one_sided.row(node).iter().map(move |&other| (other, node)));
        let waiting = Rows::new(count, backwards.collect());
        let distance = vec![u32::MAX; count];
        let (found, certainty) = (Vec::new(), Certainty::Exact);
        Self { conflicts, waits, one_sided, waiting, steps: 0, distance, found, certainty }
    }

    /// Finds the smallest rings, and says whether there are others.
    fn run(&mut self) -> Others {
        match self.find() {
            Ok(()) => Others::None,
            Err(Stop::Enough) => Others::Some,
            Err(Stop::TooLong) => Others::Unknown,
        }
    }

    /// Finds all rings: the limit of robots doubles until there can't be larger ones.
    fn find(&mut self) -> Result<(), Stop> {
        let nodes = self.nodes_in_cycles();
        let (mut done, mut limit) = (2, FIRST_ROBOTS);
        while done < nodes.len() {
            let starts = self.starts(&nodes, limit);
            if self.check_steps().is_err() {
                return if self.found.is_empty() {
                    self.find_some(starts)
                } else {
                    Err(Stop::TooLong)
                };
            }
            for robots in done + 1..=limit.min(nodes.len()) {
                for start in starts.iter().filter(|start| start.fewest <= robots) {
                    self.find_from(start.node, robots)?;
                }
            }
            (done, limit) = (limit, 2 * limit);
        }
        Ok(())
    }

    /// Returns the nodes that may belong to a ring: those left when nodes that wait for nobody, and
    /// nodes that nobody waits for, are taken away again and again.
    fn nodes_in_cycles(&self) -> Vec<u32> {
        let waits = without_next(self.one_sided, &self.waiting);
        let waited_for = without_next(&self.waiting, self.one_sided);
        let nodes = 0..self.one_sided.len() as u32;
        nodes.filter(|&node| !waits[node as usize] && !waited_for[node as usize]).collect()
    }

    /// Finds the smallest rings that begin with some nodes, when there is no time for all of them.
    fn find_some(&mut self, mut starts: Vec<Start>) -> Result<(), Stop> {
        starts.sort_by_key(|start| (start.fewest, start.node));
        (self.steps, self.certainty) = (0, Certainty::Bound);
        for start in starts {
            self.find_from(start.node, start.fewest)?;
        }
        Err(Stop::TooLong)
    }

    /// Returns the nodes with which rings of at most `limit` robots may begin; not all of them if
    /// that takes too many steps.
    fn starts(&mut self, nodes: &[u32], limit: usize) -> Vec<Start> {
        let mut starts = Vec::new();
        for &node in nodes {
            let reached = self.set_distances(node, limit);
            let next = self.one_sided.row(node).iter();
            let nearest = next.map(|&next| self.distance[next as usize]).min();
            starts.extend(
                nearest
                    .filter(|distance| *distance != u32::MAX)
                    .map(|distance| Start { node, fewest: distance as usize + 1 }),
            );
            self.forget_distances(&reached);
            if self.check_steps().is_err() {
                break;
            }
        }
        starts
    }

    /// Finds the rings of so many robots that begin with a node and have later nodes otherwise.
    fn find_from(&mut self, start: u32, robots: usize) -> Result<(), Stop> {
        let reached = self.set_distances(start, robots);
        let end = self.extend(&mut vec![start], robots);
        self.forget_distances(&reached);
        end
    }

    /// Sets the distances of nodes after a start to it, less than `limit`. Returns these nodes.
    fn set_distances(&mut self, start: u32, limit: usize) -> Vec<u32> {
        self.distance[start as usize] = 0;
        let (mut reached, mut open) = (vec![start], VecDeque::from([start]));
        while let Some(node) = open.pop_front() {
            let distance = self.distance[node as usize] + 1;
            if distance as usize >= limit {
                break;
            }
            for &other in self.waiting.row(node) {
                self.steps += 1;
                if other > start && self.distance[other as usize] == u32::MAX {
                    self.distance[other as usize] = distance;
                    reached.push(other);
                    open.push_back(other);
                }
            }
        }
        reached
    }

    fn forget_distances(&mut self, reached: &[u32]) {
        for &node in reached {
            self.distance[node as usize] = u32::MAX;
        }
    }

    /// Extends the beginning of a ring to all rings of so many robots, and keeps them.
    fn extend(&mut self, ring: &mut Vec<u32>, robots: usize) -> Result<(), Stop> {
        let (start, last) = (ring[0], ring[ring.len() - 1]);
        if ring.len() == robots {
            return match self.one_sided.row(last).binary_search(&start) {
                Ok(_) => self.keep(ring),
                Err(_) => Ok(()),
            };
        }
        let left = (robots - ring.len()) as u32;
        let one_sided = self.one_sided;
        for &next in one_sided.row(last) {
            self.steps += ring.len() as u64;
            let distance = self.distance[next as usize];
            if next > start && distance <= left && self.fits(ring, next, robots) {
                ring.push(next);
                self.extend(ring, robots)?;
                ring.pop();
            }
            self.check_steps()?;
        }
        Ok(())
    }

    fn keep(&mut self, ring: &[u32]) -> Result<(), Stop> {
        if self.found.len() == MOST_RINGS {
            return Err(Stop::Enough);
        }
        self.found.push(ring.to_vec());
        Ok(())
    }

    fn check_steps(&self) -> Result<(), Stop> {
        if self.steps > MOST_STEPS { Err(Stop::TooLong) } else { Ok(()) }
    }

    /// Whether a robot at a node touches none of a ring, waits for none of it except where the ring
    /// closes, and only the last one waits for it: otherwise a smaller ring is among them.
    fn fits(&self, ring: &[u32], next: u32, robots: usize) -> bool {
        let closes = ring.len() + 1 == robots;
        ring.iter().enumerate().all(|(place, &member)| {
            let may_be_waited_for = place == 0 && closes;
            let may_wait = place + 1 == ring.len();
            member != next
                && !self.conflicts.is_touching(member, next)
                && (may_be_waited_for || !self.is_wait(next, member))
                && (may_wait || !self.is_wait(member, next))
        })
    }

    fn is_wait(&self, from: u32, to: u32) -> bool {
        is_wait(self.waits, from, to)
    }
}

/// A node with which rings may begin.
struct Start {
    node: u32,
    /// The fewest robots of these rings.
    fewest: usize,
}
