//! Dead ends in which no two robots can pass each other.
//!
//! A *stub* is a chain of edges that ends at a node from which only the way back leads on, and that
//! begins at the first node with another way. Only chains of two sections or more count: in one
//! section there is room for one robot anyway. A robot that drives into a stub behind another one
//! keeps that one from coming out.

use std::collections::BTreeSet;

use regatta_plugin::frame::NO_EDGE;

use super::{Leg, Roads};

/// The stubs of some roads.
#[derive(Clone, Debug, Default)]
pub struct Stubs {
    /// By edge: the number of its stub, or [`NO_EDGE`].
    numbers: Vec<u32>,
    /// By stub: its edges.
    edges: Vec<Vec<u32>>,
}

impl Stubs {
    pub(super) fn new(roads: &Roads) -> Self {
        let mut stubs = Self { numbers: vec![NO_EDGE; roads.edges().len()], edges: Vec::new() };
        let mut neighbours = vec![BTreeSet::new(); roads.nodes() as usize];
        for edge in roads.edges().iter().filter(|edge| edge.origin != edge.destination) {
            neighbours[edge.origin as usize].insert(edge.destination);
            neighbours[edge.destination as usize].insert(edge.origin);
        }
        for end in (0..roads.nodes()).filter(|&node| neighbours[node as usize].len() == 1) {
            let chain = chain(&neighbours, end);
            let is_whole_graph =
                chain.last().is_some_and(|&root| neighbours[root as usize].len() == 1);
            if chain.len() > 2 && !is_whole_graph {
                stubs.add(roads, &chain);
            }
        }
        stubs
    }

    /// Adds the edges between consecutive nodes of a chain.
    fn add(&mut self, roads: &Roads, chain: &[u32]) {
        let number = self.edges.len() as u32;
        let legs = chain[..chain.len() - 1].iter().flat_map(|&node| roads.exits(node));
        // Legs in reverse gear leave a node by an edge that leads there.
        let inside = legs.filter(|&&leg| {
            [roads.start(leg), roads.end(leg)].iter().all(|node| chain.contains(node))
        });
        let edges: BTreeSet<u32> =
            inside.map(|leg| leg.edge()).chain(arrivals(roads, chain)).collect();
        for &edge in &edges {
            self.numbers[edge as usize] = number;
        }
        self.edges.push(edges.into_iter().collect());
    }

    /// The number of the stub that an edge belongs to.
    pub fn of(&self, edge: u32) -> Option<u32> {
        self.numbers.get(edge as usize).copied().filter(|number| *number != NO_EDGE)
    }

    /// The edges of a stub, in ascending order.
    pub fn edges(&self, stub: u32) -> &[u32] {
        &self.edges[stub as usize]
    }
}

/// The edges that lead from the first node of a chain, its root, into it.
fn arrivals(roads: &Roads, chain: &[u32]) -> Vec<u32> {
    let [.., before, root] = *chain else { return Vec::new() };
    roads
        .exits(root)
        .iter()
        .copied()
        .filter(|&leg| roads.end(leg) == before)
        .map(Leg::edge)
        .collect()
}

/// Returns the nodes from a dead end to the first one with more than one way on.
fn chain(neighbours: &[BTreeSet<u32>], end: u32) -> Vec<u32> {
    let mut chain = vec![end];
    let mut before = end;
    let mut node = neighbours[end as usize].first().copied();
    while let Some(current) = node {
        chain.push(current);
        let others = &neighbours[current as usize];
        node = others.iter().copied().find(|&other| other != before).filter(|_| others.len() == 2);
        before = current;
    }
    chain
}
