//! A route graph as traffic sees it: legs by both of their ends, and the main part.

use std::collections::VecDeque;

use regatta_base::graph::{CRAWL, EdgeIndex, Gear, Leg, NodeIndex};
use regatta_base::rows::Rows;

use crate::model::components::Components;
use crate::model::route_graph::{RouteGraph, legs};

/// A graph with its legs by the node where they end.
#[derive(Debug)]
pub struct Network<'g> {
    /// The graph.
    pub graph: &'g RouteGraph,
    arrivals: Rows<Leg>,
    /// By node: the number of its strongly connected component.
    pub parts: Components,
    /// The number of the [main](Components::main) one.
    pub main: u32,
}

/// Returns the dense index of a leg: less than twice the number of edges.
pub fn leg_index(leg: Leg) -> u32 {
    2 * leg.edge.0 + u32::from(leg.gear == Gear::Reverse)
}

/// Returns the leg with a dense index.
pub fn leg_of(index: u32) -> Leg {
    let gear = if index.is_multiple_of(2) { Gear::Forward } else { Gear::Reverse };
    Leg { edge: EdgeIndex(index / 2), gear }
}

/// A direction of a search.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Search {
    /// Along legs.
    Forwards,
    /// Against them.
    Backwards,
}

impl<'g> Network<'g> {
    /// Sorts the legs of a graph.
    pub fn new(graph: &'g RouteGraph) -> Self {
        Self::around(graph, &[])
    }

    /// Sorts the legs of a graph whose main part is the one with the most of some nodes.
    pub fn around(graph: &'g RouteGraph, wanted: &[NodeIndex]) -> Self {
        let arrivals = legs(graph.edges()).map(|leg| (graph.leg_end(leg).0, leg)).collect();
        let arrivals = Rows::by_row(graph.nodes().len(), arrivals);
        let parts = Components::strong(graph);
        let main = parts.around(graph, wanted);
        Self { graph, arrivals, parts, main }
    }

    /// Number of nodes.
    pub fn nodes(&self) -> u32 {
        self.graph.nodes().len() as u32
    }

    /// The node that a leg leaves.
    pub fn start(&self, leg: Leg) -> u32 {
        self.graph.leg_start(leg).0
    }

    /// The node that a leg leads to.
    pub fn end(&self, leg: Leg) -> u32 {
        self.graph.leg_end(leg).0
    }

    /// The legs that leave a node.
    pub fn departures(&self, node: u32) -> &[Leg] {
        self.graph.departures(NodeIndex(node))
    }

    /// The legs that lead to a node.
    pub fn arrivals(&self, node: u32) -> &[Leg] {
        self.arrivals.row(node)
    }

    /// Whether a leg exists, and is no slower than a [crawl](CRAWL).
    pub fn is_way(&self, leg: Leg) -> bool {
        self.graph.leg_speed(leg) >= Some(CRAWL)
    }

    /// The ways to follow from a node in a direction, with the nodes that they come to.
    pub fn steps(&self, node: u32, search: Search) -> impl Iterator<Item = (Leg, u32)> + '_ {
        self.steps_at(node, search, CRAWL)
    }

    /// The legs of at least a speed, in metres per second, with the nodes that they come to.
    fn steps_at(
        &self,
        node: u32,
        search: Search,
        slowest: f64,
    ) -> impl Iterator<Item = (Leg, u32)> + '_ {
        let legs = match search {
            Search::Forwards => self.departures(node),
            Search::Backwards => self.arrivals(node),
        };
        let legs = legs.iter().filter(move |leg| self.graph.leg_speed(**leg) >= Some(slowest));
        legs.map(move |&leg| match search {
            Search::Forwards => (leg, self.end(leg)),
            Search::Backwards => (leg, self.start(leg)),
        })
    }

    /// The edges that start or end at a node, in ascending order. An edge that can't be driven in
    /// reverse gear counts at both of its ends.
    pub fn edges_at(&self, node: u32) -> Vec<u32> {
        let legs = self.departures(node).iter().chain(self.arrivals(node));
        let mut edges: Vec<u32> = legs.map(|leg| leg.edge.0).collect();
        edges.sort_unstable();
        edges.dedup();
        edges
    }

    /// The legs of an edge.
    pub fn legs_of(&self, edge: u32) -> impl Iterator<Item = Leg> + use<> {
        let edge = EdgeIndex(edge);
        let reverse = self.graph.edge(edge).reverse_speed.map(|_| Gear::Reverse);
        let gears = [Some(Gear::Forward), reverse].into_iter().flatten();
        gears.map(move |gear| Leg { edge, gear })
    }

    /// Whether a node belongs to the main part.
    pub fn is_main(&self, node: u32) -> bool {
        self.parts.of_node[node as usize] == self.main
    }

    /// The nodes of the main part, in ascending order.
    pub fn main_nodes(&self) -> Vec<u32> {
        (0..self.nodes()).filter(|&node| self.is_main(node)).collect()
    }

    /// Returns by node whether it can be reached from some nodes, or they from it, along legs of at
    /// least a speed, in metres per second.
    pub fn reached(&self, from: &[u32], search: Search, slowest: f64) -> Vec<bool> {
        let mut reached = vec![false; self.nodes() as usize];
        let mut open: VecDeque<u32> = from.iter().copied().collect();
        for &node in from {
            reached[node as usize] = true;
        }
        while let Some(node) = open.pop_front() {
            for (_, next) in self.steps_at(node, search, slowest) {
                if !std::mem::replace(&mut reached[next as usize], true) {
                    open.push_back(next);
                }
            }
        }
        reached
    }
}
